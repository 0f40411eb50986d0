// Makes the volume of a body: from its matter, or from the grey values of its look.

#include "maille/base/vectors.hpp"
#include "maille/render/volume.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace maille::render {

namespace {

/// Two passes of smoothing per axis vanish at this distance outside matter.
constexpr int margin = 3;
/// Bodies with at most this many cells along an axis stay sharp there: smoothing from both sides would shrink
/// their other faces and open gaps between adjacent bodies.
constexpr int plate = 4;

void smooth_along(std::vector<float>& values, const Index3& size, std::size_t axis) {
  const std::array<std::int64_t, 3> strides{1, size[0], std::int64_t{size[0]} * size[1]};
  const std::int64_t stride = strides[axis], n = std::ssize(values);
  const std::int64_t row = size[axis];
  std::vector<float> line(row);
  for (std::int64_t start = 0; start < n; ++start) {
    if (start / stride % row != 0)
      continue;
    for (std::int64_t i = 0; i < row; ++i)
      line[i] = values[start + i * stride];
    for (std::int64_t i = 0; i < row; ++i) {
      const float before = i > 0 ? line[i - 1] : 0, after = i + 1 < row ? line[i + 1] : 0;
      values[start + i * stride] = 0.25f * (before + 2 * line[i] + after);
    }
  }
}

} // namespace

std::shared_ptr<const Volume> volume_of_matter(const Specimen& body) {
  const Grid& grid = body.grid;
  VoxelGrid voxels;
  for (std::size_t a = 0; a < 3; ++a) {
    voxels.size[a] = grid.cells()[a] + 2 * margin;
    voxels.spacing[a] = grid.spacing()[a];
    voxels.origin[a] = body.origin[a] + (0.5 - margin) * grid.spacing()[a];
  }
  const Index3& n = voxels.size;
  std::vector<float> matter(voxels.n_voxels(), 0);
  const auto voxel_of = [&](std::int64_t cell) {
    const Index3 at = grid.cell_at(cell);
    return static_cast<std::size_t>(
        at[0] + margin + std::int64_t{n[0]} * (at[1] + margin + std::int64_t{n[1]} * (at[2] + margin)));
  };
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (body.is_matter(cell))
      matter[voxel_of(cell)] = 1;
  const std::vector<float> sharp = matter;
  for (int pass = 0; pass < 2; ++pass)
    for (int axis = 0; axis < grid.dimension(); ++axis)
      if (grid.cells()[axis] > plate)
        smooth_along(matter, n, axis);
  // Keeps cell centres on their side of the surface, so that smoothing neither removes features one voxel
  // thin nor closes gaps one voxel wide.
  for (std::size_t v = 0; v < matter.size(); ++v)
    matter[v] = sharp[v] > 0 ? std::max(matter[v], 0.56f) : std::min(matter[v], 0.44f);
  return std::make_shared<Volume>(voxels, matter, 0, 1, Volume::Depth::bits8);
}

std::shared_ptr<const Volume> volume_of(const Seen& seen, const Specimen& body, Volume::Depth depth) {
  if (seen.grey.values.empty())
    return volume_of_matter(body);
  const ImageInfo& info = seen.grey.info;
  VoxelGrid voxels;
  voxels.size = info.size;
  voxels.spacing = info.spacing;
  const Rows& to_world = seen.placement.direction;
  voxels.origin = transposed_times(to_world, minus(info.origin, seen.placement.origin));
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column) {
      voxels.direction[row][column] = 0;
      for (std::size_t k = 0; k < 3; ++k)
        voxels.direction[row][column] += to_world[k][row] * info.direction[k][column];
    }
  // A look is constant beyond its outermost points: that range needs no codes.
  double low = seen.look.opacity.front().value, high = seen.look.opacity.back().value;
  for (const ColourPoint& point : seen.look.colours) {
    low = std::min(low, point.value);
    high = std::max(high, point.value);
  }
  if (seen.look.mode == LookMode::isosurface) {
    low = std::min(low, seen.look.isovalue);
    high = std::max(high, seen.look.isovalue);
  }
  low = std::max(low, seen.least);
  high = std::min(high, seen.largest);
  return std::make_shared<Volume>(voxels, seen.grey.values, low, high, depth, seen.look.shading.on);
}

VoxelGrid cells_as_voxels(const Specimen& body) {
  VoxelGrid grid;
  grid.size = body.grid.cells();
  grid.spacing = body.grid.spacing();
  for (std::size_t a = 0; a < 3; ++a)
    grid.origin[a] = body.origin[a] + 0.5 * body.grid.spacing()[a];
  return grid;
}

std::shared_ptr<const Paint> paint_of_cells(const Specimen& body, std::vector<float> values, double low,
                                            double high) {
  std::vector<std::uint8_t> has_value(values.size());
  for (std::size_t cell = 0; cell < values.size(); ++cell)
    has_value[cell] = body.is_matter(static_cast<std::int64_t>(cell));
  for (int pass = 0; pass < 2; ++pass) {
    const auto before = has_value;
    for (std::size_t cell = 0; cell < values.size(); ++cell) {
      if (before[cell] != 0)
        continue;
      const Index3 at = body.grid.cell_at(static_cast<std::int64_t>(cell));
      double sum = 0;
      int count = 0;
      for (int dz = -1; dz <= 1; ++dz)
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const Index3 other{at[0] + dx, at[1] + dy, at[2] + dz};
            if (!body.grid.has_cell(other) || before[body.grid.cell(other)] == 0)
              continue;
            sum += values[body.grid.cell(other)];
            ++count;
          }
      if (count > 0) {
        values[cell] = static_cast<float>(sum / count);
        has_value[cell] = 1;
      }
    }
  }
  return Paint::field(cells_as_voxels(body), values, low, high, field_colours());
}

} // namespace maille::render
