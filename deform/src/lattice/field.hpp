#pragma once
/// One number per node of a grid, as rows along x in somebody's memory.

#include "maille/scene/grid.hpp"

namespace maille::deform {

template<class T>
struct Field {
  T* data = nullptr;
  Index3 nodes{1, 1, 1};
  std::int64_t row_stride = 0;  ///< from a node to the next along y
  std::int64_t slab_stride = 0; ///< from a node to the next along z

  T* row(int y, int z) const { return data + y * row_stride + z * slab_stride; }
  T& at(const Index3& node) const { return row(node[1], node[2])[node[0]]; }
};

/// The numbers of a grid in its own order, without padding.
template<class T>
Field<T> dense_field(const Grid& grid, T* data) {
  const Index3& n = grid.nodes();
  return {data, n, n[0], std::int64_t{1} * n[0] * n[1]};
}

} // namespace maille::deform
