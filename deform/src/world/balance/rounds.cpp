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
/// A free object is in balance if the resultant of its forces and moments is at most `in_balance` of the sum
/// of their sizes, and it would move by less than a step, and as in the round before within `steady` [1].
/// More ends rounds too early; less lets an object drift.
constexpr double in_balance = 1e-5, steady = 0.1;

/// From where the nodes are that rounds move to where they would be.
Eigen::VectorXd way_of(const BalancedObject& one, const Eigen::VectorXd& displacement) {
  const int d = one.dimension;
  Eigen::VectorXd way = displacement;
  for (std::size_t k = 0; k < one.moved.size(); ++k)
    way.segment(d * static_cast<Eigen::Index>(k), d) -=
        one.displacement.segment(std::int64_t{d} * one.moved[k], d);
  return way;
}

} // namespace

/// Product of the last step and the present one: below 0 where rounds alternate, as they do for a node on the
/// edge between two faces of a skin, each with a normal of its own.
double Balance::onwards(const std::vector<Answered>& answers) {
  double sum = 0;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    BalancedObject& one = objects_[i];
    const Answered& answered = answers[i];
    if (one.is_body()) {
      Eigen::VectorXd way = way_of(one, answered.displacement);
      if (one.way.size() == way.size())
        sum += one.way.dot(way);
      one.way = std::move(way);
    }
    if (one.moves) {
      Eigen::Matrix<double, 6, 1> way;
      way << answered.shift, one.radius * answered.turn;
      sum += static_cast<double>(one.at.size()) * one.way_as_a_whole.dot(way);
      one.way_as_a_whole = way;
    }
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
  for (BalancedObject& one : objects_)
    if (one.flexibility)
      one.flexibility->forget_unused();
  length_ = drag_ = 1;
  rounds_ = 0;
  asked_ = {};
  past_.clear();
  has_stalled_ = false;
}

/// Finds by what free objects are kept where a round begins: by ever so little, but by a part of the forces
/// of their contacts, of which faces that lean leave something.
void Balance::keep_free() {
  for (BalancedObject& one : objects_)
    one.felt = 0;
  for (const Touch& touch : touches_) {
    const double force = touch.force + touch.rubbing.norm();
    object(touch.object).felt += force;
    if (touch.other >= 0)
      object(touch.other).felt += force;
  }
  for (BalancedObject& one : objects_)
    one.kept_by = std::max(one.stiffness, drag_of_forces * one.felt / cell_);
}

/// Steady drift under negligible force is a zero-energy motion: hold the object where it is.
void Balance::let_rest(std::vector<Answered>& answers) {
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    BalancedObject& one = objects_[i];
    if (!one.is_free())
      continue;
    Eigen::Matrix<double, 6, 1> way;
    way << answers[i].shift, one.radius * answers[i].turn;
    const double steadily = (way - std::exchange(one.asked_as_a_whole, way)).norm();
    if (rounds_ > 1 && steadily < steady * way.norm() && way.norm() < round_over_cell * cell_ &&
        one.kept_by * drag_ * way.norm() < in_balance * one.felt)
      answers[i].shift = answers[i].turn = Eigen::Vector3d::Zero();
  }
}

double Balance::furthest(const std::vector<Answered>& answers) const {
  double furthest = 0;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const BalancedObject& one = objects_[i];
    double way = answers[i].shift.norm() + answers[i].turn.norm() * one.radius;
    if (one.is_body())
      if (const Eigen::VectorXd own = way_of(one, answers[i].displacement); own.size() > 0)
        way += own.cwiseAbs().maxCoeff() * std::sqrt(one.dimension);
    furthest = std::max(furthest, way);
  }
  return furthest;
}

/// Moves a body's nodes, and the forces of its contacts, by a part of what a round asks for.
void Balance::go(BalancedObject& one, const Answered& answered, double part) {
  const int d = one.dimension;
  for (std::size_t k = 0; k < one.moved.size(); ++k) {
    auto u = one.displacement.segment(std::int64_t{d} * one.moved[k], d);
    u += part * (answered.displacement.segment(d * static_cast<Eigen::Index>(k), d) - u);
  }
  for (const std::int64_t component : one.forced)
    one.contact_forces[component] *= 1 - part;
  double largest = 0;
  std::vector<std::int64_t> components, both;
  for (const auto& [component, force] : answered.forces) {
    one.contact_forces[component] += part * force;
    components.push_back(component);
    largest = std::max(largest, std::abs(force));
  }
  std::ranges::set_union(one.forced, components, std::back_inserter(both));
  one.forced = std::move(both);
  std::erase_if(one.forced, [&](std::int64_t component) {
    const bool is_none = std::abs(one.contact_forces[component]) <= rounding * largest;
    if (is_none)
      one.contact_forces[component] = 0;
    return is_none;
  });
}

/// If contacts stay, a round is a smooth and nearly linear map of the state. The weighted mean of the last
/// rounds whose motions cancel is near its fixed point.
/// Source  Anderson 1965 (J. ACM 12)
std::optional<double> Balance::mix(std::vector<Answered>& answers, double furthest) {
  std::vector<Key> keys;
  for (const Touch& touch : touches_)
    if (touch.force > 0)
      keys.push_back(key_of(touch));
  std::vector<double> all;
  for (const BalancedObject& one : objects_) {
    if (one.is_body())
      all.insert(all.end(), one.way.begin(), one.way.end());
    if (one.moves)
      for (const double x : one.way_as_a_whole)
        all.push_back(std::sqrt(static_cast<double>(one.at.size())) * x);
  }
  const Eigen::VectorXd way = Eigen::VectorXd::Map(all.data(), std::ssize(all));
  const auto size_of = [](const Answered& answer) { return answer.displacement.size(); };
  const bool is_as_before = !past_.empty() && keys == pressed_ && past_.back().first.size() == way.size() &&
                            std::ranges::equal(past_.back().second, answers, {}, size_of, size_of);
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
  past_.emplace_back(way, answers);
  for (std::size_t i = 0; i < objects_.size(); ++i) { // from where rounds began
    past_.back().second[i].shift += objects_[i].came.head<3>();
    past_.back().second[i].turn += objects_[i].came.tail<3>();
  }
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
  std::vector<Answered> mixed(answers.size());
  for (std::size_t i = 0; i < mixed.size(); ++i) {
    Answered& sum = mixed[i];
    std::map<std::int64_t, double> forces;
    sum.displacement = Eigen::VectorXd::Zero(answers[i].displacement.size());
    sum.shift = -objects_[i].came.head<3>();
    sum.turn = -objects_[i].came.tail<3>();
    for (Eigen::Index k = 0; const auto& [then, asked] : past_) {
      const double part = share[k++];
      sum.displacement += part * asked[i].displacement;
      sum.shift += part * asked[i].shift;
      sum.turn += part * asked[i].turn;
      for (const auto& [component, force] : asked[i].forces)
        forces[component] += part * force;
    }
    sum.forces.assign(forces.begin(), forces.end());
  }
  if (this->furthest(mixed) > round_over_cell * cell_)
    return std::nullopt;
  answers = std::move(mixed);
  return furthest * (way - change * less).norm() / way.norm();
}

void Balance::catch_up() {
  has_looked_ = false;
  if (!is_local())
    return;
  for (BalancedObject& one : objects_) {
    if (!one.is_body() || one.moved.size() == one.place_of.size())
      continue;
    one.move_all();
    one.displacement = one.unloaded + one.flexibility->moved_by(one.contact_forces, one.forced);
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
    forces[static_cast<std::size_t>(touch.object)] += force;
    if (touch.other >= 0)
      forces[static_cast<std::size_t>(touch.other)] -= force;
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
    for (BalancedObject& one : objects_)
      if (one.is_body())
        one.move_all();
    has_looked_ = false;
  } else if (gone_ > step_over_cell * cell_) {
    catch_up();
  }
  measure_touches();
  keep_free();
  std::vector<Answered> answers = this->answers();
  let_rest(answers);
  double furthest = this->furthest(answers);
  const bool has_free = std::ranges::any_of(objects_, &BalancedObject::is_free);
  for (; has_free && furthest > too_far * round_over_cell * cell_ && drag_ < 1 / negligible;
       furthest = this->furthest(answers)) {
    drag_ *= drag_step;
    answers = this->answers();
  }
  if (world_.scene.friction > 0) // what has come to press holds from here on
    for (const Touch& touch : touches_)
      if (touch.force > 0)
        grips_.try_emplace(key_of(touch), grip_at(touch));
  const bool goes_back = onwards(answers) < 0;
  const std::optional<double> missed = mix(answers, furthest);
  const bool jumps = !goes_back && furthest > round_over_cell * cell_; // out of a state that could not last
  if (!jumps && ++rounds_ > long_patience && length_ < 1)
    length_ *= goes_back ? shorter : always_shorter;
  else if (rounds_ > patience)
    length_ = goes_back ? shorter * length_ : std::min(1.0, longer * length_);
  const double part = missed ? 1 : std::min(length_, round_over_cell * cell_ / std::max(furthest, 1e-300));
  remember(missed.value_or(furthest), missed ? 1 : 1 - part);
  share_forces(part);
  for (int i = 0; i < world_.n_objects(); ++i) {
    BalancedObject& one = object(i);
    const Answered& answered = answers[static_cast<std::size_t>(i)];
    if (one.is_body())
      go(one, answered, part);
    if (one.moves) {
      one.turn_and_shift(part * answered.shift, part * answered.turn);
      one.came.head<3>() += part * answered.shift;
      one.came.tail<3>() += part * answered.turn;
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
