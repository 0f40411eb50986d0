/// Rounds of a balance: the step of all objects towards the solution of the contact program.
///
/// The full step assumes that gaps and normals stay constant, which is not exact. While the same contacts are
/// active, they change smoothly from round to round, and mix() finds the fixed point. A node on the edge
/// between two faces sees the normal of one or the other, and full steps alternate. There a round takes a
/// part `length_` of the step: it shrinks if successive steps point against each other (dot_with_last_step())
/// and grows otherwise; after `long_patience` rounds it only shrinks, as in subgradient methods. Forces are
/// averaged with the same part, so that an edge receives shares of the forces of both normals.
///
/// Free objects have no stiffness. A drag (RigidPart::begin_round, times drag_) holds them at their pose at
/// the start of the round. It increases if the step is too long. stop_drifts() stops drifts of zero energy.
/// left() extrapolates the last rounds as a geometric series.
///
/// All thresholds are heuristic; they affect only the number of rounds. At rest the forces balance without
/// the drag.

#include "lattice/tolerances.hpp"
#include "world/balance/balance.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Factors on the step length [1]: while rounds alternate, while they do not, and after `long_patience`
/// rounds in any case. The first `patience` rounds take full steps. Between several edges the length must
/// decrease to zero, as in all subgradient methods; if it decreases too fast, rounds end before equilibrium.
constexpr double shorter = 0.6, longer = 1.1, always_shorter = 0.85;
constexpr int patience = 8, long_patience = 30;
/// While a round would move objects further than `too_far` times the largest motion of a round, the drag on
/// free objects increases by the factor `drag_step` [1]. The state then leaves an unstable equilibrium in
/// small steps; large steps would amplify rounding.
constexpr double too_far = 2, drag_step = 10;
/// Largest number of rounds that are mixed.
constexpr std::size_t most_mixed = 6;
/// Mixing stops if its last round still has more than this share of the first one's motion. It restarts if
/// the motion grows by more than the inverse of this factor in a round.
constexpr double stalled = 0.5;
/// Ratio of the motions of successive rounds [1], for the remaining motion of an interrupted frame: value
/// after too few rounds, and upper bound.
constexpr double unknown_ratio = 0.2, most_ratio = 0.97;
/// Drag on a free object, in units of its contact forces over a cell. More drag takes more rounds; with less,
/// objects jump off inclined faces.
constexpr double drag_of_forces = 1e-3;

} // namespace

/// Dot product of the last step and the present one: negative while rounds alternate, as for a node on the
/// edge between two faces with different normals.
double Balance::dot_with_last_step(const std::vector<Response>& responses) {
  double sum = 0;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    SurfaceObject& one = objects_[i];
    if (one.is_body())
      sum += one.soft->dot_with_last_step(responses[i].displacement);
    if (one.rigid.moves())
      sum += static_cast<double>(one.at.size()) * one.rigid.dot_with_last_step(responses[i].motion);
  }
  return sum;
}

/// Averages the contact forces with the weights that the displacements are averaged with.
void Balance::share_forces(double part) {
  for (Touch& touch : pressing_) {
    touch.force *= 1 - part;
    touch.rubbing *= 1 - part;
  }
  const std::size_t n_before = pressing_.size();
  std::size_t known = 0;
  std::vector<Touch> added;
  for (const Touch& touch : touches_) { // pressing_ has the same order
    if (touch.force == 0)
      continue;
    while (known < n_before && key_of(pressing_[known]) < key_of(touch))
      ++known;
    Touch share = touch;
    share.force *= part;
    share.rubbing *= part;
    bool is_known = false;
    for (std::size_t i = known; i < n_before && key_of(pressing_[i]) == key_of(touch) && !is_known; ++i) {
      Touch& old = pressing_[i];
      is_known = part < 1 && old.normal.dot(touch.normal) > 0;
      if (is_known) {
        const Eigen::Vector3d sum = old.force * old.normal + share.force * share.normal;
        share.rubbing += old.rubbing;
        share.force = sum.norm();
        share.normal = sum / share.force;
        old = share;
      }
    }
    if (!is_known)
      added.push_back(share);
  }
  pressing_.insert(pressing_.end(), added.begin(), added.end());
  std::ranges::stable_sort(pressing_, {}, key_of);
  double largest = 0;
  for (const Touch& touch : pressing_)
    largest = std::max(largest, std::abs(touch.force));
  std::erase_if(pressing_, [&](const Touch& touch) { return std::abs(touch.force) <= rounding * largest; });
}

void Balance::begin() {
  grip();
  for (SurfaceObject& one : objects_)
    if (one.soft)
      one.soft->forget_unused();
  length_ = drag_ = 1;
  rounds_ = 0;
  asked_ = {};
  past_.clear();
  has_stalled_ = false;
}

/// Sets the drag on free objects in proportion to their contact forces: on inclined faces a part of these is
/// unbalanced.
void Balance::set_drag() {
  std::vector<double> sums(objects_.size(), 0);
  for (const Touch& touch : touches_) {
    const double force = touch.force + touch.rubbing.norm();
    sums[touch.object] += force;
    if (touch.other >= 0)
      sums[touch.other] += force;
  }
  for (std::size_t i = 0; i < objects_.size(); ++i)
    objects_[i].rigid.begin_round(sums[i], drag_of_forces * sums[i] / cell_);
}

/// A steady drift under negligible force is a zero-energy motion: holds the object at its pose.
void Balance::stop_drifts(std::vector<Response>& responses) {
  for (std::size_t i = 0; i < objects_.size(); ++i)
    if (objects_[i].rigid.only_drifts(responses[i].motion, drag_, round_over_cell * cell_, rounds_ > 1))
      responses[i].motion.setZero();
}

double Balance::furthest(const std::vector<Response>& responses) const {
  double furthest = 0;
  for (std::size_t i = 0; i < objects_.size(); ++i)
    furthest = std::max(furthest, objects_[i].furthest(responses[i]));
  return furthest;
}

/// With constant contacts, a round is a smooth, nearly linear map of the state. Its fixed point is near the
/// weighted mean of the last rounds whose motions cancel.
/// Source  Anderson 1965 (J. ACM 12)
std::optional<double> Balance::mix(std::vector<Response>& responses, double furthest) {
  std::vector<Key> keys;
  for (const Touch& touch : touches_)
    if (touch.force > 0)
      keys.push_back(key_of(touch));
  std::vector<double> all;
  for (const SurfaceObject& one : objects_) {
    if (one.is_body())
      all.insert(all.end(), one.soft->way().begin(), one.soft->way().end());
    if (one.rigid.moves())
      for (const double x : one.rigid.way())
        all.push_back(std::sqrt(static_cast<double>(one.at.size())) * x);
  }
  const Eigen::VectorXd way = Eigen::VectorXd::Map(all.data(), std::ssize(all));
  const auto size_of = [](const Response& response) { return response.displacement.size(); };
  const bool is_as_before = !past_.empty() && keys == pressed_ && past_.back().first.size() == way.size() &&
                            std::ranges::equal(past_.back().second, responses, {}, size_of, size_of);
  has_stalled_ =
      is_as_before &&
      (has_stalled_ || (past_.size() == most_mixed && way.norm() > stalled * past_.front().first.norm()));
  pressed_ = std::move(keys);
  if (!is_as_before || has_stalled_ || way.norm() > past_.back().first.norm() / stalled)
    past_.clear();
  if (!is_local() || furthest > round_over_cell * cell_)
    return std::nullopt;
  if (past_.size() == most_mixed)
    past_.erase(past_.begin());
  past_.emplace_back(way, responses);
  for (std::size_t i = 0; i < objects_.size(); ++i) // relative to the first round
    past_.back().second[i].motion += objects_[i].rigid.path();
  const Eigen::Index m = std::ssize(past_) - 1;
  if (m == 0 || has_stalled_)
    return std::nullopt;
  Eigen::MatrixXd change(way.size(), m);
  for (Eigen::Index k = 0; const auto& [then, asked] : past_)
    if (k < m)
      change.col(k++) = way - then;
  const Eigen::VectorXd less = change.colPivHouseholderQr().solve(way);
  Eigen::VectorXd share(m + 1);
  share << less, 1 - less.sum();
  std::vector<Response> mixed(responses.size());
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    Response& sum = mixed[i];
    std::map<std::int64_t, double> forces;
    sum.displacement = Eigen::VectorXd::Zero(responses[i].displacement.size());
    sum.motion = -objects_[i].rigid.path();
    for (Eigen::Index k = 0; const auto& [then, asked] : past_) {
      const double part = share[k++];
      sum.displacement += part * asked[i].displacement;
      sum.motion += part * asked[i].motion;
      for (const auto& [component, force] : asked[i].forces)
        forces[component] += part * force;
    }
    sum.forces.assign(forces.begin(), forces.end());
  }
  if (this->furthest(mixed) > round_over_cell * cell_)
    return std::nullopt;
  responses = std::move(mixed);
  return furthest * (way - change * less).norm() / way.norm();
}

void Balance::catch_up() {
  has_looked_ = false;
  if (!is_local())
    return;
  for (SurfaceObject& one : objects_) {
    if (one.soft && one.soft->catch_up())
      one.place();
  }
}

void Balance::remember(double furthest, double not_done) {
  std::ranges::rotate(asked_, asked_.end() - 1);
  asked_.front() = furthest;
  not_done_ = not_done;
  std::vector<Eigen::Vector3d> forces(objects_.size(), Eigen::Vector3d::Zero());
  for (const Touch& touch : touches_) {
    const Eigen::Vector3d force = touch.force * touch.normal + touch.rubbing;
    forces[touch.object] += force;
    if (touch.other >= 0)
      forces[touch.other] -= force;
  }
  force_change_ = 0;
  for (std::size_t i = 0; i < forces_.size(); ++i)
    force_change_ = std::max(force_change_, (forces[i] - forces_[i]).norm());
  forces_ = std::move(forces);
}

/// Remainder of a geometric series.
Balance::Left Balance::left() const {
  double ratio = unknown_ratio;
  if (asked_.back() > 0)
    ratio = std::min(most_ratio, std::cbrt(asked_.front() / asked_.back()));
  const double rest = ratio / (1 - ratio);
  return {asked_.front() * (rest + not_done_), force_change_ * rest};
}

double Balance::round() {
  if (!is_local()) {
    for (SurfaceObject& one : objects_)
      if (one.is_body())
        one.soft->watch_all();
    has_looked_ = false;
  } else if (motion_since_search_ > step_over_cell * cell_) {
    catch_up();
  }
  measure_touches();
  set_drag();
  std::vector<Response> responses = this->responses();
  stop_drifts(responses);
  double furthest = this->furthest(responses);
  const bool has_free =
      std::ranges::any_of(objects_, [](const SurfaceObject& one) { return one.rigid.is_free(); });
  for (; has_free && furthest > too_far * round_over_cell * cell_ && drag_ < 1 / negligible;
       furthest = this->furthest(responses)) {
    drag_ *= drag_step;
    responses = this->responses();
  }
  if (world_.scene.friction > 0) // new active contacts stick at their present places
    for (const Touch& touch : touches_)
      if (touch.force > 0)
        grips_.try_emplace(key_of(touch), grip_at(touch));
  const bool alternates = dot_with_last_step(responses) < 0;
  const std::optional<double> missed = mix(responses, furthest);
  const bool jumps = !alternates && furthest > round_over_cell * cell_; // leaves an unstable state
  if (!jumps && ++rounds_ > long_patience && length_ < 1)
    length_ *= alternates ? shorter : always_shorter;
  else if (rounds_ > patience)
    length_ = alternates ? shorter * length_ : std::min(1.0, longer * length_);
  const double part = missed ? 1 : std::min(length_, round_over_cell * cell_ / std::max(furthest, 1e-300));
  remember(missed.value_or(furthest), missed ? 1 : 1 - part);
  share_forces(part);
  for (int i = 0; i < world_.n_objects(); ++i) {
    SurfaceObject& one = object(i);
    const Response& response = responses[i];
    if (one.is_body())
      one.soft->go(response, part);
    if (one.rigid.moves()) {
      one.turn_and_shift(part * response.motion);
      one.rigid.add_to_path(part * response.motion);
    }
    if (one.is_body() && is_local())
      one.place_watched();
    else if (one.kind != ObjectKind::fixed)
      one.place();
  }
  motion_since_search_ += part * furthest;
  distance_to_unloaded_ *= 1 - part;
  if (distance_to_unloaded_ < tolerance * cell_)
    distance_to_unloaded_ = 0;
  const double went = part * furthest * drag_; // motion that the smallest drag would allow
  if (furthest < round_over_cell * cell_)
    drag_ = std::max(1.0, drag_ / drag_step);
  return went;
}

} // namespace maille::deform
