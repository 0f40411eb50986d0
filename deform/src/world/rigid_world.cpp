#include "maille/deform/world/rigid_world.hpp"

#include "world/first_contact.hpp"
#include "world/posed_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace maille::deform {

namespace {

/// How far before a wall an object stops [cells]: far above the rounding of positions, far below anything seen.
constexpr double skin = 1e-9;

/// How fast any voxel can go at most [cells in the time of the motion].
double largest_speed(const RigidShape& shape, const Pose& pose, const RigidMotion& motion,
                     const Vec3& cell_size) {
  double arm = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d rest;
    for (int a = 0; a < 3; ++a)
      rest[a] = (corner >> a & 1) * shape.size()[static_cast<std::size_t>(a)] *
                shape.spacing()[static_cast<std::size_t>(a)];
    arm = std::max(arm, (pose.position + pose.rotation * rest - motion.about).norm());
  }
  return (motion.by.norm() + std::abs(motion.angle) * arm) /
         *std::min_element(cell_size.begin(), cell_size.end());
}

void check(const RigidMotion& motion) {
  if (!motion.by.allFinite() || !motion.about.allFinite() ||
      !(std::abs(motion.angle) <= 3.1415926535897936) || !(std::abs(motion.axis.norm() - 1) < 1e-9))
    throw std::invalid_argument("RigidMotion: finite, a turn of at most half a circle, an axis of length 1");
}

} // namespace

RigidWorld::RigidWorld(const Index3& cells, const Vec3& cell_size) : map_(cells), cell_size_(cell_size) {
  for (const double size : cell_size)
    if (!(size > 0) || !std::isfinite(size))
      throw std::invalid_argument("RigidWorld: cells have sizes above 0");
}

RigidWorld::Added RigidWorld::add(RigidShape shape, const Pose& pose) {
  if (shape.n_voxels() > std::numeric_limits<VoxelId>::max() - n_voxels_)
    throw std::invalid_argument("RigidWorld: more voxels than a map has numbers for");
  Added added;
  any_voxel(
      PosedShape(shape, pose, cell_size_), 0, shape.n_voxels(), [&](std::int32_t voxel, const Index3& cell) {
        if (!map_.is_blocked(cell))
          return false;
        added.refused_at = Contact{0, voxel, cell, 0, 1, map_.has_cell(cell) ? map_.occupant(cell) : nobody};
        return true;
      });
  if (added.refused_at)
    return added;
  const VoxelId first = n_voxels_;
  n_voxels_ += shape.n_voxels();
  objects_.push_back({std::move(shape), pose, first});
  put(objects_.back());
  added.object = n_objects() - 1;
  return added;
}

int RigidWorld::object_of(VoxelId id) const {
  if (id < 0 || id >= n_voxels_)
    return -1;
  const auto after =
      std::upper_bound(objects_.begin(), objects_.end(), id,
                       [](VoxelId wanted, const Object& object) { return wanted < object.first; });
  return static_cast<int>(after - objects_.begin()) - 1;
}

std::int32_t RigidWorld::n_blocked(const RigidShape& shape, const Pose& pose) const {
  std::int32_t n = 0;
  any_voxel(PosedShape(shape, pose, cell_size_), 0, shape.n_voxels(), [&](std::int32_t, const Index3& cell) {
    n += map_.is_blocked(cell);
    return false;
  });
  return n;
}

std::int32_t RigidWorld::n_blocked(int object, const Pose& pose) const {
  std::int32_t n = 0;
  const RigidShape& own = shape(object);
  any_voxel(PosedShape(own, pose, cell_size_), 0, own.n_voxels(), [&](std::int32_t, const Index3& cell) {
    n += map_.is_blocked(cell) && (!map_.has_cell(cell) || object_of(map_.occupant(cell)) != object);
    return false;
  });
  return n;
}

MoveResult RigidWorld::move(int object, const RigidMotion& motion) {
  check(motion);
  Object& moving = at(object);
  MoveResult result;
  take(moving);
  if (const auto contact = move_taken(moving, motion, result.fraction))
    result.contacts.push_back(*contact);
  put(moving);
  return result;
}

MoveResult RigidWorld::slide(int object, const RigidMotion& motion) {
  check(motion);
  Object& moving = at(object);
  MoveResult result;
  take(moving);
  RigidMotion rest = motion;
  double left = 1;
  for (int faces = 0; faces <= 3; ++faces) {
    double done = 0;
    const auto contact = move_taken(moving, rest, done);
    result.fraction += left * done;
    left *= 1 - done;
    if (!contact)
      break;
    result.contacts.push_back(*contact);
    rest.by *= 1 - done;
    rest.by[contact->axis] = 0;
    rest.angle = 0;
    if (rest.by.isZero(0))
      break;
  }
  put(moving);
  return result;
}

std::optional<Contact> RigidWorld::move_taken(Object& object, const RigidMotion& motion, double& done) {
  const auto contact = first_contact(map_, cell_size_, object.shape, object.pose, motion);
  done = 1;
  if (contact) {
    const double speed = largest_speed(object.shape, object.pose, motion, cell_size_);
    done = std::max(0.0, contact->time - skin / speed);
  }
  Pose pose = motion.moved(object.pose, done);
  // A voxel that only just stays in its cell may be rounded into the next: then a little less.
  for (double less = 1e-12; done > 0 && is_blocked(map_, cell_size_, object.shape, pose); less *= 4) {
    done = std::max(0.0, done - less);
    pose = motion.moved(object.pose, done);
  }
  object.pose = pose;
  return contact;
}

MoveResult RigidWorld::move_by_halving(int object, const RigidMotion& motion, double threshold) {
  check(motion);
  Object& moving = at(object);
  MoveResult result;
  take(moving);
  for (double step = 1; step >= threshold; step /= 2) {
    const Pose wanted = motion.moved(moving.pose, step);
    if (is_blocked(map_, cell_size_, moving.shape, wanted))
      continue;
    moving.pose = wanted;
    result.fraction = step;
    break;
  }
  put(moving);
  return result;
}

void RigidWorld::put(const Object& object) {
  const PosedShape posed(object.shape, object.pose, cell_size_);
  if (posed.is_aligned()) {
    for (const RigidShape::Row& row : object.shape.rows())
      map_.put_row(posed.cell_of_row(row), row.n, object.first + row.voxel);
    return;
  }
  any_voxel(posed, 0, object.shape.n_voxels(), [&](std::int32_t voxel, const Index3& cell) {
    map_.put(cell, object.first + voxel);
    return false;
  });
}

void RigidWorld::take(const Object& object) {
  const PosedShape posed(object.shape, object.pose, cell_size_);
  if (posed.is_aligned()) {
    for (const RigidShape::Row& row : object.shape.rows())
      map_.take_row(posed.cell_of_row(row), row.n);
    return;
  }
  any_voxel(posed, 0, object.shape.n_voxels(), [&](std::int32_t, const Index3& cell) {
    map_.take(cell);
    return false;
  });
}

std::int64_t RigidWorld::bytes() const {
  std::int64_t sum = map_.bytes();
  for (const Object& object : objects_)
    sum += object.shape.bytes() + static_cast<std::int64_t>(sizeof(Object));
  return sum;
}

} // namespace maille::deform
