#pragma once
/// Values of a body's cells as an image on the voxels that the body was read from, which lies over the scan
/// in any viewer.

#include "maille/scene/image.hpp"
#include "maille/scene/scene.hpp"
#include "maille/scene/write_image.hpp"

#include <functional>
#include <span>

namespace maille {

/// An image's header in the body's world: x and y turned over between LPS and RAS. Of two images one of
/// which states no world, that one is in the other's where only this puts the body's cells on its voxels.
ImageInfo in_world_of(const ImageInfo& info, const Specimen& body);

/// The same with its axes in the body's order and directions, where they run along them.
ImageInfo on_body(const ImageInfo& info, const Specimen& body);

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

/// Numbers of an array of a file that write_vtk wrote (.vti, .vtu), by the array's name; none where the file
/// has no such array. Bounded as images are: memory follows the file and `tuples`.
/// @param tuples of the array at nodes, as many as the file must have; 0: an array beside the grid, of which
///        the first `components` numbers or letters are read
/// @throws InputError: damaged, cut short, another number of points
std::vector<double> read_vtk_array(const std::filesystem::path& file, std::string_view name,
                                   std::int64_t tuples, std::int64_t components);

} // namespace maille
