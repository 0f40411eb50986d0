/// Contact cell by cell between objects that can move: a body hands its movement on to the objects in its
/// way.
///
/// A body settles among the others as if they stood still (Settling). Each pinned node then requests the
/// movement that it could not make (`rest`) from the object in its way: a node of a body becomes a pin with a
/// prescribed place there, a rigid object a shift. The receiver settles in turn and may hand on further. With
/// forces known, may_push() lets the side with the larger pressure push, a cell at a time, until the
/// pressures cannot be made more equal.
///
/// Feasible at any time. Heuristic: the order of receivers, and the limits on pushes that end the exchange.

#include "lattice/tolerances.hpp"
#include "world/world_frame.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace maille::deform {

namespace {

/// Pushes across the faces between two bodies in one step, in which driven nodes move by at most a cell.
constexpr int most_pushes_a_step = 4;

/// Where a node is that has just left a cell in a direction [cells].
double just_behind(int cell, int direction) {
  return cell + (direction > 0 ? 1 + tolerance : -tolerance);
}

} // namespace

/// @param to where what lies in the cell is to go along the axis [cells] @param wall what will then be in its
///        way back
Pin WorldFrame::asked_pin(const DeformableObject& body, const DeformableObject::Carrier& carrier, int axis,
                          int direction, double to, const Index3& wall) {
  const PosedLattice& lattice = body.lattice();
  Pin pin{.voxel = carrier.voxel, .axis = axis, .direction = direction, .is_asked = true};
  if (carrier.is_between) {
    to += lattice.place(carrier.voxel, body.displacement())[static_cast<std::size_t>(axis)] - carrier.place;
    pin.wall = wall;
  }
  pin.at = lattice.moved_along(carrier.voxel, body.displacement(), axis, to);
  return pin;
}

/// Lets a body come to rest, and push out of its way what yields to it.
void WorldFrame::settle(int object) {
  DeformableObject& body = parts_.body(object);
  unsettled_.erase(object);
  in_progress_.insert(object);
  for (int push = 0; push < iteration_cap; ++push) {
    Settling settling(parts_.map(), body, parts_.scene.friction, clock_);
    const bool is_converged = settling.run();
    if (!settling.message().empty() && result_.message.empty())
      result_.message = "object `" + name(object) + "` stays as it is: " + settling.message();
    if (!is_converged && clock_.ended)
      unsettled_.insert(object);
    // Without forces the receiver absorbs the whole movement.
    if (!is_converged || !hand_on(object) || !body.knows_forces())
      break;
  }
  in_progress_.erase(object);
}

/// @return whether anything has moved
bool WorldFrame::hand_on(int object) {
  const Requests requests = requests_of(object);
  bool has_moved = false;
  for (const auto& [to, pins] : requests.pins)
    has_moved |= ask(to, pins);
  for (const auto& [to, shift] : requests.shifts)
    has_moved |= push_free_rigid(to.first, shift, to.second);
  return has_moved;
}

WorldFrame::Requests WorldFrame::requests_of(int object) {
  const DeformableObject& body = parts_.body(object);
  std::map<Contacts, std::vector<const Pin*>> by_contacts;
  for (const Pin& pin : body.pins()) {
    const int other = parts_.object_in(wall_of(body, pin));
    const bool presses = body.knows_forces() ? pin.pressure > 0 : pin.rest * pin.direction > 0;
    if (!pin.is_asked && !pin.self && presses && other >= 0 && other != object &&
        !in_progress_.contains(other))
      by_contacts[{other, pin.axis, pin.direction}].push_back(&pin);
  }
  Requests requests;
  for (const auto& [contacts, pins] : by_contacts)
    if (is_movable(contacts.other) || (parts_.is_body(contacts.other) && may_push(object, contacts, pins)))
      for (const Pin* const pin : pins)
        request(object, *pin, contacts.other, requests);
  return requests;
}

/// Requests a movement from the object that blocks a node.
void WorldFrame::request(int object, const Pin& pin, int other, Requests& requests) {
  const DeformableObject& body = parts_.body(object);
  const auto a = static_cast<std::size_t>(pin.axis);
  const Asked by{object, body.lattice().node(pin.voxel), pin.rest};
  if (is_movable(other)) {
    Shift& shift = requests.shifts[{other, pin.axis}];
    const double movement = pin.rest * parts_.scene.spacing[a];
    if (std::abs(movement) > std::abs(shift.movement))
      shift = {movement, by};
    return;
  }
  const Index3 wall = wall_of(body, pin);
  const DeformableObject& receiver = parts_.body(other);
  for (const DeformableObject::Carrier& carrier : receiver.carriers(parts_.map(), wall, pin.axis)) {
    const double to = body.knows_forces() ? just_behind(wall[a], pin.direction) : carrier.place + pin.rest;
    add(requests.pins[other], asked_pin(receiver, carrier, pin.axis, -pin.direction, to, wall),
        {by.from, by.from_voxel, to - carrier.place});
  }
}

/// The largest of several requests to one node along one axis counts.
void WorldFrame::add(std::vector<AskedPin>& list, const Pin& pin, const Asked& by) {
  const auto same = std::ranges::find_if(list, [&](const AskedPin& known) {
    return known.pin.voxel == pin.voxel && known.pin.axis == pin.axis;
  });
  if (same == list.end())
    list.push_back({pin, by});
  else if (std::abs(by.movement) > std::abs(same->by.movement))
    *same = {pin, by};
}

/// Without forces every mover pushes. With forces the object with the larger pressure pushes, at all faces
/// between the two at once so that they stay even; but only if that makes the pressures more equal, estimated
/// from earlier pushes.
bool WorldFrame::may_push(int object, const Contacts& contacts, const std::vector<const Pin*>& pins) {
  if (!parts_.body(object).knows_forces())
    return true;
  double imbalance = -pressure_back(object, contacts);
  for (const Pin* const pin : pins)
    imbalance += pin->pressure;
  const int low = std::min(object, contacts.other), high = std::max(object, contacts.other);
  const double upwards = object == low ? imbalance : -imbalance;
  WorldParts::Push& push = parts_.pushes[{low, high, contacts.axis}];
  if (push.before)
    push.change = std::max(push.change, std::abs(*push.before - upwards));
  push.before.reset();
  if (!(imbalance > 0.5 * push.change) || push.n >= most_pushes_a_step)
    return false;
  push.before = upwards;
  ++push.n;
  return true;
}

double WorldFrame::pressure_back(int object, const Contacts& contacts) const {
  const DeformableObject& receiver = parts_.body(contacts.other);
  double sum = 0;
  for (const Pin& back : receiver.pins())
    if (back.axis == contacts.axis && back.direction == -contacts.direction && back.pressure > 0 &&
        parts_.object_in(wall_of(receiver, back)) == object)
      sum += back.pressure;
  return sum;
}

/// Asks nodes of a body to move, and keeps account of what they did. @return whether any of them moved
bool WorldFrame::ask(int object, const std::vector<AskedPin>& asked) {
  DeformableObject& body = parts_.body(object);
  std::vector<double> before;
  for (const AskedPin& wanted : asked) {
    before.push_back(body.lattice().position(wanted.pin.voxel, body.displacement())[wanted.pin.axis]);
    body.add_pin(wanted.pin);
  }
  body.reconcile_requests();
  settle(object);
  bool has_moved = false;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const auto& [pin, by] = asked[i];
    const double size = parts_.scene.spacing[static_cast<std::size_t>(pin.axis)];
    HandOver hand_over{by.from,  by.from_voxel,      object, body.lattice().node(pin.voxel),
                       pin.axis, by.movement * size, 0};
    hand_over.moved = body.lattice().position(pin.voxel, body.displacement())[pin.axis] - before[i];
    has_moved |= std::abs(hand_over.moved) > tolerance * size;
    result_.handed_on.push_back(hand_over);
  }
  if (!body.knows_forces()) {
    body.pins().clear();
    return has_moved;
  }
  body.keep_reached_pins();
  for (Pin& pin : body.pins())
    pin.is_asked = false;
  unsettled_.insert(object); // moves into the room that the pusher has left
  return has_moved;
}

} // namespace maille::deform
