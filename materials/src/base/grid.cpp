#include "maille/base/grid.hpp"

namespace maille {

Grid::Grid(int dimension, Index3 cells, Vec3 spacing)
    : dimension_(dimension), cells_(cells), spacing_(spacing) {
  for (int a = 0; a < 3; ++a) {
    const auto axis = static_cast<std::size_t>(a);
    if (a >= dimension)
      cells_[axis] = 1;
    nodes_[axis] = a < dimension ? cells_[axis] + 1 : 1;
  }
}

namespace {

Index3 unflatten(std::int64_t index, const Index3& size) {
  const std::int64_t rest = index / size[0];
  return {static_cast<int>(index % size[0]), static_cast<int>(rest % size[1]),
          static_cast<int>(rest / size[1])};
}

bool inside(const Index3& at, const Index3& size) {
  for (std::size_t a = 0; a < 3; ++a)
    if (at[a] < 0 || at[a] >= size[a])
      return false;
  return true;
}

} // namespace

Index3 Grid::cell_at(std::int64_t cell) const {
  return unflatten(cell, cells_);
}
Index3 Grid::node_at(std::int64_t node) const {
  return unflatten(node, nodes_);
}
bool Grid::has_cell(const Index3& at) const {
  return inside(at, cells_);
}
bool Grid::has_node(const Index3& at) const {
  return inside(at, nodes_);
}

std::int64_t Grid::corner(const Index3& cell, int corner) const {
  return node({cell[0] + (corner & 1), cell[1] + ((corner >> 1) & 1), cell[2] + ((corner >> 2) & 1)});
}

} // namespace maille
