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

/// Releases per contact and step; afterwards the contact is kept, so the loop terminates.
constexpr int most_changes = 3;
/// Answers with friction a settling: nodes that slip off edges and come back would slip without end.
constexpr int most_slips = 8;
/// Share by which a force may miss what friction allows.
constexpr double slip_tolerance = 0.01;
/// Share of the largest force below which a pull is solver error.
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
  body_.let_walls_grip(true);
  bool has_settled = true;
  for (int slips = 0; slips < most_slips && has_settled; ++slips) {
    has_settled = run_without_friction(); // but with what the walls hold
    if (!let_slip())
      break;
  }
  body_.let_walls_grip(false);
  return has_settled;
}

/// Coulomb's law for all nodes at faces along an axis on one side together: node by node it would not
/// converge, since each feels the others. @return whether they are held by more than friction allows, or
/// slide and are held by less; then they are held by what it allows
bool Settling::let_slip() {
  bool has_slipped = false;
  for (int axis = 0; axis < body_.lattice().dimension(); ++axis)
    for (const int direction : {-1, 1})
      has_slipped |= let_slip(axis, direction);
  return has_slipped;
}

bool Settling::let_slip(int axis, int direction) {
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
  for (int turns = 0; clock_.may_go_on(); ++turns) {
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
  std::erase_if(body_.pins(), [](const Pin& pin) { return pin.self.has_value(); }); // found anew
  if (!body_.knows_forces()) // a node that still wants in will meet the wall again
    std::erase_if(body_.pins(), [](const Pin& pin) { return !pin.is_asked; });
  else
    forget_walls_that_are_gone();
  clip_to_limits();
}

/// Pins at places that were not reached may contradict later pins.
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
  if (is_whole && let_go_of_pulled())
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
    message_ = "it is in its own way"; // the next answer would be this one
    return Turn::given_up;
  }
  body_.go_towards(map_, answer.displacement, 1);
  if (!is_whole)
    return Turn::given_up;
  return body_.knows_forces() && forget_walls_that_are_gone() ? Turn::again : Turn::settled;
}

/// On a body that is otherwise free, the pins' forces sum to zero; if the pins are statically determinate
/// these forces are noise.
bool Settling::let_go_of_pulled() {
  double largest = 0;
  for (const Pin& pin : body_.pins())
    largest = std::max(largest, std::abs(pin.pressure));
  // The error of an answer that has no forces is that of the one before.
  const double least = std::max(least_pull * std::max(largest, largest_before_), body_.force_noise());
  largest_before_ = largest;
  return std::erase_if(body_.pins(), [&](const Pin& pin) {
           return pin.pressure < -least && ++changes_of(pin) <= most_changes;
         }) > 0;
}

bool Settling::has_no_wall(const Pin& pin) const {
  return !pin.is_asked && !pin.stays && !pin.self && !body_.cells().is_blocked(map_, wall_of(body_, pin));
}

bool Settling::has_walls_that_are_gone() const {
  return std::ranges::any_of(body_.pins(), [this](const Pin& pin) { return has_no_wall(pin); });
}

/// A node that slides off an edge, and would come back to it, would do so for ever.
bool Settling::forget_walls_that_are_gone() {
  for (Pin& pin : body_.pins())
    pin.stays = has_no_wall(pin) ? ++changes_of(pin) > most_changes : pin.stays;
  return std::erase_if(body_.pins(), [this](const Pin& pin) { return has_no_wall(pin); }) > 0;
}

/// Goes as far as to the first contact, and pins what has met something. @return the part that it went
double Settling::meet(const std::vector<Hit>& hits, const Displacement& to) {
  double part = 1;
  for (const Hit& hit : hits)
    part = std::min(part, hit.speed > 0 ? hit.time - tolerance / hit.speed : 0.0);
  part = body_.go_towards(map_, to, std::max(0.0, part));
  // Once faces have asked for too much it is node by node: back and forth between the two would have no end.
  touches_only_ = touches_only_ || !body_.knows_forces() || !pin_at_faces(hits);
  if (touches_only_)
    pin_touching(hits, part);
  return part;
}

/// Goes as far as to where the body first meets itself, and pins both parts there, but for nodes that go away
/// from the other part. @return the part that it went
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

/// Pins a node where it is or at the face that it met; for a point of the surface the nodes about it, each as
/// far from where it is as the point is to go. Where several points ask the same node, the one counts that
/// keeps it furthest back.
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

/// @return false, and nothing is pinned, where limits do not let all of them be there, or where faces are not
///         along the object's axes
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
