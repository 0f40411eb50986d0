#pragma once
/// Many places carried back through one cell at a time. Private to scene.

#include <array>
#include <cstddef>

namespace maille::warping {

/// A map of a cell that is nearly affine, carried back by J, its derivative in the middle:
/// J^-1 x(s) = s + D s t + E s u + F t u + G s t u, x from the middle.
struct MildMap {
  std::array<double, 9> inverse; ///< of J, row by row
  double largest_row;            ///< sum of sizes in a row of J
  std::array<double, 3> st, su, tu, stu;
  std::array<double, 3> spread; ///< how far from affine the inverse is, at most
};

/// Where a cell and what is in it rest, in indices of an image's voxels.
struct RestMap {
  std::array<double, 9> linear; ///< of (s, t, u), row by row
  std::array<double, 3> middle;
  double within;              ///< how far from the middle places are kept, so that rounding takes none out
  std::array<double, 3> size; ///< of the image [voxels]
};

/// Places being mapped back, with the caller's numbers.
struct Places {
  static constexpr int most = 64;
  int n = 0;
  alignas(64) std::array<double, most> x, y, z, number;
  alignas(64) std::array<double, most> depth; ///< of (s, t, u) the largest in size: 1/2 on a face
  alignas(64)
      std::array<double, most> source; ///< the number of the voxel that holds a place; less than 0 outside

  void add(double at_x, double at_y, double at_z, int of) {
    const auto i = static_cast<std::size_t>(n++);
    x[i] = at_x;
    y[i] = at_y;
    z[i] = at_z;
    number[i] = of;
  }
};

/// Rows of places along x, and the parts of them that a cell may hold; all from the middle of the cell.
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

/// Finds `low` and `high`, a millionth of a voxel too far: places before and beyond are not in the cell. The
/// obvious version, row by row, is CellMap::narrow.
void narrow(const MildMap& map, double slack, PlaceRows& rows);

/// Carries places, given from the middle of the cell, back to its (s, t, u); those outside of it are left
/// out, the others stay in their order. The obvious version, place by place, is CellMap::inverse.
///
/// No products are fused with sums, so that all processors find the same bits.
void invert(const MildMap& map, double slack, Places& places);

/// Leads places of a cell from (s, t, u) to where they rest, and finds `depth` and `source`. The obvious
/// version, place by place, is CellsAtRest::place and voxel_at. @pre the image has less than 2^31 voxels
void take_to_rest(const RestMap& map, Places& places);

} // namespace maille::warping
