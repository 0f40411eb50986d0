#include "bodies/surface.hpp"

#include "data/parallel.hpp"
#include "data/vectors.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maille::render {

namespace {

/// The codes of everything that may be seen in a cell of the lattice.
Volume::Range codes_in(const Lattice& lattice, const Index3& at, const Volume& volume) {
  Index3 first{INT32_MAX, INT32_MAX, INT32_MAX}, last{INT32_MIN, INT32_MIN, INT32_MIN};
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 point{};
    for (std::size_t a = 0; a < 3; ++a)
      point[a] = lattice.origin[a] + lattice.spacing[a] * (at[a] + ((corner >> a) & 1));
    const Vec3 index = volume.grid().index_of(point);
    for (std::size_t a = 0; a < 3; ++a) {
      const double within = std::clamp(index[a], -2.0, volume.grid().size[a] + 2.0);
      // Rounding of a point on a voxel's middle must not leave that voxel out.
      first[a] = std::min(first[a], static_cast<int>(std::floor(within - 1e-6)));
      last[a] = std::max(last[a], static_cast<int>(std::ceil(within + 1e-6)));
    }
  }
  return volume.range_of(first, last);
}

} // namespace

std::vector<SurfaceFace> surface_of(const Lattice& lattice, const Volume& volume, const Look& look,
                                    const TransferTable& table, int threads) {
  const Index3 n = lattice.cells;
  const auto number = [&](int i, int j, int k) {
    return static_cast<std::size_t>(i + std::int64_t{n[0]} * (j + std::int64_t{n[1]} * k));
  };
  std::vector<std::uint8_t> is_seen(static_cast<std::size_t>(lattice.n_cells()), 0);
  for_each_item(threads, n[2], [&](int k, int) {
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        if (lattice.carries.empty() || lattice.carries[number(i, j, k)] != 0)
          is_seen[number(i, j, k)] = is_visible(codes_in(lattice, {i, j, k}, volume), table, look, volume);
  });
  std::vector<SurfaceFace> faces;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i) {
        if (is_seen[number(i, j, k)] == 0)
          continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
          for (int upper = 0; upper < 2; ++upper) {
            Index3 other{i, j, k};
            other[axis] += upper != 0 ? 1 : -1;
            if (other[axis] < 0 || other[axis] >= n[axis] ||
                is_seen[number(other[0], other[1], other[2])] == 0)
              faces.push_back({static_cast<std::int32_t>(number(i, j, k)), static_cast<std::uint8_t>(axis),
                               static_cast<std::uint8_t>(upper)});
          }
      }
  return faces;
}

} // namespace maille::render
