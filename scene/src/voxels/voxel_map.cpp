#include "maille/scene/voxel_map.hpp"

#include "maille/images/layers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace maille {

namespace {

bool has_same_axes(const ImageInfo& info, const Placement& placement) {
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t a = 0; a < 3; ++a)
      if (std::abs(info.direction[row][a] - placement.direction[row][a]) > 1e-4)
        return false;
  return true;
}

} // namespace

ImageInfo in_world_of(const ImageInfo& info, const Specimen& body) {
  const Placement& placement = body.placement;
  ImageInfo turned = in_world(info, placement.world);
  if (info.world == placement.world)
    return turned;
  ImageInfo same = info;
  same.world = placement.world;
  const auto is_there = [&](const ImageInfo& one) {
    return voxel_blocks(along_axes(one, placement.direction), body).has_value();
  };
  if (is_there(turned) || !is_there(same))
    return turned;
  const bool is_stated =
      info.states_world && (body.image.empty() || read_image_info(body.image).states_world);
  return is_stated ? turned : same;
}

ImageInfo on_body(const ImageInfo& info, const Specimen& body) {
  return along_axes(in_world_of(info, body), body.placement.direction);
}

void place_on(LayeredImage& image, const Specimen& body) {
  const ImageInfo there = in_world_of(image.info(), body);
  if (there.world != image.info().world && there.direction == image.info().direction)
    warn_of_file(image.path(),
                 "is taken to be in the world of the body's image, on whose voxels it is: one of "
                 "them states no orientation");
  image.place(there, body.placement.direction);
}

std::optional<VoxelBlocks> voxel_blocks(const ImageInfo& info, const Specimen& body) {
  if (!has_same_axes(info, body.placement))
    return std::nullopt;
  const Vec3 centre = point_in_object(body.placement, info.origin);
  VoxelBlocks blocks;
  for (std::size_t a = 0; a < 3; ++a) {
    const double ratio = body.grid.spacing()[a] / info.spacing[a];
    const double offset = (body.origin[a] - (centre[a] - info.spacing[a] / 2)) / info.spacing[a];
    const double whole = std::round(ratio), first = std::round(offset);
    // Tolerance over the whole body, because headers are float32.
    constexpr double tolerance = 0.01, most = 1e9;
    const bool is_whole = whole >= 1 && whole < most &&
                          std::abs(ratio - whole) * body.grid.cells()[a] <= tolerance &&
                          std::abs(offset - first) <= tolerance && std::abs(first) < most;
    if (!is_whole)
      return std::nullopt;
    blocks.per_cell[a] = static_cast<int>(whole);
    blocks.first[a] = static_cast<int>(first);
  }
  return blocks;
}

std::optional<Image>
on_voxels(const ImageInfo& info, const Specimen& body, int components,
          const std::function<void(std::int64_t cell, std::span<float> values)>& values) {
  const auto blocks = voxel_blocks(info, body);
  if (!blocks)
    return std::nullopt;
  Image image;
  image.info = info;
  image.info.components = components;
  const std::size_t n = info.n_voxels();
  image.values.assign(n * static_cast<std::size_t>(components), 0);
  std::vector<float> of_cell(components);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    if (!body.is_matter(cell))
      continue;
    values(cell, of_cell);
    const Index3 at = body.grid.cell_at(cell);
    Index3 low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(0, blocks->first[a] + at[a] * blocks->per_cell[a]);
      high[a] = std::min(blocks->first[a] + (at[a] + 1) * blocks->per_cell[a], info.size[a]);
    }
    for (int k = low[2]; k < high[2]; ++k)
      for (int j = low[1]; j < high[1]; ++j)
        for (int i = low[0]; i < high[0]; ++i) {
          const auto voxel =
              static_cast<std::size_t>(i + std::int64_t{info.size[0]} * (j + std::int64_t{info.size[1]} * k));
          for (std::size_t c = 0; c < of_cell.size(); ++c)
            image.values[c * n + voxel] = of_cell[c];
        }
  }
  return image;
}

} // namespace maille
