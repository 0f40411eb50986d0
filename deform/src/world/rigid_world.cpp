#include "maille/deform/world/rigid_world.hpp"

#include "world/first_contact.hpp"
#include "world/posed_shape.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace maille::deform {

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
  const PosedShape posed(shape, pose, cell_size_);
  std::int64_t n = 0;
  if (posed.is_aligned())
    for (const RigidShape::Row& row : shape.rows())
      n += map_.n_blocked_in_row(posed.cell_of_row(row), row.n);
  else
    any_cells(posed, [&](std::int32_t n_cells, const std::int32_t* const* cells) {
      n += map_.n_blocked(n_cells, cells);
      return false;
    });
  return static_cast<std::int32_t>(n);
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
  if (const auto contact =
          move_until_contact(map_, cell_size_, moving.shape, motion, moving.pose, result.fraction))
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
    const auto contact = move_until_contact(map_, cell_size_, moving.shape, rest, moving.pose, done);
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
  for_each_box(PosedShape(object.shape, object.pose, cell_size_),
               [&](const Index3& cell, const Index3& size, std::int32_t voxel) {
                 map_.put_box(cell, size, object.first + voxel);
               });
}

void RigidWorld::take(const Object& object) {
  for_each_box(PosedShape(object.shape, object.pose, cell_size_),
               [&](const Index3& cell, const Index3& size, std::int32_t) { map_.take_box(cell, size); });
}

std::int64_t RigidWorld::bytes() const {
  std::int64_t sum = map_.bytes();
  for (const Object& object : objects_)
    sum += object.shape.bytes() + static_cast<std::int64_t>(sizeof(Object));
  return sum;
}

} // namespace maille::deform
