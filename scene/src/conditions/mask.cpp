#include "conditions/places_in_files.hpp"
#include "maille/scene/voxel_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::reader {

namespace {

class Mask {
public:
  Mask(LayerWindow image, const std::vector<LabelRange>& ranges, const Specimen& body,
       const std::optional<VoxelBlocks>& blocks)
      : image_(std::move(image)), ranges_(ranges), body_(body), blocks_(blocks) {}

  /// Moves to layer k; cells of lower layers are no longer available.
  void move_to(int k) {
    if (blocks_)
      image_.move_to(blocks_->first[2] + k * blocks_->per_cell[2],
                     blocks_->first[2] + (k + 1) * blocks_->per_cell[2]);
    else
      image_.move_to(0, image_.info().size[2]);
  }

  /// Reads the rest: damage after the layers of the body is a fault, too.
  void move_to_end() { image_.move_to(image_.info().size[2], image_.info().size[2]); }

  /// True if the cell at `at`, which may be outside the body's grid, is marked.
  bool has_cell(const Index3& at) const { return blocks_ ? has_most_of(at) : has_middle_of(at); }

private:
  bool has_voxel(const Index3& v) const {
    const Index3& size = image_.info().size;
    for (std::size_t a = 0; a < 3; ++a)
      if (v[a] < 0 || v[a] >= size[a])
        return false;
    const float value = image_.at(v);
    return std::isfinite(value) && material_of(value, ranges_) != no_material;
  }
  bool has_most_of(const Index3& at) const {
    Index3 low{};
    for (std::size_t a = 0; a < 3; ++a)
      low[a] = blocks_->first[a] + at[a] * blocks_->per_cell[a];
    const Index3& n = blocks_->per_cell;
    int marked = 0;
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i)
          marked += has_voxel({low[0] + i, low[1] + j, low[2] + k}) ? 1 : 0;
    return 2 * marked >= n[0] * n[1] * n[2];
  }
  bool has_middle_of(const Index3& at) const {
    Vec3 middle = body_.origin;
    for (std::size_t a = 0; a < 3; ++a)
      middle[a] += (at[a] + 0.5) * body_.grid.spacing()[a];
    const Vec3 world = point_in_world(body_.placement, middle);
    const ImageInfo& info = image_.info();
    Index3 voxel{};
    for (std::size_t a = 0; a < 3; ++a) {
      double index = 0;
      for (std::size_t row = 0; row < 3; ++row)
        index += info.direction[row][a] * (world[row] - info.origin[row]);
      voxel[a] = static_cast<int>(std::floor(std::clamp(index / info.spacing[a] + 0.5, -2.0, 2e9)));
    }
    return has_voxel(voxel);
  }

  LayerWindow image_;
  const std::vector<LabelRange>& ranges_;
  const Specimen& body_;
  const std::optional<VoxelBlocks>& blocks_;
};

} // namespace

OrFault<Region> region_of_mask(const std::filesystem::path& file, const std::vector<LabelRange>& ranges,
                               bool resample, const Specimen& body) {
  LayeredImage image(file);
  place_on(image, body);
  image.round_to(single_labels(ranges));
  const ImageInfo& info = image.info();
  if (info.components != 1)
    return RegionFault{"an image of labels: one value a voxel",
                       fmt::format("{} values a voxel", info.components)};
  const auto blocks = resample ? std::nullopt : voxel_blocks(info, body);
  if (!resample && !blocks)
    return RegionFault{
        "a mask on the body's own voxels, or those that its cells are merged of; with resample = "
        "true the voxel at the middle of each cell counts",
        fmt::format("voxels of {:.5g} x {:.5g} x {:.5g} mm, {} x {} x {}, that lie otherwise",
                    1e3 * info.spacing[0], 1e3 * info.spacing[1], 1e3 * info.spacing[2], info.size[0],
                    info.size[1], info.size[2])};
  const std::vector<LabelRange> counted = ranges.empty() ? all_but_zero() : ranges;
  Mask mask(image.open(blocks ? blocks->per_cell[2] : info.size[2]), counted, body, blocks);
  // Includes one layer of cells around the grid, which the body's border touches.
  const Grid& grid = body.grid;
  Index3 low{-1, -1, -1}, high{grid.cells()[0] + 1, grid.cells()[1] + 1, grid.cells()[2] + 1};
  if (grid.dimension() == 2) {
    low[2] = 0;
    high[2] = 1;
  }
  std::vector<std::int64_t> nodes, cells;
  for (int k = low[2]; k < high[2]; ++k) {
    mask.move_to(k);
    for (int j = low[1]; j < high[1]; ++j)
      for (int i = low[0]; i < high[0]; ++i) {
        const Index3 at{i, j, k};
        if (!mask.has_cell(at))
          continue;
        if (grid.has_cell(at))
          cells.push_back(grid.cell(at));
        for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
          const Index3 node{i + (corner & 1), j + ((corner >> 1) & 1), k + ((corner >> 2) & 1)};
          if (grid.has_node(node))
            nodes.push_back(grid.node(node));
        }
      }
  }
  mask.move_to_end();
  return Region::numbered(std::move(nodes), std::move(cells));
}

} // namespace maille::reader
