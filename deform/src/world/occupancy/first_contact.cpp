#include "world/occupancy/first_contact.hpp"

#include "lattice/tolerances.hpp"
#include "world/occupancy/cell_walk.hpp"
#include "world/occupancy/posed_matter.hpp"
#include "world/occupancy/posed_shape.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace maille::deform {

namespace {

/// The motion of a shape's points, in cells of the world.
class Sweep {
public:
  Sweep(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape, const Pose& pose,
        const RigidMotion& motion)
      : map_(map), cell_size_(cell_size), pose_(pose), motion_(motion), posed_(shape, pose, cell_size) {}

  const RigidShape& shape() const { return posed_.shape(); }
  const PosedShape& posed() const { return posed_; }
  bool only_shifts_along_its_lattice() const { return motion_.angle == 0 && posed_.is_aligned(); }

  /// True if no blocked cell is near any point of a ball on its way.
  bool is_clear(const RigidShape::Block& block) const {
    return is_clear(Eigen::Vector3d::Map(block.centre.data()), Eigen::Vector3d::Constant(block.radius), 0);
  }
  /// True if no blocked cell is near the whole shape on its way.
  bool is_clear() const;
  /// Tests the cells on a voxel's way, up to the earliest contact so far.
  void follow(std::int32_t voxel, const Index3& start, std::optional<Contact>& earliest) const;
  /// Calls visit(step, cell) for all blocked cells on a voxel's way.
  template<class Visit>
  void follow_through(std::int32_t voxel, const Index3& start, Visit&& visit) const;

private:
  /// The same for points around `centre`, in the object's frame, at most `reach` from it along each axis of
  /// the world; if rotations may move them out of that box, at most `arm` from the centre [m].
  bool is_clear(const Eigen::Vector3d& centre, const Eigen::Vector3d& reach, double arm) const;
  bool is_clear(const std::array<CoordinatePath, 3>& paths) const;
  std::array<CoordinatePath, 3> paths_of(const Eigen::Vector3d& rest) const;

  const OccupancyMap& map_;
  const Vec3& cell_size_;
  const Pose& pose_;
  const RigidMotion& motion_;
  PosedShape posed_;
};

bool Sweep::is_clear() const {
  const Eigen::Vector3d half = shape().middle();
  return is_clear(half, pose_.rotation.cwiseAbs() * half, half.norm());
}

bool Sweep::is_clear(const Eigen::Vector3d& centre, const Eigen::Vector3d& reach, double arm) const {
  const Eigen::Vector3d begin = pose_.position + pose_.rotation * centre;
  double turned = 0; // largest motion of a point by the rotation
  if (motion_.angle != 0) {
    const Eigen::Vector3d out = begin - motion_.about;
    turned = std::abs(motion_.angle) * ((out - motion_.axis * motion_.axis.dot(out)).norm() + arm);
  }
  Index3 first, last;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const double low = begin[i] + std::min(motion_.by[i], 0.0),
                 high = begin[i] + std::max(motion_.by[i], 0.0);
    const double margin = reach[i] + turned;
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
  if (motion_.angle != 0) { // Rodrigues: the component along the axis is constant
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

/// True if no cell is occupied in the box that a point may reach: a chord is no longer than its arc. Most
/// points of a tick stay within a cell, and walks along arcs are expensive.
bool Sweep::is_clear(const std::array<CoordinatePath, 3>& paths) const {
  Index3 first, last;
  for (std::size_t a = 0; a < 3; ++a) {
    const CoordinatePath& path = paths[a];
    const double begin = path.offset + path.cosine,
                 reach = std::abs(path.slope) +
                         std::abs(motion_.angle) * (std::abs(path.cosine) + std::abs(path.sine)) + negligible;
    if (!(begin - reach >= 0) || !(begin + reach < map_.cells()[a]))
      return false; // may meet the border
    first[a] = static_cast<int>(begin - reach);
    last[a] = static_cast<int>(begin + reach);
  }
  return first == last || !map_.is_any_occupied(first, last);
}

void Sweep::follow(std::int32_t voxel, const Index3& start, std::optional<Contact>& earliest) const {
  const std::array<CoordinatePath, 3> paths = paths_of(shape().centre_of(voxel));
  if (is_clear(paths))
    return;
  CellWalk walk(paths, motion_.angle, start);
  while (const auto step = walk.next(earliest ? earliest->time : 1)) {
    if (!map_.is_blocked(walk.cell()))
      continue;
    const VoxelId other = map_.has_cell(walk.cell()) ? map_.occupant(walk.cell()) : no_voxel;
    earliest = Contact{step->time, voxel, walk.cell(), step->axis, step->direction, other};
    return;
  }
}

template<class Visit>
void Sweep::follow_through(std::int32_t voxel, const Index3& start, Visit&& visit) const {
  CellWalk walk(paths_of(shape().centre_of(voxel)), motion_.angle, start);
  while (const auto step = walk.next(1))
    if (map_.is_blocked(walk.cell()))
      visit(*step, walk.cell());
}

/// Sides in the direction of a shift, as in RigidShape::open_sides.
unsigned sides_ahead(const Eigen::Vector3d& by) {
  unsigned sides = 0;
  for (int a = 0; a < 3; ++a)
    sides |= by[a] < 0 ? 1u << (2 * a) : by[a] > 0 ? 2u << (2 * a) : 0u;
  return sides;
}

std::optional<Contact> first_contact(const Sweep& sweep, const RigidMotion& motion) {
  const RigidShape& shape = sweep.shape();
  const unsigned sides = sweep.only_shifts_along_its_lattice() ? sides_ahead(motion.by) : 0xFF;
  std::optional<Contact> earliest;
  for (const RigidShape::Block& block : shape.blocks()) {
    if (sweep.is_clear(block))
      continue;
    any_voxel(sweep.posed(), block.first, block.end, [&](std::int32_t voxel, const Index3& cell) {
      if (sides == 0xFF || (shape.open_sides(voxel) & sides) != 0)
        sweep.follow(voxel, cell, earliest);
      return false;
    });
  }
  return earliest;
}

} // namespace

std::optional<Contact> first_contact(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                     const Pose& pose, const RigidMotion& motion) {
  const Sweep sweep(map, cell_size, shape, pose, motion);
  return sweep.is_clear() ? std::nullopt : first_contact(sweep, motion);
}

std::vector<Entry> entries_on_the_way(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape,
                                      VoxelId first, const Pose& pose, const RigidMotion& motion) {
  const Sweep sweep(map, cell_size, shape, pose, motion);
  std::vector<Entry> entries;
  const auto is_own = [&](const Index3& cell) {
    const VoxelId id = map.has_cell(cell) ? map.occupant(cell) : no_voxel;
    return id >= first && id - first < shape.n_voxels();
  };
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel)
    sweep.follow_through(voxel, sweep.posed().cell(voxel),
                         [&](const CellWalk::Step& step, const Index3& cell) {
                           if (!is_own(cell))
                             entries.push_back({step.time, voxel, cell, step.axis, step.direction});
                         });
  if (may_have_cells_between_voxels(shape.spacing(), pose.rotation, motion, cell_size))
    for (const HeldCell& held : held_on_the_way(map, cell_size, shape, pose, motion))
      if (!is_own(held.cell))
        entries.push_back({held.time, held.voxel, held.cell, held.axis, held.direction});
  return entries;
}

std::optional<Contact> move_until_contact(const OccupancyMap& map, const Vec3& cell_size,
                                          const RigidShape& shape, const RigidMotion& motion, Pose& pose,
                                          double& done) {
  const Pose from = pose;
  const Sweep sweep(map, cell_size, shape, from, motion);
  done = 1;
  pose = motion.moved(from, 1);
  if (sweep.is_clear()) // by whole cells, so rounding cannot matter
    return std::nullopt;
  auto contact = first_contact(sweep, motion);
  if (may_have_cells_between_voxels(shape.spacing(), from.rotation, motion, cell_size))
    if (const auto held = first_held_cell(map, cell_size, shape, from, motion, contact ? contact->time : 1.0))
      contact = held;
  if (contact) {
    done = std::max(0.0, contact->time - tolerance / largest_speed(shape, from, motion, cell_size));
    pose = motion.moved(from, done);
  }
  // Rounding may put a voxel at the border of its cell into the next: the motion is then shortened slightly.
  for (double less = 1e-12; done > 0 && is_blocked(map, cell_size, shape, pose); less *= 4) {
    done = std::max(0.0, done - less);
    pose = motion.moved(from, done);
  }
  return contact;
}

void check(const RigidMotion& motion) {
  if (!motion.by.allFinite() || !motion.about.allFinite() ||
      !(std::abs(motion.angle) <= 3.1415926535897936) || !(std::abs(motion.axis.norm() - 1) < 1e-9))
    throw std::invalid_argument("RigidMotion: finite, a turn of at most half a circle, an axis of length 1");
}

bool is_blocked(const OccupancyMap& map, const Vec3& cell_size, const RigidShape& shape, const Pose& pose) {
  const PosedShape posed(shape, pose, cell_size);
  if (posed.is_aligned())
    return std::ranges::any_of(shape.rows(), [&](const RigidShape::Row& row) {
      return map.is_row_blocked(posed.cell_of_row(row), row.n);
    });
  return any_cells(posed, [&](std::int32_t n,
                              const std::int32_t* const cells[3]) { return map.n_blocked(n, cells) > 0; }) ||
         (has_cells_between_voxels(shape.spacing(), pose.rotation, cell_size) &&
          holds_blocked_cell(map, cell_size, shape, pose));
}

} // namespace maille::deform
