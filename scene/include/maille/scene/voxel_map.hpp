#pragma once
/// Values of a body's cells as an image on the voxels that the body was read from, which lies over the scan
/// in any viewer.

#include "maille/images/image.hpp"
#include "maille/images/write_image.hpp"
#include "maille/scene/scene.hpp"

#include <functional>
#include <span>

namespace maille {

class LayeredImage;

/// An image's header in the body's world: x and y turned over between LPS and RAS. Of two images one of
/// which states no world, that one is in the other's where only this puts the body's cells on its voxels.
ImageInfo in_world_of(const ImageInfo& info, const Specimen& body);

/// The same with its axes in the body's order and directions, where they run along them.
ImageInfo on_body(const ImageInfo& info, const Specimen& body);

/// Turns an image to a body's world and axes, see on_body.
void place_on(LayeredImage& image, const Specimen& body);

/// Where a body's cells lie among the voxels of an image: cell c along an axis holds the voxels from
/// first + c * per_cell on.
struct VoxelBlocks {
  Index3 first{}, per_cell{};
};
/// Nothing where cells are not whole blocks of the image's voxels, to a hundredth of a voxel.
std::optional<VoxelBlocks> voxel_blocks(const ImageInfo& info, const Specimen& body);

/// Every voxel of a cell of matter takes the cell's values; what is no matter is 0.
///
/// @param info       of an image whose voxels the body's cells are merged of, e.g. the one it was read from
/// @param values     of a cell: `components` numbers, to be written to the span
/// @return an image on the same grid; nothing where cells are not blocks of its voxels
/// Cost              O(voxels), components x 4 bytes each
std::optional<Image> on_voxels(const ImageInfo& info, const Specimen& body, int components,
                               const std::function<void(std::int64_t cell, std::span<float> values)>& values);

} // namespace maille
