#include "world/voxels/hand_on.hpp"

#include "lattice/tolerances.hpp"
#include "world/occupancy/cell_walk.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <algorithm>
#include <optional>

namespace maille::deform {

namespace {

Index3 cell_of(const FreeVoxel& voxel) {
  return cell_at({voxel.place[0], voxel.place[1], voxel.place[2]});
}

/// The voxel met on a straight way, and the time; `next` is the empty id at the border.
struct Met {
  double time;
  VoxelId next;
};

/// How far along its way a voxel goes that is stopped at a time.
Eigen::Vector3d before_face(const Eigen::Vector3d& movement, double time) {
  return std::max(0.0, time - tolerance / movement.cwiseAbs().maxCoeff()) * movement;
}

/// Contents of a cell.
struct Look {
  bool is_blocked = false;
  VoxelId voxel = no_voxel; ///< the voxel there when blocked; the empty id outside the world
};

/// The chain of transfers, whatever finds who is in the way. @param meet finds what a voxel meets on its way;
/// @param look what is in a cell;
/// @param place puts a voxel elsewhere
template<class Meet, class LookAt, class Place>
Transfer follow_chain(std::span<FreeVoxel> voxels, VoxelId first, const Eigen::Vector3d& movement,
                      const Meet& meet, const LookAt& look, const Place& place) {
  Transfer transfer;
  Eigen::Vector3d rest = movement;
  for (VoxelId voxel = first; !rest.isZero(0);) {
    FreeVoxel& moving = voxels[static_cast<std::size_t>(voxel)];
    if (moving.is_fixed) {
      transfer.refused = rest;
      transfer.refused_by = voxel;
      break;
    }
    std::optional<Met> met = meet(voxel, rest);
    // A way that ends on a face, or is rounded across one.
    const Look end = look(cell_of({moving.place + rest, false}));
    if (!met && end.is_blocked && end.voxel != voxel)
      met = Met{1, end.voxel};
    VoxelMove move{voxel, rest, met ? before_face(rest, met->time) : rest};
    place(voxel, Eigen::Vector3d(moving.place + move.moved));
    transfer.moves.push_back(move);
    if (!met)
      break;
    rest -= move.moved;
    if (met->next == no_voxel) {
      transfer.refused = rest;
      break;
    }
    voxel = met->next;
  }
  return transfer;
}

CellWalk walk_of(const FreeVoxel& voxel, const Eigen::Vector3d& movement) {
  std::array<CoordinatePath, 3> paths;
  for (std::size_t a = 0; a < 3; ++a)
    paths[a] = {voxel.place[static_cast<Eigen::Index>(a)], movement[static_cast<Eigen::Index>(a)], 0, 0};
  return {paths, 0, cell_of(voxel)};
}

} // namespace

Transfer hand_on(OccupancyMap& map, std::span<FreeVoxel> voxels, VoxelId voxel,
                 const Eigen::Vector3d& movement) {
  const auto look = [&](const Index3& cell) {
    return Look{map.is_blocked(cell), map.has_cell(cell) ? map.occupant(cell) : no_voxel};
  };
  const auto meet = [&](VoxelId moving, const Eigen::Vector3d& rest) -> std::optional<Met> {
    CellWalk walk = walk_of(voxels[static_cast<std::size_t>(moving)], rest);
    while (const auto step = walk.next(1))
      if (const Look there = look(walk.cell()); there.is_blocked)
        return Met{step->time, there.voxel};
    return std::nullopt;
  };
  const auto place = [&](VoxelId moving, const Eigen::Vector3d& to) {
    FreeVoxel& moved = voxels[static_cast<std::size_t>(moving)];
    map.take(cell_of(moved));
    moved.place = to;
    map.put(cell_of(moved), moving);
  };
  return follow_chain(voxels, voxel, movement, meet, look, place);
}

} // namespace maille::deform
