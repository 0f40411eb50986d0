#pragma once
/// Inverts the map of one cell at many places at once. Private to scene.

#include <array>
#include <cstddef>

namespace maille::warping {

/// A nearly affine map of a cell, multiplied by the inverse of J, its derivative at the centre:
/// J^-1 x(s) = s + D s t + E s u + F t u + G s t u, x relative to the centre.
struct MildMap {
  std::array<double, 9> inverse; ///< of J, row by row
  double largest_row;            ///< largest row sum of |J|
  std::array<double, 3> st, su, tu, stu;
  std::array<double, 3> spread; ///< upper bound of the non-affine part of the inverse
};

/// Position of a cell at rest, in an image's voxel indices.
struct RestMap {
  std::array<double, 9> linear; ///< of (s, t, u), row by row
  std::array<double, 3> middle;
  double within;              ///< largest distance from the centre, so that rounding moves no place out
  std::array<double, 3> size; ///< of the image [voxels]
};

/// Places being mapped back, with the caller's numbers.
struct Places {
  static constexpr int most = 64;
  int n = 0;
  alignas(64) std::array<double, most> x, y, z, number;
  alignas(64) std::array<double, most> depth;  ///< max |(s, t, u)|: 1/2 on a face
  alignas(64) std::array<double, most> source; ///< number of the voxel that contains a place; < 0 outside

  void add(double at_x, double at_y, double at_z, int of) {
    const auto i = static_cast<std::size_t>(n++);
    x[i] = at_x;
    y[i] = at_y;
    z[i] = at_z;
    number[i] = of;
  }
};

/// Rows of places along x, and the parts of them that may be in a cell; relative to the centre of the cell.
struct PlaceRows {
  static constexpr int most = 64;
  int n = 0;
  alignas(64) std::array<double, most> y, z, low, high;

  void add(double at_y, double at_z) {
    const auto i = static_cast<std::size_t>(n++);
    y[i] = at_y;
    z[i] = at_z;
  }
};

/// Finds `low` and `high`, a millionth of a voxel too wide: places outside are not in the cell. The reference
/// version, row by row, is CellMap::narrow.
void narrow(const MildMap& map, double slack, PlaceRows& rows);

/// Maps places, relative to the centre of the cell, back to its (s, t, u); drops those outside, and keeps the
/// order of the others. The reference version, place by place, is CellMap::inverse.
///
/// Does not use fused multiply-add, so that all processors produce the same bits.
void invert(const MildMap& map, double slack, Places& places);

/// Maps places of a cell from (s, t, u) to their places at rest, and finds `depth` and `source`. The
/// reference version, place by place, is CellsAtRest::place and voxel_at. @pre the image has fewer than 2^31
/// voxels
void take_to_rest(const RestMap& map, Places& places);

} // namespace maille::warping
