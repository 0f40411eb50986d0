#include "world/occupancy/node_cells.hpp"

#include "world/occupancy/body_matter.hpp"

#include <cmath>
#include <optional>

namespace maille::deform {

void NodeCells::put(OccupancyMap& map, std::int32_t voxel, const Index3& cell) {
  cells_[voxel] = cell;
  const VoxelId id = map.occupant(cell);
  if (id == no_voxel) {
    map.put(cell, first_ + voxel);
    next(voxel) = -1;
    return;
  }
  std::int32_t before = this->voxel(id);
  if (voxel < before) {
    map.take(cell);
    map.put(cell, first_ + voxel);
    next(voxel) = before;
    return;
  }
  while (next(before) >= 0 && next(before) < voxel)
    before = next(before);
  next(voxel) = next(before);
  next(before) = voxel;
}

void NodeCells::take(OccupancyMap& map, std::int32_t voxel) {
  const Index3& at = cell(voxel);
  std::int32_t before = this->voxel(map.occupant(at));
  if (before == voxel) {
    map.take(at);
    if (next(voxel) >= 0)
      map.put(at, first_ + next(voxel));
    return;
  }
  while (next(before) != voxel)
    before = next(before);
  next(before) = next(voxel);
}

void NodeCells::move(OccupancyMap& map, std::int32_t voxel, const Index3& to) {
  if (to == cell(voxel))
    return;
  take(map, voxel);
  put(map, voxel, to);
}

std::vector<std::int32_t> NodeCells::voxels_in(const OccupancyMap& map, const Index3& cell) const {
  std::vector<std::int32_t> list;
  if (!is_node(map.occupant(cell)))
    return list;
  for (std::int32_t voxel = this->voxel(map.occupant(cell)); voxel >= 0; voxel = next_[voxel])
    list.push_back(voxel);
  return list;
}

namespace {

Hit hit_at(std::int32_t voxel, double time, std::size_t axis, int direction, const Index3& wall,
           const InCells& from, const InCells& to) {
  const double face = wall[axis] + (direction < 0 ? 1 : 0);
  return {
      voxel, time, static_cast<int>(axis), direction, wall, to[axis] - face, std::abs(to[axis] - from[axis])};
}

std::optional<Hit> first_hit(const OccupancyMap& map, const NodeCells& cells, std::int32_t voxel,
                             const Index3& start, const InCells& from, const InCells& to) {
  if (cell_at(to) == start) // a straight line within a cell
    return std::nullopt;
  const Eigen::Vector3d begin = Eigen::Vector3d::Map(from.data());
  CellWalk walk(begin, Eigen::Vector3d::Map(to.data()) - begin, start);
  while (const auto step = walk.next(1)) {
    if (!cells.is_blocked(map, walk.cell()))
      continue;
    return hit_at(voxel, step->time, static_cast<std::size_t>(step->axis), step->direction, walk.cell(), from,
                  to);
  }
  // The path ends on a face, or rounding moves its end across one.
  const Index3 last = cell_at(to);
  for (std::size_t a = 0; a < 3; ++a)
    if (last[a] != walk.cell()[a] && cells.is_blocked(map, last))
      return hit_at(voxel, 1, a, last[a] > walk.cell()[a] ? 1 : -1, last, from, to);
  return std::nullopt;
}

} // namespace

std::vector<Hit> find_hits(const OccupancyMap& map, const NodeCells& cells, const PosedLattice& lattice,
                           const BodyMatter& matter, const Displacement& from, const Displacement& to) {
  std::vector<Hit> hits;
  for (std::int32_t voxel = 0; voxel < lattice.n_voxels(); ++voxel) {
    const std::int64_t node = lattice.node(voxel);
    if (from.at(node) == to.at(node))
      continue;
    if (const auto hit = first_hit(map, cells, voxel, cells.cell(voxel), lattice.place(voxel, from),
                                   lattice.place(voxel, to)))
      hits.push_back(*hit);
  }
  for (std::int32_t point = 0; point < matter.n_points(); ++point) {
    const InCells begin = matter.place(point, lattice, from), end = matter.place(point, lattice, to);
    if (begin == end)
      continue;
    if (const auto hit = first_hit(map, cells, lattice.n_voxels() + point, cell_at(begin), begin, end))
      hits.push_back(*hit);
  }
  return hits;
}

} // namespace maille::deform
