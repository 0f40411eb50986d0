/// Pulls an image through a deformation: for each voxel of the deformed image, its place at rest.
///
/// The deformation is trilinear in every cell. Each cell is inverted at the voxel centres that its box may
/// contain: x(s) = voxel is solved for the local coordinates s, and s inside the cell gives the place at
/// rest. Nearly affine cells are inverted for many places at a time (mild_inverse), the others for one place
/// at a time (CellMap::inverse). If cells overlap, the first cell in order keeps the voxel, and the overlap
/// is counted (reached_twice); folded cells are counted, too.
///
/// Exact: to the tolerance of the inversion. Voxels that no cell covers keep Pull::nothing.

#include "warp/deformed_cells.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <stdexcept>
#include <vector>

namespace maille {

namespace {

using namespace warping;
using Eigen::Vector3d;

class Inversion {
public:
  explicit Inversion(Pull& pull)
      : pull_(pull), n_(static_cast<std::size_t>(pull.grid.n_voxels())), size_(pull.grid.size) {}

  void add(const DeformedBody& body) {
    const CellsAtRest rest(pull_.grid, *body.specimen);
    rest_map_ = rest.map(size_);
    pull_.folded_cells += for_each_cell_in_turn(
        pull_.grid, body,
        [&](const Index3& at, const Corners& corners, const CellMap& map) { take(rest, at, corners, map); });
    store_shifts();
  }

private:
  void take(const CellsAtRest& rest, const Index3& cell, const Corners& corners, const CellMap& map) {
    const VoxelBox box(corners, size_, 0);
    if (map.is_mild())
      return take_many(rest, cell, box, map);
    for (int k = box.first[2]; k <= box.last[2]; ++k)
      for (int j = box.first[1]; j <= box.last[1]; ++j) {
        int first = box.first[0], last = box.last[0];
        map.narrow(Vector3d(0, j, k), first, last);
        const std::int64_t row = std::int64_t{size_[0]} * (j + std::int64_t{size_[1]} * k);
        for (int i = first; i <= last; ++i)
          if (const auto s = map.inverse(Vector3d(i, j, k))) {
            const Vector3d place = rest.place(cell, *s);
            put({static_cast<std::size_t>(row + i), {1.0 * i, 1.0 * j, 1.0 * k}}, s->cwiseAbs().maxCoeff(),
                {place[0], place[1], place[2]}, voxel_at(size_, place));
          }
      }
  }

  /// The same in batches of places.
  void take_many(const CellsAtRest& rest, const Index3& cell, const VoxelBox& box, const CellMap& map) {
    const MildMap mild = map.mild();
    const Vector3d &middle = map.middle(), middle_at_rest = rest.middle(cell);
    rest_map_.middle = {middle_at_rest[0], middle_at_rest[1], middle_at_rest[2]};
    const auto carry_back = [&] {
      invert(mild, CellMap::slack, places_);
      take_to_rest(rest_map_, places_);
      for (std::size_t p = 0; p < static_cast<std::size_t>(places_.n); ++p)
        put(at_[static_cast<std::size_t>(places_.number[p])], places_.depth[p],
            {places_.x[p], places_.y[p], places_.z[p]}, static_cast<std::int64_t>(places_.source[p]));
      places_.n = 0;
    };
    const auto take_rows = [&] {
      narrow(mild, CellMap::slack, rows_);
      for (std::size_t r = 0; r < static_cast<std::size_t>(rows_.n); ++r) {
        const double low = std::max(1.0 * box.first[0], rows_.low[r] + middle[0]),
                     high = std::min(1.0 * box.last[0], rows_.high[r] + middle[0]);
        if (!(low <= high))
          continue;
        const auto [j, k] = row_at_[r];
        const std::size_t row =
            static_cast<std::size_t>(size_[0]) *
            (static_cast<std::size_t>(j) + static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(k));
        const int below = static_cast<int>(low), last = static_cast<int>(high); // neither is negative
        for (int i = below < low ? below + 1 : below; i <= last; ++i) {
          at_[places_.n] = {row + static_cast<std::size_t>(i), {1.0 * i, 1.0 * j, 1.0 * k}};
          places_.add(i - middle[0], rows_.y[r], rows_.z[r], places_.n);
          if (places_.n == Places::most)
            carry_back();
        }
      }
      rows_.n = 0;
    };
    for (int k = box.first[2]; k <= box.last[2]; ++k)
      for (int j = box.first[1]; j <= box.last[1]; ++j) {
        row_at_[rows_.n] = {j, k};
        rows_.add(j - middle[1], k - middle[2]);
        if (rows_.n == PlaceRows::most)
          take_rows();
      }
    take_rows();
    carry_back();
  }

  /// A voxel, and its indices.
  struct Voxel {
    std::size_t number;
    std::array<double, 3> at;
  };
  /// @param depth in its cell @param rest place at rest @param source the voxel there
  void put(const Voxel& to, double depth, const std::array<double, 3>& rest, std::int64_t source) {
    const std::size_t voxel = to.number;
    if (pull_.source[voxel] != Pull::nothing) {
      if (depth < surely_inside)
        ++pull_.reached_twice;
      return;
    }
    if (n_shifts_ == shifts_.size())
      store_shifts();
    Shift& shift = shifts_[n_shifts_++];
    shift.voxel = static_cast<std::int32_t>(voxel);
    for (std::size_t a = 0; a < 3; ++a)
      shift.along[a] = static_cast<float>(rest[a] - to.at[a]);
    pull_.source[voxel] = source < 0 ? Pull::outside : static_cast<std::int32_t>(source);
    ++pull_.reached;
  }

  /// One component after the other: in images of 2^n voxels, the same place in all three and in adjacent
  /// layers maps to the same few cache lines.
  void store_shifts() {
    for (std::size_t a = 0; a < 3; ++a) {
      float* const to = pull_.shift.data() + a * n_;
      for (std::size_t i = 0; i < n_shifts_; ++i)
        to[shifts_[i].voxel] = shifts_[i].along[a];
    }
    n_shifts_ = 0;
  }

  struct Shift {
    std::int32_t voxel;
    std::array<float, 3> along;
  };

  Pull& pull_;
  std::size_t n_;
  Index3 size_;
  PlaceRows rows_;
  std::array<std::array<int, 2>, PlaceRows::most> row_at_{}; ///< of rows: along y, z
  Places places_;
  RestMap rest_map_{};                   ///< of the current cell
  std::array<Voxel, Places::most> at_{}; ///< of places
  std::array<Shift, 4096> shifts_{};     ///< found, not stored yet
  std::size_t n_shifts_ = 0;
};

} // namespace

Pull pull_of(const ImageInfo& grid, std::span<const DeformedBody> bodies) {
  if (grid.n_voxels() > std::numeric_limits<std::int32_t>::max())
    throw std::invalid_argument("an image of more than 2^31 voxels cannot be warped");
  Pull pull;
  pull.grid = grid;
  pull.grid.components = 1;
  const std::size_t n = grid.n_voxels();
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
  std::vector<char> is_matter(grid.size[0]);
  const std::int32_t* source = pull.source.data();
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j, source += is_matter.size()) {
      std::fill(is_matter.begin(), is_matter.end(), char{0});
      for (const RestCells& cells : rest)
        cells.mark(j, k, is_matter);
      for (std::size_t i = 0; i < is_matter.size(); ++i) {
        pull.at_rest += is_matter[i];
        pull.vacated += source[i] == Pull::nothing ? is_matter[i] : 0;
      }
    }
  return pull;
}

} // namespace maille
