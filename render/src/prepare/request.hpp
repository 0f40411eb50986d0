#pragma once
/// Validates the request of a picture, and casts each object's part of it. Private to render.

#include "prepare/prepared_object.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace maille::render {

/// @throws std::invalid_argument as Renderer::render does
void check_request(std::span<const SceneObject> objects, const View& view);
/// Casts all tiles that an object may cover; the others become empty. @return number of rays
std::int64_t cast_tiles(const PreparedObject& prepared, const View& view, int threads,
                        std::vector<TileRuns>& tiles);

} // namespace maille::render
