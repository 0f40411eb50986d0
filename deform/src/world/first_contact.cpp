#include "world/first_contact.hpp"

#include "world/cell_walk.hpp"
#include "world/posed_shape.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

Eigen::Vector3d at_rest(const RigidShape& shape, std::int32_t voxel) {
  const Index3 i = shape.index_of(voxel);
  const Vec3& h = shape.spacing();
  return {(i[0] + 0.5) * h[0], (i[1] + 0.5) * h[1], (i[2] + 0.5) * h[2]};
}

/// The motion of a shape's points, in cells of the world.
class Sweep {
public:
  Sweep(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape, const Pose& pose,
        const RigidMotion& motion)
      : map_(map), cell_size_(cell_size), pose_(pose), motion_(motion), posed_(shape, pose, cell_size) {}

  const RigidShape& shape() const { return posed_.shape(); }
  bool only_shifts_along_its_lattice() const { return motion_.angle == 0 && posed_.is_aligned(); }

  /// Whether nothing is near any point of a ball on its way.
  bool is_clear(const RigidShape::Block& block) const;
  /// Asks the cells on a voxel's way, up to the earliest contact so far.
  void follow(std::int32_t voxel, const Index3& start, std::optional<Contact>& earliest) const;
  /// Calls visit(step, cell) for all blocked cells on a voxel's way.
  template<class Visit>
  void follow_through(std::int32_t voxel, const Index3& start, Visit&& visit) const;

private:
  std::array<CoordinatePath, 3> paths_of(const Eigen::Vector3d& rest) const;

  const OccupancyMap& map_;
  const Vec3& cell_size_;
  const Pose& pose_;
  const RigidMotion& motion_;
  PosedShape posed_;
};

bool Sweep::is_clear(const RigidShape::Block& block) const {
  const Eigen::Vector3d begin = pose_.position + pose_.rotation * Eigen::Vector3d::Map(block.centre.data());
  const Eigen::Vector3d arm = begin - motion_.about;
  const double reach = std::abs(motion_.angle) * (arm - motion_.axis * motion_.axis.dot(arm)).norm();
  Index3 first, last;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const double low = begin[i] + std::min(motion_.by[i], 0.0),
                 high = begin[i] + std::max(motion_.by[i], 0.0);
    const double margin = block.radius + reach;
    const double below = (low - margin) / cell_size_[a] - 1, above = (high + margin) / cell_size_[a] + 1;
    if (below < 0 || above >= map_.cells()[a])
      return false; // may meet the border
    first[a] = static_cast<int>(below);
    last[a] = static_cast<int>(above);
  }
  return !map_.is_any_occupied(first, last);
}

std::array<CoordinatePath, 3> Sweep::paths_of(const Eigen::Vector3d& rest) const {
  const Eigen::Vector3d begin = pose_.position + pose_.rotation * rest;
  std::array<CoordinatePath, 3> paths;
  Eigen::Vector3d still = begin, cosine = Eigen::Vector3d::Zero(), sine = cosine;
  if (motion_.angle != 0) { // Rodrigues: what lies along the axis stays
    const Eigen::Vector3d arm = begin - motion_.about, along = motion_.axis * motion_.axis.dot(arm);
    still = motion_.about + along;
    cosine = arm - along;
    sine = motion_.axis.cross(arm);
  }
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    paths[a] = {still[i] / cell_size_[a], motion_.by[i] / cell_size_[a], cosine[i] / cell_size_[a],
                sine[i] / cell_size_[a]};
  }
  return paths;
}

void Sweep::follow(std::int32_t voxel, const Index3& start, std::optional<Contact>& earliest) const {
  CellWalk walk(paths_of(at_rest(shape(), voxel)), motion_.angle, start);
  while (const auto step = walk.next(earliest ? earliest->time : 1)) {
    if (!map_.is_blocked(walk.cell()))
      continue;
    const VoxelId other = map_.has_cell(walk.cell()) ? map_.occupant(walk.cell()) : nobody;
    earliest = Contact{step->time, voxel, walk.cell(), step->axis, step->direction, other};
    return;
  }
}

template<class Visit>
void Sweep::follow_through(std::int32_t voxel, const Index3& start, Visit&& visit) const {
  CellWalk walk(paths_of(at_rest(shape(), voxel)), motion_.angle, start);
  while (const auto step = walk.next(1))
    if (map_.is_blocked(walk.cell()))
      visit(*step, walk.cell());
}

/// Sides that a shift goes towards, as in RigidShape::open_sides.
unsigned sides_ahead(const Eigen::Vector3d& by) {
  unsigned sides = 0;
  for (int a = 0; a < 3; ++a)
    sides |= by[a] < 0 ? 1u << (2 * a) : by[a] > 0 ? 2u << (2 * a) : 0u;
  return sides;
}

} // namespace

std::optional<Contact> first_contact(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                     const Pose& pose, const RigidMotion& motion) {
  const Sweep sweep(map, cell_size, shape, pose, motion);
  const PosedShape posed(shape, pose, cell_size);
  const unsigned sides = sweep.only_shifts_along_its_lattice() ? sides_ahead(motion.by) : 0xFF;
  std::optional<Contact> earliest;
  for (const RigidShape::Block& block : shape.blocks()) {
    if (sweep.is_clear(block))
      continue;
    any_voxel(posed, block.first, block.end, [&](std::int32_t voxel, const Index3& cell) {
      if (sides == 0xFF || (shape.open_sides(voxel) & sides) != 0)
        sweep.follow(voxel, cell, earliest);
      return false;
    });
  }
  return earliest;
}

std::optional<Contact> first_contact_of_every_voxel(const OccupancyMap& map, const Vec3& cell_size,
                                                    const RigidShape& shape, const Pose& pose,
                                                    const RigidMotion& motion) {
  const Sweep sweep(map, cell_size, shape, pose, motion);
  const PosedShape posed(shape, pose, cell_size);
  std::optional<Contact> earliest;
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel)
    sweep.follow(voxel, posed.cell(voxel), earliest);
  return earliest;
}

std::vector<Entry> entries_on_the_way(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                      VoxelId first, const Pose& pose, const RigidMotion& motion) {
  const Sweep sweep(map, cell_size, shape, pose, motion);
  const PosedShape posed(shape, pose, cell_size);
  std::vector<Entry> entries;
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel)
    sweep.follow_through(voxel, posed.cell(voxel), [&](const CellWalk::Step& step, const Index3& cell) {
      const VoxelId id = map.has_cell(cell) ? map.occupant(cell) : nobody;
      if (id < first || id - first >= shape.n_voxels())
        entries.push_back({step.time, voxel, cell, step.axis, step.direction});
    });
  return entries;
}

bool is_blocked(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape, const Pose& pose) {
  const PosedShape posed(shape, pose, cell_size);
  if (posed.is_aligned())
    return std::ranges::any_of(shape.rows(), [&](const RigidShape::Row& row) {
      return map.is_row_blocked(posed.cell_of_row(row), row.n);
    });
  return any_voxel(posed, 0, shape.n_voxels(),
                   [&](std::int32_t, const Index3& cell) { return map.is_blocked(cell); });
}

} // namespace maille::deform
