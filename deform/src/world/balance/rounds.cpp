/// Rounds of a balance: how far everything moves towards the solution of the contact program.
///
/// The full step would be right if gaps and normals did not change on the way. They do. Where the same
/// contacts press from round to round they change smoothly, and mix() finds the fixed point. A node on the
/// edge between two faces sees one normal or the other, and full steps alternate: there a round takes a part
/// `length_` of the step, which shrinks where steps point against each other (onwards()) and grows elsewhere;
/// after `long_patience` rounds it only shrinks, as in subgradient methods. Forces are averaged with the same
/// part, so an edge gets shares of the forces of both normals.
///
/// Free objects have no stiffness of their own. A drag (kept_by times drag_) holds them at the start of a
/// round; it rises if the step is too long, and let_rest() ends drifts of zero energy. left() extrapolates
/// the last rounds as a geometric series.
///
/// All thresholds are heuristic; they decide the number of rounds. At rest the forces balance without the
/// drag.

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

/// Factors on the step length [1]: when rounds alternate, when they do not, and after `long_patience` rounds
/// in any case. The first `patience` rounds take full steps. Between several edges the length has to go to
/// zero, as in all subgradient methods; too fast, and rounds end before the balance.
constexpr double shorter = 0.6, longer = 1.1, always_shorter = 0.85;
constexpr int patience = 8, long_patience = 30;
/// While a round would move free objects further than `too_far` times its largest motion, their drag rises
/// by `drag_step` [1]: an unstable state is left in small steps; large ones would amplify rounding.
constexpr double too_far = 2, drag_step = 10;
/// Largest number of rounds that are mixed.
constexpr std::size_t most_mixed = 6;
/// Mixing stops if the last of its rounds still asks for more than this share of the first one's motion. It
/// starts anew if a round asks for more than the inverse of it times the motion of the round before.
constexpr double stalled = 0.5;
/// Ratio of the motions of two rounds [1], which says what a frame that is cut short still misses: where
/// there were too few to tell, and at most.
constexpr double unknown_ratio = 0.2, most_ratio = 0.97;
/// Drag on a free object, in units of its contacts' forces over a cell. More takes more rounds; less lets it
/// leap off faces that lean.
constexpr double drag_of_forces = 1e-3;

} // namespace

/// Product of the last step and the present one: below 0 where rounds alternate, as they do for a node on the
/// edge between two faces of a skin, each with a normal of its own.
double Balance::onwards(const std::vector<Response>& responses) {
  double sum = 0;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    SurfaceObject& one = objects_[i];
    if (one.is_body())
      sum += one.soft->onwards(responses[i].displacement);
    if (one.rigid.moves())
      sum += static_cast<double>(one.at.size()) * one.rigid.onwards(responses[i].motion);
  }
  return sum;
}

/// The state is a mean of what rounds have asked for, and so are the forces that it is in balance with.
void Balance::share_forces(double part) {
  for (Touch& touch : pressing_) {
    touch.force *= 1 - part;
    touch.rubbing *= 1 - part;
  }
  const std::size_t n_before = pressing_.size();
  std::size_t known = 0;
  std::vector<Touch> added;
  for (const Touch& touch : touches_) { // both in the same order
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
      one.soft->flexibility().forget_unused();
  length_ = drag_ = 1;
  rounds_ = 0;
  asked_ = {};
  past_.clear();
  has_looked_ = has_stalled_ = false;
}

/// Finds by what free objects are kept where a round begins: by ever so little, but by a part of the forces
/// of their contacts, of which faces that lean leave something.
void Balance::keep_free() {
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

/// Steady drift under negligible force is a zero-energy motion: hold the object where it is.
void Balance::let_rest(std::vector<Response>& responses) {
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

/// If contacts stay, a round is a smooth and nearly linear map of the state. The weighted mean of the last
/// rounds whose motions cancel is near its fixed point.
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
  for (std::size_t i = 0; i < objects_.size(); ++i) // from where rounds began
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

double Balance::catch_up() {
  double furthest = 0;
  for (SurfaceObject& one : objects_)
    if (const double way = one.soft && is_local() ? one.soft->catch_up() : 0; way > 0) {
      furthest = std::max(furthest, way);
      one.place();
    }
  if (furthest > negligible * cell_)
    has_looked_ = false;
  return furthest;
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

/// The rest of a geometric series.
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
  } else if (gone_ > step_over_cell * cell_) {
    catch_up();
    has_looked_ = false;
  }
  measure_touches();
  keep_free();
  std::vector<Response> responses = this->responses();
  let_rest(responses);
  double furthest = this->furthest(responses);
  const bool has_free =
      std::ranges::any_of(objects_, [](const SurfaceObject& one) { return one.rigid.is_free(); });
  for (; has_free && furthest > too_far * round_over_cell * cell_ && drag_ < 1 / negligible;
       furthest = this->furthest(responses)) {
    drag_ *= drag_step;
    responses = this->responses();
  }
  if (world_.scene.friction > 0) // what has come to press holds from here on
    for (const Touch& touch : touches_)
      if (touch.force > 0)
        grips_.try_emplace(key_of(touch), grip_at(touch));
  const bool goes_back = onwards(responses) < 0;
  const std::optional<double> missed = mix(responses, furthest);
  const bool jumps = !goes_back && furthest > round_over_cell * cell_; // out of a state that could not last
  if (!jumps && ++rounds_ > long_patience && length_ < 1)
    length_ *= goes_back ? shorter : always_shorter;
  else if (rounds_ > patience)
    length_ = goes_back ? shorter * length_ : std::min(1.0, longer * length_);
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
  gone_ += part * furthest;
  behind_ *= 1 - part;
  if (behind_ < tolerance * cell_)
    behind_ = 0;
  const double went = part * furthest * drag_; // with no drag but the least it would go so far
  if (furthest < round_over_cell * cell_)
    drag_ = std::max(1.0, drag_ / drag_step);
  return went;
}

} // namespace maille::deform
