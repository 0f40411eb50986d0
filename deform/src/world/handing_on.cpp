#include "world/world_frame.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Of pushes of one body in one step: faces move a cell at a time and never back, so this ends before; a net under rounding.
constexpr int most_pushes = 200;
/// A body yields only to a pressure that is larger by this part.
constexpr double clearly = 1 + 1e-6;

Index3 wall_of(const DeformableObject& body, const Pin& pin) {
  Index3 wall = body.cells().cell(pin.voxel);
  wall[static_cast<std::size_t>(pin.axis)] += pin.direction;
  return wall;
}

/// Where a node is that has just left a cell in a direction [cells].
double just_behind(int cell, int direction) {
  return cell + (direction > 0 ? 1 + node_skin : -node_skin);
}

} // namespace

/// Lets a body come to rest, and push out of its way what yields to it.
void WorldFrame::settle(int object) {
  DeformableObject& body = parts_.body(object);
  unsettled_.erase(object);
  in_progress_.insert(object);
  for (int push = 0; push < most_pushes; ++push) {
    Settling settling(parts_.map(), body, clock_);
    const bool is_settled = settling.run();
    if (!settling.message().empty() && result_.message.empty())
      result_.message = "object `" + name(object) + "` stays as it is: " + settling.message();
    if (!is_settled)
      unsettled_.insert(object);
    // Without forces the movement is used up by whom it was handed to.
    if (!is_settled || !hand_on(object) || !body.knows_forces())
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
  Requests requests;
  for (const Pin& pin : parts_.body(object).pins())
    if (!pin.is_asked)
      request(object, pin, requests);
  return requests;
}

/// What a node in contact asks of whoever is in its way.
void WorldFrame::request(int object, const Pin& pin, Requests& requests) {
  const DeformableObject& body = parts_.body(object);
  const Index3 wall = wall_of(body, pin);
  const int other = parts_.object_in(wall);
  const bool presses = body.knows_forces() ? pin.pressure > 0 : pin.rest * pin.direction > 0;
  if (other < 0 || other == object || !presses || in_progress_.contains(other))
    return;
  const auto a = static_cast<std::size_t>(pin.axis);
  const Asked by{object, body.lattice().node(pin.voxel), pin.rest};
  if (is_movable(other)) {
    Shift& shift = requests.shifts[{other, pin.axis}];
    const double movement = pin.rest * parts_.scene.spacing[a];
    if (std::abs(movement) > std::abs(shift.movement))
      shift = {movement, by};
  }
  if (!parts_.is_body(other) || !may_push(object, pin, other, wall))
    return;
  const DeformableObject& receiver = parts_.body(other);
  for (const std::int32_t voxel : receiver.cells().voxels_in(parts_.map(), wall)) {
    const double place = receiver.lattice().place(voxel, receiver.displacement())[a];
    const double to = body.knows_forces() ? just_behind(wall[a], pin.direction) : place + pin.rest;
    const Pin asked{.voxel = voxel,
                    .axis = pin.axis,
                    .direction = -pin.direction,
                    .at = receiver.lattice().moved_along(voxel, receiver.displacement(), pin.axis, to),
                    .is_asked = true};
    std::vector<AskedPin>& list = requests.pins[other];
    const auto same = std::ranges::find_if(
        list, [&](const AskedPin& known) { return known.pin.voxel == voxel && known.pin.axis == pin.axis; });
    const AskedPin wanted{asked, {by.from, by.from_voxel, to - place}};
    if (same == list.end())
      list.push_back(wanted);
    else if (std::abs(wanted.by.movement) > std::abs(same->by.movement))
      *same = wanted;
  }
}

/// Without forces whoever moves pushes; else whoever presses more, and no face goes back and forth.
bool WorldFrame::may_push(int object, const Pin& pin, int other, const Index3& wall) {
  if (!parts_.body(object).knows_forces())
    return true;
  if (!(pin.pressure > clearly * pressure_back(other, wall, pin)))
    return false;
  const auto b = static_cast<std::size_t>((pin.axis + 1) % 3),
             c = static_cast<std::size_t>((pin.axis + 2) % 3);
  const auto [low, high] = std::minmax(object, other);
  const int way = object == low ? 1 : -1;
  const auto [known, is_new] = ways_.insert({{low, high, pin.axis, wall[b], wall[c]}, way});
  return is_new || known->second == way;
}

double WorldFrame::pressure_back(int other, const Index3& wall, const Pin& pin) const {
  const DeformableObject& receiver = parts_.body(other);
  double sum = 0;
  for (const Pin& back : receiver.pins())
    if (back.axis == pin.axis && back.direction == -pin.direction &&
        receiver.cells().cell(back.voxel) == wall)
      sum += std::max(0.0, back.pressure);
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
  settle(object);
  bool has_moved = false;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const auto& [pin, by] = asked[i];
    const double size = parts_.scene.spacing[static_cast<std::size_t>(pin.axis)];
    HandOver hand_over{by.from,  by.from_voxel,      object, body.lattice().node(pin.voxel),
                       pin.axis, by.movement * size, 0};
    hand_over.moved = body.lattice().position(pin.voxel, body.displacement())[pin.axis] - before[i];
    has_moved |= std::abs(hand_over.moved) > node_skin * size;
    result_.handed_on.push_back(hand_over);
  }
  if (!body.knows_forces()) {
    body.pins().clear();
    return has_moved;
  }
  for (Pin& pin : body.pins())
    pin.is_asked = false;
  unsettled_.insert(object); // comes to where whoever pushed it has left it room
  return has_moved;
}

} // namespace maille::deform
