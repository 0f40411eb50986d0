#include "maille/deform/world/rigid_world.hpp"

#include "world/occupancy/first_contact.hpp"
#include "world/occupancy/posed_matter.hpp"
#include "world/occupancy/posed_shape.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille::deform {

RigidWorld::RigidWorld(const Index3& cells, const Vec3& cell_size) : map_(cells), cell_size_(cell_size) {
  for (const double size : cell_size)
    if (!(size > 0) || !std::isfinite(size))
      throw std::invalid_argument("RigidWorld: cells have sizes above 0");
}

RigidWorld::Added RigidWorld::add(RigidShape shape, const Pose& pose, bool may_meet) {
  if (shape.n_voxels() > std::numeric_limits<VoxelId>::max() - n_voxels_)
    throw std::invalid_argument("RigidWorld: more voxels than a map has numbers for");
  Added added;
  added.refused_at = find_refusal(shape, pose, may_meet);
  if (added.refused_at)
    return added;
  const VoxelId first = n_voxels_;
  n_voxels_ += shape.n_voxels();
  objects_.push_back({std::move(shape), pose, first, {}});
  put(objects_.back());
  added.object = n_objects() - 1;
  return added;
}

/// The first voxel whose cell is blocked.
std::optional<Contact> RigidWorld::find_refusal(const RigidShape& shape, const Pose& pose,
                                                bool may_meet) const {
  std::optional<Contact> refusal;
  const auto is_refused = [&](std::int32_t voxel, const Index3& cell) {
    if (!map_.is_blocked(cell) || (may_meet && map_.has_cell(cell)))
      return false;
    refusal = Contact{0, voxel, cell, 0, 1, map_.has_cell(cell) ? map_.occupant(cell) : no_voxel};
    return true;
  };
  if (any_voxel(PosedShape(shape, pose, cell_size_), 0, shape.n_voxels(), is_refused) ||
      !has_cells_between_voxels(shape.spacing(), pose.rotation, cell_size_))
    return refusal;
  const PosedMatter matter(shape, pose, cell_size_);
  for (std::int32_t voxel = 0; voxel < shape.n_voxels() && !refusal; ++voxel)
    matter.any_middle(voxel, &map_, [&](const Index3& cell) { return is_refused(voxel, cell); });
  return refusal;
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

void RigidWorld::put_back(int object, const Pose& pose) {
  at(object).pose = pose;
  put(at(object));
}

std::vector<Contact> RigidWorld::touched(int object, double reach) const {
  std::vector<Contact> list;
  const Object& own = at(object);
  if (!has_cells_between_voxels(own.shape.spacing(), own.pose.rotation, cell_size_))
    return list;
  for (const HeldCell& held : held_nearly(map_, cell_size_, own.shape, own.pose, reach))
    if (const VoxelId other = map_.occupant(held.cell); object_of(other) != object)
      list.push_back({0, held.voxel, held.cell, held.axis, held.direction, other});
  return list;
}

void RigidWorld::put(Object& object) {
  for_each_box(PosedShape(object.shape, object.pose, cell_size_),
               [&](const Index3& cell, const Index3& size, std::int32_t voxel) {
                 map_.put_box(cell, size, object.first + voxel);
               });
  if (!has_cells_between_voxels(object.shape.spacing(), object.pose.rotation, cell_size_))
    return;
  const PosedMatter matter(object.shape, object.pose, cell_size_);
  for_each_cell_between(matter, object.pose, cell_size_, [&](const Index3& cell, std::int32_t voxel) {
    if (!map_.has_cell(cell) || map_.is_occupied(cell))
      return;
    map_.put(cell, object.first + voxel);
    object.between.push_back(cell);
  });
}

void RigidWorld::take(Object& object) {
  for_each_box(PosedShape(object.shape, object.pose, cell_size_),
               [&](const Index3& cell, const Index3& size, std::int32_t) { map_.take_box(cell, size); });
  for (const Index3& cell : object.between)
    map_.take(cell);
  object.between.clear();
}

void RigidWorld::place(std::span<const Pose> poses) {
  map_ = OccupancyMap(map_.cells());
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    objects_[i].pose = poses[i];
    objects_[i].between.clear();
    put(objects_[i]);
  }
}

std::int64_t RigidWorld::bytes() const {
  std::int64_t sum = map_.bytes();
  for (const Object& object : objects_)
    sum += object.shape.bytes() +
           static_cast<std::int64_t>(sizeof(Object) + object.between.capacity() * sizeof(Index3));
  return sum;
}

} // namespace maille::deform
