#pragma once
/// Thin parts of a body: cells in rows of one or two cells.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <cstdint>

namespace maille::deform {

/// Rows of at most this number of cells along an axis are thin: they bend as plates do.
inline constexpr int most_cells_of_thin = 2;

/// Axes along which a cell of matter is part of a thin row: bit a for axis a. 0 in 1D and 2D, where bending
/// is exact.
std::uint8_t thin_axes(const Specimen& body, const Index3& cell);

/// The same for any cell of a full grid. @param cells of a 3D grid
inline std::uint8_t thin_axes_of_box(const Index3& cells) {
  const auto bit = [&](int a) { return (cells[a] <= most_cells_of_thin ? 1 : 0) << a; };
  return static_cast<std::uint8_t>(bit(0) | bit(1) | bit(2));
}

/// What thin matter has beside the stiffness of links and twists: of the differences across axis `across` of
/// a cell's strains aa, bb and gamma_ab (a, b: the axes after it), the stiffness of plane stress less what
/// links and twists have of it [Pa]. @param S compliance, order 11 22 33 23 13 12 [1/Pa]
/// Source  docs/theory.md, section 3 (LAT); Kirchhoff 1850
Eigen::Matrix3d bending_beyond_links(const Eigen::Matrix<double, 6, 6>& S, int across);

} // namespace maille::deform
