#include "world/settling.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace maille::deform {

namespace {

/// A node is let go of so often; then it stays where it is, so that no round follows another for ever.
constexpr int most_changes = 3;
/// Answers until an object has settled: far more than were ever seen.
constexpr int most_turns = 500;
/// Of the largest force: less than this is no pull, but the error of the method's algebra.
constexpr double least_pull = 1e-4;
/// What stops this near before the first contact touches too [cells].
constexpr double near = 1e-6;

} // namespace

bool FrameClock::may_go_on() {
  if (ended)
    return false;
  if (control.should_stop())
    ended = Status::interrupted;
  else if (rounds_left && *rounds_left <= 0)
    ended = Status::budget_reached;
  else if (const auto left = seconds_left ? seconds_left() : std::nullopt; left && *left <= 0)
    ended = Status::budget_reached;
  else
    control.seconds_budget = left;
  return !ended;
}

bool Settling::run() {
  begin();
  for (int turns = 0; clock_.may_go_on(); ++turns) {
    const Turn outcome = turns < most_turns ? turn() : Turn::given_up;
    if (outcome == Turn::again)
      continue;
    if (turns == most_turns)
      message_ = "contacts came and went without end";
    return outcome == Turn::settled;
  }
  return false;
}

void Settling::begin() {
  changes_.assign(static_cast<std::size_t>(3 * body_.lattice().n_voxels()), 0);
  if (!body_.knows_forces()) // whoever wants in again will be met again
    std::erase_if(body_.pins(), [](const Pin& pin) { return !pin.is_asked; });
  else
    forget_walls_that_are_gone();
  keep_what_limits_admit();
}

/// What is pinned to places that it has not come to may contradict what is pinned since.
void Settling::keep_what_limits_admit() {
  if (!body_.limits_bind() || !body_.knows_forces())
    return;
  std::vector<Pin> asked;
  std::ranges::copy_if(body_.pins(), std::back_inserter(asked), &Pin::is_asked);
  body_.keep_reached_pins();
  for (const Pin& pin : asked)
    body_.add_pin(pin);
}

Settling::Turn Settling::turn() {
  ++clock_.rounds;
  if (clock_.rounds_left)
    --*clock_.rounds_left;
  const Answer answer = body_.answer(clock_.control);
  if (!has_displacement(answer.status)) {
    message_ = answer.message;
    return Turn::given_up;
  }
  const bool is_whole = is_settled(answer.status);
  if (!is_whole && (clock_.control.seconds_budget || clock_.control.stop_requested))
    clock_.ended = answer.status;
  else if (!is_whole)
    message_ = "its method ended before it had settled";
  if (is_whole && let_go_of_pulled())
    return Turn::again;
  const auto hits =
      find_hits(map_, body_.cells(), body_.lattice(), body_.displacement(), answer.displacement);
  if (!hits.empty()) {
    meet(hits, answer.displacement);
    return is_whole ? Turn::again : Turn::given_up;
  }
  body_.go_towards(map_, answer.displacement, 1);
  if (!is_whole)
    return Turn::given_up;
  return body_.knows_forces() && forget_walls_that_are_gone() ? Turn::again : Turn::settled;
}

bool Settling::let_go_of_pulled() {
  double largest = 0;
  for (const Pin& pin : body_.pins())
    largest = std::max(largest, std::abs(pin.pressure));
  return std::erase_if(body_.pins(), [&](const Pin& pin) {
           return pin.pressure < -least_pull * largest && ++changes_of(pin) <= most_changes;
         }) > 0;
}

bool Settling::has_no_wall(const Pin& pin) const {
  Index3 wall = body_.cells().cell(pin.voxel);
  wall[static_cast<std::size_t>(pin.axis)] += pin.direction;
  return !pin.is_asked && !body_.cells().is_blocked(map_, wall);
}

bool Settling::has_walls_that_are_gone() const {
  return std::ranges::any_of(body_.pins(), [this](const Pin& pin) { return has_no_wall(pin); });
}

bool Settling::forget_walls_that_are_gone() {
  return std::erase_if(body_.pins(), [this](const Pin& pin) { return has_no_wall(pin); }) > 0;
}

/// Goes as far as to the first contact, and pins what has met something.
void Settling::meet(const std::vector<Hit>& hits, const Displacement& to) {
  double part = 1;
  for (const Hit& hit : hits)
    part = std::min(part, hit.speed > 0 ? hit.time - node_skin / hit.speed : 0.0);
  part = body_.go_towards(map_, to, std::max(0.0, part));
  if (!body_.knows_forces() || !pin_at_faces(hits))
    pin_touching(hits, part);
}

Pin Settling::pin_of(const Hit& hit) const {
  return {.voxel = hit.voxel, .axis = hit.axis, .direction = hit.direction, .at = {}, .rest = hit.rest};
}

void Settling::pin_touching(const std::vector<Hit>& hits, double part) {
  keep_what_limits_admit();
  const double first = std::ranges::min(hits, {}, &Hit::time).time;
  for (const Hit& hit : hits) {
    if (hit.time > first && (hit.time - part) * hit.speed > near)
      continue;
    Pin pin = pin_of(hit);
    pin.at = displacement_of(body_.displacement(), body_.lattice().node(hit.voxel));
    body_.add_pin(pin);
  }
}

/// @return false, and nothing is pinned, where limits do not let all of them be there, or where faces are not along the object's axes
bool Settling::pin_at_faces(const std::vector<Hit>& hits) {
  if (body_.lattice().is_turned())
    return false;
  const std::vector<Pin> before = body_.pins();
  for (const Hit& hit : hits) {
    Pin pin = pin_of(hit);
    const double face = hit.wall[static_cast<std::size_t>(hit.axis)] + (hit.direction < 0 ? 1 : 0);
    pin.at = body_.lattice().moved_along(hit.voxel, body_.displacement(), hit.axis,
                                         face - hit.direction * node_skin);
    body_.add_pin(pin);
  }
  if (body_.can_be_met())
    return true;
  body_.pins() = before;
  return false;
}

} // namespace maille::deform
