#pragma once
/// What is asked of a picture: whether it can be, and each object's part of it. Private to render.

#include "prepare/prepared_object.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace maille::render {

/// @throws std::invalid_argument as Renderer::render does
void check_request(std::span<const SceneObject> objects, const View& view);
/// Casts all tiles that an object may be in; the others become empty. @return how many rays that were
std::int64_t cast_tiles(const PreparedObject& prepared, const View& view, int threads,
                        std::vector<TileRuns>& tiles);

} // namespace maille::render
