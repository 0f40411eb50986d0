#pragma once
/// Pieces of a body: cells that are joined through faces.

#include "maille/scene/scene.hpp"

#include <cstdint>
#include <vector>

namespace maille::reader {

/// Removes the pieces (cells joined through faces) that hold none of `anchors`; names them in scene.left_out.
/// @return number of cells that stay
std::int64_t leave_out_loose_pieces(Scene& scene, const std::vector<std::int64_t>& anchors);

/// Cuts the specimen's grid down to its matter; the origin moves along. @return where its first cell was
Index3 crop_to_matter(Specimen& specimen);

} // namespace maille::reader
