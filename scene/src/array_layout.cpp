#include "maille/scene/array_layout.hpp"

#include <algorithm>

namespace maille {

ArrayLayout ArrayLayout::x_fastest(const Index3& size) {
  return {size, {1, size[0], std::int64_t{1} * size[0] * size[1]}, 0};
}

ArrayLayout ArrayLayout::z_fastest(const Index3& size) {
  return {size, {std::int64_t{1} * size[1] * size[2], size[2], 1}, 0};
}

bool ArrayLayout::fits(std::int64_t n_elements) const {
  // Strides may be anything: sums in 128 bits pass no range.
  __extension__ typedef __int128 Wide;
  Wide low = first, high = first, voxels = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    if (size[a] < 1)
      return false;
    const Wide reach = Wide{size[a] - 1} * stride[a];
    low += std::min(reach, Wide{0});
    high += std::max(reach, Wide{0});
    voxels *= size[a];
  }
  return low >= 0 && high < n_elements && voxels <= n_elements;
}

Affine affine_of(const Vec3& spacing, const Vec3& origin, const std::array<Vec3, 3>& direction) {
  Affine affine{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column)
      affine[row][column] = direction[row][column] * spacing[column];
    affine[row][3] = origin[row];
  }
  affine[3][3] = 1;
  return affine;
}

} // namespace maille
