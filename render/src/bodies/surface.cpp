#include "bodies/surface.hpp"

#include "data/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace maille::render {

namespace {

/// Range of codes that may be visible in a cell of the lattice.
Volume::Range codes_in(const Lattice& lattice, const Index3& at, const Volume& volume) {
  Index3 first{INT32_MAX, INT32_MAX, INT32_MAX}, last{INT32_MIN, INT32_MIN, INT32_MIN};
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 point{};
    for (std::size_t a = 0; a < 3; ++a)
      point[a] = lattice.origin[a] + lattice.spacing[a] * (at[a] + ((corner >> a) & 1));
    const Vec3 index = volume.grid().index_of(point);
    for (std::size_t a = 0; a < 3; ++a) {
      const double within = std::clamp(index[a], -2.0, volume.grid().size[a] + 2.0);
      // A corner within rounding of a voxel's centre is on it: the voxel behind has no weight.
      constexpr double rounding = 1e-6;
      first[a] = std::min(first[a], static_cast<int>(std::floor(within + rounding)));
      last[a] = std::max(last[a], static_cast<int>(std::ceil(within - rounding)));
    }
  }
  return volume.range_of(first, last);
}

/// Corners (bits: upper along x, y, z) of a face, counterclockwise as seen from outside the cell.
std::array<int, 4> corners_of_face(std::size_t axis, bool upper) {
  const int b = 1 << ((axis + 1) % 3), c = 1 << ((axis + 2) % 3), a = upper ? 1 << axis : 0;
  return upper ? std::array{a, a | b, a | b | c, a | c} : std::array{a, a | c, a | b | c, a | b};
}

/// Numbers the nodes of faces.
void number_nodes(const Lattice& lattice, Surface& surface) {
  const Index3 n = lattice.nodes();
  const auto node_of = [&](const SurfaceFace& face, int corner) {
    return static_cast<std::size_t>(
        face.cell[0] + (corner & 1) +
        std::int64_t{n[0]} *
            (face.cell[1] + ((corner >> 1) & 1) + std::int64_t{n[1]} * (face.cell[2] + (corner >> 2))));
  };
  constexpr std::uint32_t no_number = 0, used = 1;
  std::vector<std::uint32_t> number(lattice.n_nodes(), no_number);
  for (const SurfaceFace& face : surface.faces)
    for (const int corner : corners_of_face(face.axis, face.upper != 0))
      number[node_of(face, corner)] = used;
  for (std::size_t node = 0; node < number.size(); ++node)
    if (number[node] == used) {
      number[node] = static_cast<std::uint32_t>(surface.nodes.size());
      surface.nodes.push_back(static_cast<std::int64_t>(node));
    }
  for (SurfaceFace& face : surface.faces)
    std::ranges::transform(corners_of_face(face.axis, face.upper != 0), face.corners.begin(),
                           [&](int corner) { return number[node_of(face, corner)]; });
}

} // namespace

std::int64_t Surface::bytes() const {
  return static_cast<std::int64_t>(faces.size() * sizeof faces[0] + nodes.size() * sizeof nodes[0]);
}

Surface surface_of(const Lattice& lattice, const Volume& volume, const Look& look, const TransferTable& table,
                   int threads) {
  const Index3 n = lattice.cells;
  const auto number = [&](int i, int j, int k) {
    return static_cast<std::size_t>(i + std::int64_t{n[0]} * (j + std::int64_t{n[1]} * k));
  };
  std::vector<std::uint8_t> is_seen(lattice.n_cells(), 0);
  for_each_item(threads, n[2], [&](int k, int) {
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        if (lattice.carries.empty() || lattice.carries[number(i, j, k)] != 0)
          is_seen[number(i, j, k)] = is_visible(codes_in(lattice, {i, j, k}, volume), table, look, volume);
  });
  Surface surface;
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
              surface.faces.push_back(
                  {{i, j, k}, static_cast<std::uint8_t>(axis), static_cast<std::uint8_t>(upper)});
          }
      }
  number_nodes(lattice, surface);
  return surface;
}

} // namespace maille::render
