#pragma once
/// Values of a body's cells as an image on the voxels that the body was read from, which any viewer shows in
/// register with the scan.

#include "maille/images/image.hpp"
#include "maille/images/write_image.hpp"
#include "maille/scene/scene.hpp"

#include <functional>
#include <span>

namespace maille {

class LayeredImage;

/// An image's header in the body's world: x and y change sign between LPS and RAS. If one of the two states
/// no world, it takes that of the other if only this aligns the body's cells with the voxels.
ImageInfo in_world_of(const ImageInfo& info, const Specimen& body);

/// The same with its axes in the body's order and directions, if they are parallel.
ImageInfo on_body(const ImageInfo& info, const Specimen& body);

/// Reorients an image to a body's world and axes, see on_body.
void place_on(LayeredImage& image, const Specimen& body);

/// Position of a body's cells in an image: cell c of an axis covers voxels from first + c * per_cell on.
struct VoxelBlocks {
  Index3 first{}, per_cell{};
};
/// Nothing if cells are not whole blocks of the image's voxels, to a hundredth of a voxel.
std::optional<VoxelBlocks> voxel_blocks(const ImageInfo& info, const Specimen& body);

/// Every voxel of a cell of matter takes the cell's values; others are 0.
///
/// @param info       header of an image whose voxels form the cells, e.g. the one that the body was read from
/// @param values     writes the `components` values of a cell to the span
/// @return an image on the same grid; nothing if cells are not blocks of its voxels
/// Cost              O(voxels), components x 4 bytes each
std::optional<Image> on_voxels(const ImageInfo& info, const Specimen& body, int components,
                               const std::function<void(std::int64_t cell, std::span<float> values)>& values);

} // namespace maille
