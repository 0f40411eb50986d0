// First every cell marks the voxels that it may cover with its label. Voxels marked by several labels, by
// cells with several labels, or by cells at the body's border are then sampled point by point.

#include "warp/label_parts.hpp"
#include "warp/deformed_cells.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace maille::warping {

namespace {

using Eigen::Vector3d;

constexpr float untouched = -std::numeric_limits<float>::infinity();
constexpr float mixed = std::numeric_limits<float>::infinity();

/// Sample points relative to a voxel's centre. Generator (1, 11, 17) modulo 64: least P2 of all odd ones.
std::array<Vector3d, points_per_voxel> points_in_voxel() {
  std::array<Vector3d, points_per_voxel> points;
  for (int n = 0; n < points_per_voxel; ++n)
    points[n] = Vector3d(n, 11 * n % points_per_voxel, 17 * n % points_per_voxel);
  for (Vector3d& point : points)
    point = (point.array() + 0.5) / points_per_voxel - 0.5;
  return points;
}

class LabelParts {
public:
  LabelParts(const ImageInfo& grid, const Image& labels)
      : grid_(grid), labels_(labels), state_(static_cast<std::size_t>(grid.n_voxels()), untouched) {}

  void mark(const DeformedBody& body) {
    const CellsAtRest rest(grid_, *body.specimen);
    for_each_deformed_cell(grid_, body, [&](std::int64_t, const Index3& at, const Corners& corners) {
      float label = CellMap(corners).is_folded(rest.orientation()) ? mixed : label_of(rest, at);
      if (label != 0 && is_at_border(*body.specimen, at))
        label = mixed;
      VoxelBox(corners, grid_.size, 0.5).for_each(grid_.size, [&](std::size_t voxel, const Index3&) {
        float& state = state_[voxel];
        state = state == untouched || state == label ? label : mixed;
      });
    });
  }

  /// Numbers the mixed voxels, and counts the others as whole.
  void count_whole() {
    number_.assign(state_.size(), -1);
    std::int32_t n_mixed = 0;
    for (std::size_t voxel = 0; voxel < state_.size(); ++voxel)
      if (state_[voxel] == mixed)
        number_[voxel] = n_mixed++;
      else if (state_[voxel] != untouched)
        add(state_[voxel], points_per_voxel);
    taken_.assign(n_mixed, 0);
  }

  /// As in pull_of: the first of overlapping cells takes a point, unfolded cells before folded ones.
  void count_points(const DeformedBody& body) {
    const CellsAtRest rest(grid_, *body.specimen);
    for_each_cell_in_turn(grid_, body, [&](const Index3& at, const Corners& corners, const CellMap& map) {
      take(rest, at, corners, map);
    });
  }

  std::map<float, std::int64_t> parts() && { return std::move(parts_); }

private:
  void add(float label, std::int64_t points) {
    if (!last_ || label != last_label_) { // neighbours usually have the same label
      last_ = &parts_[label];
      last_label_ = label;
    }
    *last_ += points;
  }

  /// The common label of the voxels that a cell overlaps at rest.
  float label_of(const CellsAtRest& rest, const Index3& cell) const {
    const Vector3d middle = rest.middle(cell), half = rest.half();
    Index3 first{}, last{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      constexpr double slack = 1e-4; // ignores voxels that only touch the cell
      const double low = std::floor(middle[axis] - half[axis] + slack + 0.5);
      const double high = std::floor(middle[axis] + half[axis] - slack + 0.5);
      if (!(low >= 0 && high < grid_.size[a]))
        return mixed;
      first[a] = static_cast<int>(low);
      last[a] = static_cast<int>(high);
    }
    float label = untouched;
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i) {
          const float found =
              labels_.values[i + std::int64_t{grid_.size[0]} * (j + std::int64_t{grid_.size[1]} * k)];
          if (label != untouched && found != label)
            return mixed;
          label = found;
        }
    return label;
  }

  static bool is_at_border(const Specimen& body, const Index3& cell) {
    Index3 at{};
    for (int n = 0; n < 27; ++n) {
      at = {cell[0] + n % 3 - 1, cell[1] + n / 3 % 3 - 1, cell[2] + n / 9 - 1};
      for (std::size_t a = 0; a < 3; ++a)
        if (at[a] < 0 || at[a] >= body.grid.cells()[a])
          return true;
      if (!body.is_matter(body.grid.cell(at)))
        return true;
    }
    return false;
  }

  void take(const CellsAtRest& rest, const Index3& cell, const Corners& corners, const CellMap& map) {
    VoxelBox(corners, grid_.size, 0.5).for_each(grid_.size, [&](std::size_t voxel, const Index3& at) {
      if (number_[voxel] < 0)
        return;
      std::uint64_t& taken = taken_[number_[voxel]];
      const Vector3d middle(at[0], at[1], at[2]);
      for (std::size_t n = 0; n < points_per_voxel; ++n) {
        if (taken >> n & 1U)
          continue;
        const auto s = map.inverse(middle + points_[n]);
        if (!s)
          continue;
        taken |= std::uint64_t{1} << n;
        if (const std::int64_t source = voxel_at(grid_.size, rest.place(cell, *s)); source >= 0)
          add(labels_.values[source], 1);
      }
    });
  }

  const ImageInfo& grid_;
  const Image& labels_;
  const std::array<Vector3d, points_per_voxel> points_ = points_in_voxel();
  std::vector<float> state_;         ///< the label of every voxel, mixed or untouched
  std::vector<std::int32_t> number_; ///< of mixed voxels, else -1
  std::vector<std::uint64_t> taken_; ///< of every mixed voxel, a bit a point
  std::map<float, std::int64_t> parts_;
  std::int64_t* last_ = nullptr;
  float last_label_ = 0;
};

} // namespace

std::map<float, std::int64_t> label_parts(const ImageInfo& grid, std::span<const DeformedBody> bodies,
                                          const Image& labels) {
  LabelParts parts(grid, labels);
  for (const DeformedBody& body : bodies)
    parts.mark(body);
  parts.count_whole();
  for (const DeformedBody& body : bodies)
    parts.count_points(body);
  return std::move(parts).parts();
}

} // namespace maille::warping
