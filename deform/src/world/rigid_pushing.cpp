#include "lattice/tolerances.hpp"
#include "world/occupancy/posed_shape.hpp"
#include "world/world_frame.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Rest of a motion after a part of it.
RigidMotion rest_of(const RigidMotion& motion, double done) {
  RigidMotion rest = motion;
  rest.about += done * motion.by;
  rest.by *= 1 - done;
  rest.angle *= 1 - done;
  return rest;
}

} // namespace

bool WorldFrame::is_movable(int object) const {
  const auto& member = parts_.member(object);
  return member.kind == ObjectKind::rigid && !member.is_driven && !in_progress_.contains(object);
}

/// Moves a rigid object, and what makes way for it. @return how much of the motion was done
double WorldFrame::push_rigid(int object, RigidMotion rest, bool slides) {
  const int index = parts_.member(object).index;
  if (parts_.scene.contact == ContactLaw::halving) // the other object is not known, so none is pushed
    return parts_.rigid.move_by_halving(index, rest).fraction;
  in_progress_.insert(object);
  double left = 1, done = 0;
  for (int contact = 0; contact < iteration_cap && clock_.may_go_on(); ++contact) {
    const auto gripped = pins_on(object);
    const Pose before = parts_.rigid.pose(index);
    const MoveResult moved = parts_.rigid.move(index, rest);
    take_along(gripped, before, parts_.rigid.pose(index));
    done += left * moved.fraction;
    left *= 1 - moved.fraction;
    if (moved.contacts.empty() || left < tolerance)
      break;
    rest = rest_of(rest, moved.fraction);
    if (make_way(object, rest, moved.contacts[0]))
      continue;
    if (!slides)
      break;
    rest.by[moved.contacts[0].axis] = 0;
    rest.angle = 0;
    if (rest.by.isZero(0))
      break;
  }
  in_progress_.erase(object);
  return done;
}

/// Nodes that touch a rigid object, where there is friction between them.
std::vector<std::pair<int, std::size_t>> WorldFrame::pins_on(int object) const {
  std::vector<std::pair<int, std::size_t>> list;
  for (int other = 0; parts_.scene.friction > 0 && other < parts_.n_objects(); ++other) {
    if (!parts_.is_body(other) || !parts_.body(other).knows_forces() ||
        parts_.body(other).lattice().is_turned())
      continue;
    const std::vector<Pin>& pins = parts_.body(other).pins();
    for (std::size_t i = 0; i < pins.size(); ++i)
      if (parts_.object_in(wall_of(parts_.body(other), pins[i])) == object)
        list.emplace_back(other, i);
  }
  return list;
}

/// The places that friction holds nodes at go with the wall.
void WorldFrame::take_along(const std::vector<std::pair<int, std::size_t>>& gripped, const Pose& from,
                            const Pose& to) {
  for (const auto& [object, i] : gripped) {
    DeformableObject& body = parts_.body(object);
    Pin& pin = body.pins()[i];
    const Eigen::Vector3d x = body.lattice().rest(pin.voxel) +
                              Eigen::Vector3d(pin.at[0], pin.at[1], pin.at[2]),
                          shift = to.position +
                                  to.rotation * (from.rotation.transpose() * (x - from.position)) - x;
    for (int b = 0; b < parts_.scene.dimension; ++b)
      if (b != pin.axis && shift[b] != 0) {
        pin.at[static_cast<std::size_t>(b)] += shift[b];
        unsettled_.insert(object);
      }
  }
}

/// @return whether the cell of the contact is free now
bool WorldFrame::make_way(int object, const RigidMotion& rest, const Contact& contact) {
  const int other = parts_.object_in(contact.cell);
  if (other < 0)
    return false;
  if (parts_.is_body(other)) {
    // One beside those that make way may come into a cell on the way: it is asked too, while they stay out.
    // Asked by itself at its own contact it would go, and they come back.
    PinRequests asked;
    for (int turn = 0; turn < iteration_cap; ++turn)
      if (!ask_bodies_in_the_way(object, rest, asked))
        break;
  } else if (is_movable(other)) {
    const RigidShape& shape = parts_.rigid.shape(parts_.member(object).index);
    const Pose& pose = parts_.rigid.pose(parts_.member(object).index);
    const Eigen::Vector3d within = shape.centre_of(contact.voxel);
    const Pose end = rest.moved(pose, 1);
    const double movement =
        (end.position + end.rotation * within - pose.position - pose.rotation * within)[contact.axis];
    push_free_rigid(other, {movement, {object, contact.voxel, movement}}, contact.axis);
  }
  return !parts_.map().is_occupied(contact.cell);
}

bool WorldFrame::push_free_rigid(int object, const Shift& shift, int axis) {
  if (!is_movable(object) || std::abs(shift.movement) == 0)
    return false;
  RigidMotion motion;
  motion.by[axis] = shift.movement;
  const int index = parts_.member(object).index;
  const double before = parts_.rigid.pose(index).position[axis];
  push_rigid(object, motion, false);
  const double moved = parts_.rigid.pose(index).position[axis] - before;
  result_.handed_on.push_back({shift.by.from, shift.by.from_voxel, object, 0, axis, shift.movement, moved});
  return std::abs(moved) > tolerance * std::abs(shift.movement);
}

/// Asks all nodes that are in the way of a rigid object, up to where something stops it for good, to leave
/// the cells that it will enter.
/// @param[in,out] asked  nodes that have been asked before, which are asked to stay there @return whether
/// there are others
bool WorldFrame::ask_bodies_in_the_way(int object, const RigidMotion& rest, PinRequests& asked) {
  std::size_t n_known = 0;
  for (auto& [other, pins] : asked)
    for (AskedPin& known : pins) {
      known.by.movement = 0;
      ++n_known;
    }
  const auto& member = parts_.member(object);
  const auto entries =
      entries_on_the_way(parts_.map(), parts_.scene.spacing, parts_.rigid.shape(member.index), member.first,
                         parts_.rigid.pose(member.index), rest);
  double end = 2;
  for (const Entry& entry : entries)
    if (const int other = parts_.object_in(entry.cell);
        !parts_.is_body(other) && (other < 0 || !is_movable(other)))
      end = std::min(end, entry.time);
  std::map<Index3, Entry> entered; // through which face first
  for (const Entry& entry : entries)
    if (const auto [known, is_new] = entered.insert({entry.cell, entry});
        !is_new && entry.time < known->second.time)
      known->second = entry;
  for (const auto& [cell, entry] : entered) {
    const int other = parts_.object_in(cell);
    if (!parts_.is_body(other) || in_progress_.contains(other) || entry.time > end)
      continue;
    const auto a = static_cast<std::size_t>(entry.axis);
    Index3 last = cell; // of those that will be the object's
    for (Index3 next = cell; entered.contains(next); next[a] += entry.direction)
      last = next;
    const double to = last[a] + (entry.direction > 0 ? 1 + tolerance : -tolerance);
    const DeformableObject& body = parts_.body(other);
    for (const DeformableObject::Carrier& carrier : body.carriers(parts_.map(), cell, entry.axis))
      add(asked[other], asked_pin(body, carrier, entry.axis, -entry.direction, to, last),
          {object, entry.voxel, to - carrier.place});
  }
  std::size_t n = 0;
  for (const auto& [other, pins] : asked)
    n += pins.size();
  if (n > n_known)
    for (const auto& [other, pins] : asked)
      ask(other, pins);
  return n > n_known;
}

} // namespace maille::deform
