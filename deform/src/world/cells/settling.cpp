#include "world/cells/settling.hpp"

#include "lattice/tolerances.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <vector>

namespace maille::deform {

namespace {

/// Largest number of releases per contact and step; afterwards the contact is kept, so that the loop
/// terminates.
constexpr int most_changes = 3;
/// Largest number of slips of a settling: nodes that slip off edges and return would slip forever.
constexpr int most_slips = 8;
/// Relative tolerance of the friction bound.
constexpr double slip_tolerance = 0.01;
/// Part of the largest force below which a pull is solver error.
constexpr double least_pull = 1e-4;

bool asks_the_same(const Pin& one, const Pin& other) {
  return one.voxel == other.voxel && one.axis == other.axis && one.direction == other.direction &&
         one.at == other.at && one.is_asked == other.is_asked;
}

} // namespace

bool Settling::run() {
  begin();
  return run_without_friction() && (friction_ == 0 || !body_.knows_forces() || run_with_friction());
}

bool Settling::run_with_friction() {
  for (Pin& pin : body_.pins()) {
    pin.free = body_.displacement().at(body_.lattice().node(pin.voxel));
    pin.stuck = pin.at;
    pin.hold = 1;
  }
  body_.set_wall_friction(true);
  bool has_settled = true;
  for (int slips = 0; slips < most_slips && has_settled; ++slips) {
    has_settled = run_without_friction(); // with nodes held by friction prescribed
    if (!apply_friction_bound())
      break;
  }
  body_.set_wall_friction(false);
  return has_settled;
}

/// Applies Coulomb's law to the sum over all nodes at faces along an axis on one side: node by node it would
/// not converge, because all nodes interact. @return true if the force exceeded the friction bound, or
/// slipping nodes had less; it then equals the bound
bool Settling::apply_friction_bound() {
  bool has_slipped = false;
  for (int axis = 0; axis < body_.lattice().dimension(); ++axis)
    for (const int direction : {-1, 1})
      has_slipped |= apply_friction_bound(axis, direction);
  return has_slipped;
}

bool Settling::apply_friction_bound(int axis, int direction) {
  const auto is_meant = [&](const Pin& pin) {
    return pin.axis == axis && pin.direction == direction && !pin.is_asked;
  };
  Vec3 grip{};
  double most = 0, hold = 1;
  for (const Pin& pin : body_.pins())
    if (is_meant(pin)) {
      for (std::size_t b = 0; b < 3; ++b)
        grip[b] += pin.grip[b];
      most += friction_ * pin.pressure;
      hold = std::min(hold, pin.hold);
    }
  const double force = std::hypot(grip[0], grip[1], grip[2]);
  const bool is_too_much = force > most * (1 + slip_tolerance),
             is_too_little = hold < 1 && force < most * (1 - slip_tolerance);
  if (!is_too_much && !is_too_little)
    return false;
  hold = force > 0 ? std::clamp(std::max(hold, negligible) * most / force, 0.0, 1.0) : 1.0;
  for (Pin& pin : body_.pins())
    for (std::size_t b = 0; is_meant(pin) && b < 3; ++b) {
      pin.hold = hold;
      if (static_cast<int>(b) != axis)
        pin.at[b] = pin.free[b] + hold * (pin.stuck[b] - pin.free[b]);
    }
  return true;
}

bool Settling::run_without_friction() {
  for (int turns = 0; clock_.has_budget(); ++turns) {
    const Turn outcome = turns < iteration_cap ? turn() : Turn::given_up;
    if (outcome == Turn::again)
      continue;
    if (turns == iteration_cap)
      message_ = "contacts came and went without end";
    return outcome == Turn::settled;
  }
  return false;
}

void Settling::begin() {
  changes_.assign(3 * body_.lattice().n_voxels(), 0);
  largest_before_ = 0;
  std::erase_if(body_.pins(), [](const Pin& pin) { return pin.self.has_value(); }); // detected again
  if (!body_.knows_forces()) // nodes that press against a wall hit it again
    std::erase_if(body_.pins(), [](const Pin& pin) { return !pin.is_asked; });
  else
    release_stale_pins();
  clip_to_limits();
}

/// Removes pins at places that were not reached: they may be incompatible with later pins.
void Settling::clip_to_limits() {
  if (!body_.limits_bind() || !body_.knows_forces())
    return;
  std::vector<Pin> asked;
  std::ranges::copy_if(body_.pins(), std::back_inserter(asked), &Pin::is_asked);
  body_.keep_reached_pins();
  for (const Pin& pin : asked)
    body_.add_pin(pin);
}

Settling::Turn Settling::turn() {
  clock_.count_round();
  const Answer answer = body_.answer(clock_.control);
  if (!has_displacement(answer.status)) {
    message_ = answer.message;
    return Turn::given_up;
  }
  const bool is_whole = is_converged(answer.status);
  if (!is_whole && (clock_.control.seconds_budget || clock_.control.stop_requested))
    clock_.ended = answer.status;
  else if (!is_whole)
    message_ = "its method ended before it had settled";
  if (is_whole && release_pulling_pins())
    return Turn::again;
  body_.watch(answer.displacement);
  const auto hits = find_hits(map_, body_.cells(), body_.lattice(), body_.matter(), body_.displacement(),
                              answer.displacement);
  const auto self_hits =
      body_.self_contact().find(body_.lattice(), body_.displacement(), answer.displacement);
  if (!hits.empty() || !self_hits.empty()) {
    const std::vector<Pin> before = body_.pins();
    const double went = self_hits.empty() || (!hits.empty() && std::ranges::min(hits, {}, &Hit::time).time <
                                                                   self_hits.front().time)
                            ? meet(hits, answer.displacement)
                            : meet_itself(self_hits, answer.displacement);
    if (!is_whole)
      return Turn::given_up;
    if (went > 0 || !std::ranges::equal(before, body_.pins(), asks_the_same))
      return Turn::again;
    message_ = "it is in its own way"; // the next answer would be the same
    return Turn::given_up;
  }
  body_.go_towards(map_, answer.displacement, 1);
  if (!is_whole)
    return Turn::given_up;
  return body_.knows_forces() && release_stale_pins() ? Turn::again : Turn::settled;
}

/// Releases pins that pull. On a body without other holds, the pins' forces sum to zero; if the pins are
/// statically determinate these forces are solver error.
bool Settling::release_pulling_pins() {
  double largest = 0;
  for (const Pin& pin : body_.pins())
    largest = std::max(largest, std::abs(pin.pressure));
  // If the present forces vanish, the previous answer gives the scale of the error.
  const double least = std::max(least_pull * std::max(largest, largest_before_), body_.force_noise());
  largest_before_ = largest;
  return std::erase_if(body_.pins(), [&](const Pin& pin) {
           return pin.pressure < -least && ++changes_of(pin) <= most_changes;
         }) > 0;
}

bool Settling::has_no_wall(const Pin& pin) const {
  return !pin.is_asked && !pin.stays && !pin.self && !body_.cells().is_blocked(map_, wall_of(body_, pin));
}

bool Settling::has_stale_walls() const {
  return std::ranges::any_of(body_.pins(), [this](const Pin& pin) { return has_no_wall(pin); });
}

/// Releases pins without a wall. A node that slides off an edge and returns would do so forever; after some
/// releases its pin stays.
bool Settling::release_stale_pins() {
  for (Pin& pin : body_.pins())
    pin.stays = has_no_wall(pin) ? ++changes_of(pin) > most_changes : pin.stays;
  return std::erase_if(body_.pins(), [this](const Pin& pin) { return has_no_wall(pin); }) > 0;
}

/// Moves to the first contact and pins the nodes that hit a wall. @return the part of the way
double Settling::meet(const std::vector<Hit>& hits, const Displacement& to) {
  double part = 1;
  for (const Hit& hit : hits)
    part = std::min(part, hit.speed > 0 ? hit.time - tolerance / hit.speed : 0.0);
  part = body_.go_towards(map_, to, std::max(0.0, part));
  // After pinning at faces has failed once, nodes are pinned where they are: alternating would not terminate.
  touches_only_ = touches_only_ || !body_.knows_forces() || !pin_at_faces(hits);
  if (touches_only_)
    pin_touching(hits, part);
  return part;
}

/// Moves to the first self-contact and pins both parts there, except nodes that move away from the other
/// part. @return the part of the way
double Settling::meet_itself(const std::vector<SelfHit>& hits, const Displacement& to) {
  const PosedLattice& lattice = body_.lattice();
  std::vector<bool> goes_away;
  for (const SelfHit& hit : hits)
    goes_away.push_back(
        (lattice.position(hit.voxel, to) - lattice.position(hit.voxel, body_.displacement()))[hit.axis] *
            hit.direction <
        -tolerance * lattice.cell_size()[hit.axis]);
  if (std::ranges::all_of(goes_away, std::identity()))
    goes_away.assign(goes_away.size(), false);
  const double part = body_.go_towards(map_, to, hits.front().time);
  clip_to_limits();
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const SelfHit& hit = hits[i];
    if (goes_away[i])
      continue;
    Pin pin{.voxel = hit.voxel, .axis = hit.axis, .direction = hit.direction};
    pin.at = pin.free = pin.stuck = body_.displacement().at(lattice.node(hit.voxel));
    pin.self = hit.partner;
    body_.add_pin(pin);
  }
  return part;
}

Pin Settling::pin_of(const Hit& hit) const {
  return {.voxel = hit.voxel, .axis = hit.axis, .direction = hit.direction, .at = {}, .rest = hit.rest};
}

/// Pins a node where it is or at the face that it hit. For a point of the surface, pins the nodes around it,
/// each shifted as far as the point. If several points pin the same node, the most restrictive pin is kept.
void Settling::add_contact(const Hit& hit, bool at_face) {
  const PosedLattice& lattice = body_.lattice();
  const auto a = static_cast<std::size_t>(hit.axis);
  const double to = hit.wall[a] + (hit.direction < 0 ? 1 : 0) - hit.direction * tolerance;
  const auto pin_node = [&](std::int32_t voxel, double place, bool is_point) {
    Pin pin = pin_of(hit);
    pin.voxel = voxel;
    if (is_point)
      pin.wall = hit.wall;
    pin.at = at_face ? lattice.moved_along(voxel, body_.displacement(), hit.axis, place)
                     : body_.displacement().at(lattice.node(voxel));
    pin.free = pin.stuck = pin.at;
    const auto known = std::ranges::find_if(body_.pins(), [&](const Pin& other) {
      return other.voxel == pin.voxel && other.axis == pin.axis && !other.is_asked;
    });
    if (is_point && known != body_.pins().end() && known->direction == pin.direction &&
        known->at[a] * pin.direction <= pin.at[a] * pin.direction)
      return;
    body_.add_pin(pin);
  };
  if (hit.voxel < lattice.n_voxels())
    return pin_node(hit.voxel, to, false);
  const std::int32_t number = hit.voxel - lattice.n_voxels();
  const double shift = to - body_.matter().place(number, lattice, body_.displacement())[a];
  const BodyMatter::Point& point = body_.matter().point(number);
  for (std::size_t i = 0; i < 4; ++i)
    if (point.weight[i] > 0)
      pin_node(point.node[i], lattice.place(point.node[i], body_.displacement())[a] + shift, true);
}

void Settling::pin_touching(const std::vector<Hit>& hits, double part) {
  clip_to_limits();
  const double first = std::ranges::min(hits, {}, &Hit::time).time;
  for (const Hit& hit : hits) {
    if (hit.time > first && (hit.time - part) * hit.speed > negligible)
      continue;
    add_contact(hit, false);
  }
}

/// @return false without new pins if limits do not allow all of them, or if the object is rotated
bool Settling::pin_at_faces(const std::vector<Hit>& hits) {
  if (body_.lattice().is_turned())
    return false;
  const std::vector<Pin> before = body_.pins();
  for (const Hit& hit : hits)
    add_contact(hit, true);
  if (body_.can_be_met())
    return true;
  body_.pins() = before;
  return false;
}

} // namespace maille::deform
