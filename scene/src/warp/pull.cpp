// Every deformed cell is inverted at the voxels' middles that it may cover: those in the box around its
// corners, within which a trilinear map keeps what is between them.

#include "warp/deformed_cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille {

namespace {

using namespace warping;
using Eigen::Vector3d;

/// Well within a cell: two cells that do not overlap cannot both have a place there.
constexpr double surely_inside = 0.5 - 1e-4;
/// Places in cells are kept this far from faces, so that rounding takes none into the next voxel.
constexpr double within_cell = 0.5 - 1e-6;

class Inversion {
public:
  explicit Inversion(Pull& pull)
      : pull_(pull), n_(static_cast<std::size_t>(pull.grid.n_voxels())), size_(pull.grid.size) {}

  void add(const DeformedBody& body) {
    const Specimen& specimen = *body.specimen;
    const Affine3 to_voxels = body_to_voxels(pull_.grid, specimen.placement);
    const Vec3& h = specimen.grid.spacing();
    per_cell_ = to_voxels.linear * eigen(h).asDiagonal();
    first_middle_ = to_voxels.of(eigen(specimen.origin)) + per_cell_ * Vector3d(0.5, 0.5, 0.5);
    const double orientation = to_voxels.linear.determinant() > 0 ? 1 : -1;
    std::vector<std::pair<Index3, CellMap>> folded;
    for_each_deformed_cell(pull_.grid, body, [&](std::int64_t, const Index3& at, const Corners& corners) {
      const CellMap map(corners);
      if (map.least_determinant(orientation) > 0)
        take(at, corners, map);
      else
        folded.emplace_back(at, map);
    });
    for (const auto& [at, map] : folded) {
      Corners corners;
      for (unsigned c = 0; c < 8; ++c)
        corners[c] = map.of({c & 1U ? 0.5 : -0.5, c & 2U ? 0.5 : -0.5, c & 4U ? 0.5 : -0.5});
      take(at, corners, map);
    }
    pull_.folded_cells += static_cast<std::int64_t>(folded.size());
  }

private:
  void take(const Index3& cell, const Corners& corners, const CellMap& map) {
    Vector3d low = corners[0], high = corners[0];
    for (const Vector3d& corner : corners) {
      low = low.cwiseMin(corner);
      high = high.cwiseMax(corner);
    }
    Index3 first{}, last{};
    for (std::size_t a = 0; a < 3; ++a) {
      const auto axis = static_cast<Eigen::Index>(a);
      const double slack = 1e-5 * (high[axis] - low[axis]);
      if (!(high[axis] + slack >= 0 && low[axis] - slack <= size_[a] - 1))
        return;
      first[a] = static_cast<int>(std::ceil(std::max(0.0, low[axis] - slack)));
      last[a] = static_cast<int>(std::floor(std::min(size_[a] - 1.0, high[axis] + slack)));
    }
    const Vector3d middle = first_middle_ + per_cell_ * Vector3d(cell[0], cell[1], cell[2]);
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j)
        for (int i = first[0]; i <= last[0]; ++i)
          if (const auto s =
                  map.inverse({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}))
            put({i, j, k}, *s, middle);
  }

  void put(const Index3& at, const Vector3d& s, const Vector3d& middle) {
    const auto voxel =
        static_cast<std::size_t>(at[0] + std::int64_t{size_[0]} * (at[1] + std::int64_t{size_[1]} * at[2]));
    if (pull_.source[voxel] != Pull::nothing) {
      if ((s.array().abs() < surely_inside).all())
        ++pull_.reached_twice;
      return;
    }
    const Vector3d rest = middle + per_cell_ * s.cwiseMin(within_cell).cwiseMax(-within_cell);
    std::int64_t source = 0;
    for (std::size_t a = 3; a-- > 0;) {
      const double x = rest[static_cast<Eigen::Index>(a)];
      pull_.shift[a * n_ + voxel] = static_cast<float>(x - at[a]);
      const double index = std::floor(x + 0.5);
      if (!(index >= 0 && index < size_[a]))
        source = Pull::outside;
      else if (source != Pull::outside)
        source = source * size_[a] + static_cast<std::int64_t>(index);
    }
    pull_.source[voxel] = static_cast<std::int32_t>(source);
    ++pull_.reached;
  }

  Pull& pull_;
  std::size_t n_;
  Index3 size_;
  Eigen::Matrix3d per_cell_; ///< of voxels along the axes of the body's cells
  Vector3d first_middle_;    ///< of the body's first cell, in voxels
};

} // namespace

Pull pull_of(const ImageInfo& grid, std::span<const DeformedBody> bodies) {
  if (grid.n_voxels() > std::numeric_limits<std::int32_t>::max())
    throw std::invalid_argument("an image of more than 2^31 voxels cannot be warped");
  Pull pull;
  pull.grid = grid;
  pull.grid.components = 1;
  const auto n = static_cast<std::size_t>(grid.n_voxels());
  pull.shift.assign(3 * n, 0);
  pull.source.assign(n, Pull::nothing);
  Inversion inversion(pull);
  for (const DeformedBody& body : bodies) {
    check(body);
    inversion.add(body);
  }
  std::vector<RestCells> rest;
  for (const DeformedBody& body : bodies)
    rest.emplace_back(grid, *body.specimen);
  for_each_voxel(grid, [&](std::size_t voxel, const Vector3d& at) {
    for (const RestCells& cells : rest)
      if (cells.cell_at(at) >= 0) {
        ++pull.at_rest;
        pull.vacated += pull.source[voxel] == Pull::nothing ? 1 : 0;
        break;
      }
  });
  return pull;
}

} // namespace maille
