#include "world/cells/pushing.hpp"

#include "lattice/tolerances.hpp"
#include "world/occupancy/first_contact.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Largest number of pushes across the faces between two bodies in one step, in which driven nodes move by at
/// most a cell.
constexpr int most_pushes_a_step = 4;

/// Coordinate just outside a cell in a direction [cells].
double just_behind(int cell, int direction) {
  return cell + (direction > 0 ? 1 + tolerance : -tolerance);
}

/// Rest of a motion after a part of it.
RigidMotion rest_of(const RigidMotion& motion, double done) {
  RigidMotion rest = motion;
  rest.about += done * motion.by;
  rest.by *= 1 - done;
  rest.angle *= 1 - done;
  return rest;
}

} // namespace

Pushing::Pushing(FrameRun& frame, PushEffects& effects)
    : frame_(frame), world_(frame.world), effects_(effects) {
  for (int object = 0; object < world_.n_objects(); ++object)
    if (world_.member(object).is_unsettled)
      unsettled.insert(object);
}

bool Pushing::is_movable(int object) const {
  const auto& member = world_.member(object);
  return member.kind == ObjectKind::rigid && !member.is_driven && !in_progress_.contains(object);
}

double Pushing::push_rigid(int object, RigidMotion rest, bool slides) {
  const int index = world_.member(object).index;
  in_progress_.insert(object);
  double left = 1, done = 0;
  for (int contact = 0; contact < iteration_cap && frame_.clock.has_budget(); ++contact) {
    const auto gripped = pins_on(object);
    const Pose before = world_.rigid.pose(index);
    const MoveResult moved = world_.rigid.move(index, rest);
    take_along(gripped, before, world_.rigid.pose(index));
    done += left * moved.fraction;
    left *= 1 - moved.fraction;
    if (moved.contacts.empty() || left < tolerance)
      break;
    rest = rest_of(rest, moved.fraction);
    if (clear_cell(object, rest, moved.contacts[0]))
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

/// Nodes that touch a rigid object, if there is friction between them.
std::vector<std::pair<int, std::size_t>> Pushing::pins_on(int object) const {
  std::vector<std::pair<int, std::size_t>> list;
  for (int other = 0; world_.scene.friction > 0 && other < world_.n_objects(); ++other) {
    if (!world_.is_body(other) || !world_.body(other).knows_forces() ||
        world_.body(other).lattice().is_turned())
      continue;
    const std::vector<Pin>& pins = world_.body(other).pins();
    for (std::size_t i = 0; i < pins.size(); ++i)
      if (world_.object_in(wall_of(world_.body(other), pins[i])) == object)
        list.emplace_back(other, i);
  }
  return list;
}

/// Moves the places where friction holds nodes with the wall.
void Pushing::take_along(const std::vector<std::pair<int, std::size_t>>& gripped, const Pose& from,
                         const Pose& to) {
  for (const auto& [object, i] : gripped) {
    DeformableObject& body = world_.body(object);
    Pin& pin = body.pins()[i];
    const Eigen::Vector3d x = body.lattice().rest(pin.voxel) +
                              Eigen::Vector3d(pin.at[0], pin.at[1], pin.at[2]),
                          shift = to.position +
                                  to.rotation * (from.rotation.transpose() * (x - from.position)) - x;
    for (int b = 0; b < world_.scene.dimension; ++b)
      if (b != pin.axis && shift[b] != 0) {
        pin.at[b] += shift[b];
        unsettled.insert(object);
      }
  }
}

/// @return true if the cell of the contact is now free
bool Pushing::clear_cell(int object, const RigidMotion& rest, const Contact& contact) {
  const int other = world_.object_in(contact.cell);
  if (other < 0)
    return false;
  if (world_.is_body(other)) {
    // A node beside those that move away may enter a cell on the way: it receives a request too, and the
    // earlier requests stay. A separate request at its own contact would move it out and let the others
    // return.
    PinRequests asked;
    for (int turn = 0; turn < iteration_cap; ++turn)
      if (!ask_bodies_in_the_way(object, rest, asked))
        break;
  } else if (is_movable(other)) {
    const RigidShape& shape = world_.rigid.shape(world_.member(object).index);
    const Pose& pose = world_.rigid.pose(world_.member(object).index);
    const Eigen::Vector3d within = shape.centre_of(contact.voxel);
    const Pose end = rest.moved(pose, 1);
    const double movement =
        (end.position + end.rotation * within - pose.position - pose.rotation * within)[contact.axis];
    push_free_rigid(other, {object, contact.voxel, movement}, contact.axis);
  }
  return !world_.map().is_occupied(contact.cell);
}

bool Pushing::push_free_rigid(int object, const Request& shift, int axis) {
  if (!is_movable(object) || std::abs(shift.movement) == 0)
    return false;
  RigidMotion motion;
  motion.by[axis] = shift.movement;
  const int index = world_.member(object).index;
  const double before = world_.rigid.pose(index).position[axis];
  push_rigid(object, motion, false);
  const double moved = world_.rigid.pose(index).position[axis] - before;
  frame_.result.handed_on.push_back({shift.from, shift.from_voxel, object, 0, axis, shift.movement, moved});
  return std::abs(moved) > tolerance * std::abs(shift.movement);
}

/// Requests that all nodes in the way of a rigid object, up to the first immovable obstacle, leave the cells
/// that it will enter.
/// @param[in,out] asked  nodes with earlier requests, which are requested to stay outside @return true if
///        there are new nodes
bool Pushing::ask_bodies_in_the_way(int object, const RigidMotion& rest, PinRequests& asked) {
  std::size_t n_known = 0;
  for (auto& [other, pins] : asked)
    for (PinRequest& known : pins) {
      known.by.movement = 0;
      ++n_known;
    }
  const auto& member = world_.member(object);
  const auto entries =
      entries_on_the_way(world_.map(), world_.scene.spacing, world_.rigid.shape(member.index), member.first,
                         world_.rigid.pose(member.index), rest);
  double end = 2;
  for (const Entry& entry : entries)
    if (const int other = world_.object_in(entry.cell);
        !world_.is_body(other) && (other < 0 || !is_movable(other)))
      end = std::min(end, entry.time);
  std::map<Index3, Entry> entered; // by cell: first entry
  for (const Entry& entry : entries)
    if (const auto [known, is_new] = entered.insert({entry.cell, entry});
        !is_new && entry.time < known->second.time)
      known->second = entry;
  for (const auto& [cell, entry] : entered) {
    const int other = world_.object_in(cell);
    if (!world_.is_body(other) || in_progress_.contains(other) || entry.time > end)
      continue;
    const auto a = static_cast<std::size_t>(entry.axis);
    Index3 last = cell; // last cell that the object will occupy
    for (Index3 next = cell; entered.contains(next); next[a] += entry.direction)
      last = next;
    const double to = last[a] + (entry.direction > 0 ? 1 + tolerance : -tolerance);
    const DeformableObject& body = world_.body(other);
    for (const DeformableObject::Carrier& carrier : body.carriers(world_.map(), cell, entry.axis))
      add(asked[other], pin_of(body, carrier, entry.axis, -entry.direction, to, last),
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

/// Settles bodies until none moves.
void Pushing::come_to_rest() {
  for (int turn = 0; turn < iteration_cap && frame_.clock.has_budget(); ++turn) {
    for (int object = 0; object < world_.n_objects(); ++object)
      if (world_.is_body(object) && world_.body(object).knows_forces() &&
          Settling(world_.map(), world_.body(object), 0, frame_.clock).has_stale_walls())
        unsettled.insert(object);
    if (unsettled.empty())
      break;
    settle(*unsettled.begin());
  }
  for (DeformableObject& body : world_.bodies)
    body.settle_handles();
}

/// @param to target of the matter in the cell, along the axis [cells] @param wall cell that will then block
///        its return
Pin Pushing::pin_of(const DeformableObject& body, const DeformableObject::Carrier& carrier, int axis,
                    int direction, double to, const Index3& wall) {
  const PosedLattice& lattice = body.lattice();
  Pin pin{.voxel = carrier.voxel, .axis = axis, .direction = direction, .is_asked = true};
  if (carrier.is_between) {
    to += lattice.place(carrier.voxel, body.displacement())[axis] - carrier.place;
    pin.wall = wall;
  }
  pin.at = lattice.moved_along(carrier.voxel, body.displacement(), axis, to);
  return pin;
}

/// Settles a body, and lets it push movable objects in its way.
void Pushing::settle(int object) {
  DeformableObject& body = world_.body(object);
  unsettled.erase(object);
  in_progress_.insert(object);
  for (int push = 0; push < iteration_cap; ++push) {
    Settling settling(world_.map(), body, world_.scene.friction, frame_.clock);
    const bool is_converged = settling.run();
    if (!settling.message().empty() && frame_.result.message.empty())
      frame_.result.message = "object `" + world_.name(object) + "` stays as it is: " + settling.message();
    if (!is_converged && frame_.clock.ended)
      unsettled.insert(object);
    // Without forces the receiver absorbs the whole movement.
    if (!is_converged || !push_others(object) || !body.knows_forces())
      break;
  }
  in_progress_.erase(object);
}

/// @return true if any object has moved
bool Pushing::push_others(int object) {
  const Requests requests = requests_of(object);
  bool has_moved = false;
  for (const auto& [to, pins] : requests.pins)
    has_moved |= ask(to, pins);
  for (const auto& [to, shift] : requests.shifts)
    has_moved |= push_free_rigid(to.first, shift, to.second);
  return has_moved;
}

Pushing::Requests Pushing::requests_of(int object) {
  const DeformableObject& body = world_.body(object);
  std::map<Faces, std::vector<const Pin*>> by_faces;
  for (const Pin& pin : body.pins()) {
    const int other = world_.object_in(wall_of(body, pin));
    const bool presses = body.knows_forces() ? pin.pressure > 0 : pin.rest * pin.direction > 0;
    if (!pin.is_asked && !pin.self && presses && other >= 0 && other != object &&
        !in_progress_.contains(other))
      by_faces[{other, pin.axis, pin.direction}].push_back(&pin);
  }
  Requests requests;
  for (const auto& [faces, pins] : by_faces)
    if (is_movable(faces.other) || (world_.is_body(faces.other) && may_push(object, faces, pins)))
      for (const Pin* const pin : pins)
        request(object, *pin, faces.other, requests);
  return requests;
}

/// Requests a movement from the object that blocks a node.
void Pushing::request(int object, const Pin& pin, int other, Requests& requests) {
  const DeformableObject& body = world_.body(object);
  const auto a = static_cast<std::size_t>(pin.axis);
  const Request by{object, body.lattice().node(pin.voxel), pin.rest};
  if (is_movable(other)) {
    Request& shift = requests.shifts[{other, pin.axis}];
    const double movement = pin.rest * world_.scene.spacing[a];
    if (std::abs(movement) > std::abs(shift.movement))
      shift = {object, by.from_voxel, movement};
    return;
  }
  const Index3 wall = wall_of(body, pin);
  const DeformableObject& receiver = world_.body(other);
  for (const DeformableObject::Carrier& carrier : receiver.carriers(world_.map(), wall, pin.axis)) {
    const double to = body.knows_forces() ? just_behind(wall[a], pin.direction) : carrier.place + pin.rest;
    add(requests.pins[other], pin_of(receiver, carrier, pin.axis, -pin.direction, to, wall),
        {by.from, by.from_voxel, to - carrier.place});
  }
}

/// Adds a request; of several to one node along one axis, the largest is kept.
void Pushing::add(std::vector<PinRequest>& list, const Pin& pin, const Request& by) {
  const auto same = std::ranges::find_if(list, [&](const PinRequest& known) {
    return known.pin.voxel == pin.voxel && known.pin.axis == pin.axis;
  });
  if (same == list.end())
    list.push_back({pin, by});
  else if (std::abs(by.movement) > std::abs(same->by.movement))
    *same = {pin, by};
}

/// True if an object may push. Without forces every moving object pushes. With forces the object with the
/// larger pressure pushes, at all faces between the two at once so that they stay aligned, but only if that
/// makes the pressures more equal, estimated from earlier pushes.
bool Pushing::may_push(int object, const Faces& faces, const std::vector<const Pin*>& pins) {
  if (!world_.body(object).knows_forces())
    return true;
  double imbalance = -pressure_back(object, faces);
  for (const Pin* const pin : pins)
    imbalance += pin->pressure;
  const int low = std::min(object, faces.other), high = std::max(object, faces.other);
  const double upwards = object == low ? imbalance : -imbalance;
  PushEffect& push = effects_[{low, high, faces.axis}];
  if (push.before)
    push.change = std::max(push.change, std::abs(*push.before - upwards));
  push.before.reset();
  if (!(imbalance > 0.5 * push.change) || push.n >= most_pushes_a_step)
    return false;
  push.before = upwards;
  ++push.n;
  return true;
}

double Pushing::pressure_back(int object, const Faces& faces) const {
  const DeformableObject& receiver = world_.body(faces.other);
  double sum = 0;
  for (const Pin& back : receiver.pins())
    if (back.axis == faces.axis && back.direction == -faces.direction && back.pressure > 0 &&
        world_.object_in(wall_of(receiver, back)) == object)
      sum += back.pressure;
  return sum;
}

/// Requests movements of nodes of a body, and records the results. @return true if any of them moved
bool Pushing::ask(int object, const std::vector<PinRequest>& asked) {
  DeformableObject& body = world_.body(object);
  std::vector<double> before;
  for (const PinRequest& wanted : asked) {
    before.push_back(body.lattice().position(wanted.pin.voxel, body.displacement())[wanted.pin.axis]);
    body.add_pin(wanted.pin);
  }
  body.reconcile_requests();
  settle(object);
  bool has_moved = false;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const auto& [pin, by] = asked[i];
    const double size = world_.scene.spacing[pin.axis];
    HandOver hand_over{by.from,  by.from_voxel,      object, body.lattice().node(pin.voxel),
                       pin.axis, by.movement * size, 0};
    hand_over.moved = body.lattice().position(pin.voxel, body.displacement())[pin.axis] - before[i];
    has_moved |= std::abs(hand_over.moved) > tolerance * size;
    frame_.result.handed_on.push_back(hand_over);
  }
  if (!body.knows_forces()) {
    body.pins().clear();
    return has_moved;
  }
  body.keep_reached_pins();
  for (Pin& pin : body.pins())
    pin.is_asked = false;
  unsettled.insert(object); // moves into the space that the pusher has freed
  return has_moved;
}

} // namespace maille::deform
