#include "world/occupancy/node_cells.hpp"

namespace maille::deform {

void NodeCells::put(OccupancyMap& map, std::int32_t voxel, const Index3& cell) {
  cells_[static_cast<std::size_t>(voxel)] = cell;
  const VoxelId id = map.occupant(cell);
  if (id == nobody) {
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
  for (std::int32_t voxel = this->voxel(map.occupant(cell)); voxel >= 0;
       voxel = next_[static_cast<std::size_t>(voxel)])
    list.push_back(voxel);
  return list;
}

} // namespace maille::deform
