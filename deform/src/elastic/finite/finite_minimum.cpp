#include "elastic/finite/finite_minimum.hpp"

#include "elastic/limits/active_links.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

namespace maille::deform {

namespace {

/// Largest rotation per increment. Measured: see docs/large_strain.md.
constexpr double turn_per_increment = std::numbers::pi / 2;
/// Give up after this many failed increments, each of which halves the next.
constexpr int most_failures = 8;
/// Newton steps of an increment before it is halved (5 to 20 reach a minimum), and iterations of a step
/// before it is truncated.
constexpr int most_steps = 60, most_iterations = 500;
/// Tolerance of starts and of states between increments, in the energy norm.
constexpr double start_tolerance = 1e-2;
/// Reduction of the residual by predictions. Coarser ones strain cells beside handles so much that nearly
/// incompressible matter takes four times the iterations.
constexpr double predicted = 3e-4;
/// Error [1] or mean rotation of cells [rad] up to which a change is nearly linear: exact tangents are tried,
/// and predictions use unrotated frames.
constexpr double small_change = 0.2;
/// Rebuild the preconditioner from the present state after a solve of more iterations than this.
constexpr int worth_refreshing = 20;
constexpr double armijo = 1e-4;
/// Strains whose energy is rounding.
const double rounding_strain = 64 * std::numeric_limits<double>::epsilon();

/// Nodal forces of all loads except contraction, which rotates with its cells; no components without loads.
Displacement passive_loads_of(Scene scene) {
  scene.active_stress.clear();
  if (!scene.has_loads())
    return {};
  Displacement loads(scene.specimen.grid);
  for (int b = 0; b < scene.dimension(); ++b)
    std::ranges::copy(nodal_forces(scene, b), loads.component(b).begin());
  return loads;
}

/// Approximate energy of the body with all cells at unit strain.
double energy_of_unit_strain(const Scene& scene, const LatticeElasticity& linear) {
  double sum = 0;
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      sum += linear.weight(cell) * linear.kinds()[linear.kind_number(cell)].largest_mean();
  return sum;
}

/// Skips the search for the scale of taut limits, which is not needed here.
Scene without_search(Scene scene) {
  scene.limits.taut_scale = 0;
  return scene;
}

} // namespace

FiniteMinimum::FiniteMinimum(const CoupledTask& task, FiniteCourse& course)
    : task_(task), scene_(without_search(task.scene)), linear_(scene_), elasticity_(scene_, linear_),
      course_(course), preconditioner_(course.preconditioner), sums_(scene_.specimen.grid, task.team),
      gradients_(static_cast<std::size_t>(scene_.dimension()), FixedMask(scene_.specimen, scene_.prescribed),
                 sums_) {
  state_.u = state_.gradient = Displacement(scene_.specimen.grid);
  floor_ = rounding_strain * rounding_strain * energy_of_unit_strain(scene_, linear_);
}

int FiniteMinimum::planned_increments() const {
  if (scene_.relaxation.increments > 0)
    return scene_.relaxation.increments;
  double angle = 0;
  for (const Turn& turn : scene_.turns)
    angle = std::max(angle, std::abs(turn.angle));
  for (const Drive& drive : scene_.drives)
    angle = std::max(angle, drive.turned());
  return std::max(1, static_cast<int>(std::ceil(angle / turn_per_increment - 1e-9)));
}

void FiniteMinimum::mask(Displacement& field) const {
  for (const Prescribed& p : scene_.prescribed)
    field(p.component, p.node) = 0;
}

void FiniteMinimum::put_on_loads_of(const Scene& step) {
  followers_ = FollowerPressure(step);
  Scene dead = step;
  std::erase_if(dead.tractions, [](const FaceLoad& load) { return load.follows; });
  dead_loads_ = passive_loads_of(followers_.is_empty() ? step : std::move(dead));
  loads_ = dead_loads_;
  turn_loads();
  elasticity_.set_active_stress(step.active_stress);
}

/// Recomputes following pressures on the present faces. @return false if no load follows
bool FiniteMinimum::turn_loads() {
  if (followers_.is_empty())
    return false;
  loads_ = dead_loads_.empty() ? Displacement(scene_.specimen.grid) : dead_loads_;
  followers_.add_forces(state_.u, loads_);
  return true;
}

void FiniteMinimum::evaluate(State& state) {
  state.energy = elasticity_.evaluate(state.u, state.gradient, task_.team);
  state.elastic = state.energy - elasticity_.active_energy();
  if (std::isinf(state.energy))
    return;
  if (limits_) {
    elasticity_.turn_frames(state.u, task_.team);
    state.energy += limits_->evaluate(state.u, elasticity_, state.gradient);
  }
  state.energy += energy_of_springs(linear_.springs(), state.u);
  elasticity_.add_springs(state.u, state.gradient);
  if (!loads_.empty()) {
    state.energy -= sums_.dot(loads_, state.u);
    sums_.add(-1, loads_, 1, state.gradient);
  }
}

/// Carries the body with the object's frame from one increment to the next.
void FiniteMinimum::carry(const Scene& from, const Scene& to) {
  const Frame before = object_frame(from), after = object_frame(to);
  to_object(from, before, state_.u);
  to_world(to, after, state_.u);
}

/// d += a correction that brings the residual to `reduction` of its norm, or to `enough` squared [J].
/// @return false if stopped
bool FiniteMinimum::solve_for(ElasticOperator& K, const Displacement& residual, double reduction,
                              Displacement& d, Answer& answer, double enough) {
  gradients_.residual() = residual;
  mask(gradients_.residual());
  gradients_.begin(K, d);
  ReductionWatch reduced(limits_ ? most_coupled_iterations : most_iterations, reduction, task_.must_stop,
                         floor_, enough);
  has_negative_curvature_ = conjugate_gradients(gradients_, reduced) == GradientsEnd::no_curvature;
  first_product_ = reduced.first();
  // The preconditioner is not positive; the next solve rebuilds it.
  has_failed_ = reduced.iterations() == 0 && !(first_product_ >= -floor_);
  solve_iterations_ = has_failed_ ? most_iterations : reduced.iterations();
  answer.iterations += reduced.iterations();
  return !task_.must_stop();
}

/// @param may_refresh true for accepted states; trial states may be strained without bound
void FiniteMinimum::linearise(Convexity convexity, bool may_refresh) {
  elasticity_.linearise(state_.u, convexity, task_.team);
  preconditioner_.turn_with(elasticity_);
  if (may_refresh && !limits_ && solve_iterations_ > worth_refreshing &&
      preconditioner_.refresh(elasticity_)) {
    preconditioner_.turn_with(elasticity_);
    course_.response = Displacement(); // its norm belongs to the old preconditioner
  }
}

/// Predicts the start of this increment from the state of the last one, with handles in place.
FiniteMinimum::End FiniteMinimum::predict(const Scene& to, Answer& answer) {
  evaluate(state_);
  Displacement d(scene_.specimen.grid), residual(d);
  if (n_increments_ == 0 && largest_entry(state_.u) == 0) {
    elasticity_.turn_frames(state_.u, task_.team);
    elasticity_.linearise_in_frames(residual, task_.team);
    preconditioner_.turn_with(elasticity_);
  } else
    linearise(Convexity::positive, true);
  for (const Prescribed& p : to.prescribed)
    d(p.component, p.node) = p.value - state_.u(p.component, p.node);
  TangentOperator tangent(elasticity_, nullptr, preconditioner_, task_.team);
  tangent.apply(d, residual);
  sums_.add(-1, state_.gradient, -1, residual);
  if (!solve_for(tangent, residual, predicted, d, answer))
    return End::stopped;
  if (has_failed_)
    return End::failed;
  elasticity_.step_pressures(d, 1, task_.team);
  sums_.add(1, d, 1, state_.u);
  for (const Prescribed& p : to.prescribed)
    state_.u(p.component, p.node) = p.value;
  evaluate(state_);
  if (elasticity_.warp_frames(d) > small_change) {
    State warped = state_;
    elasticity_.linearise_in_frames(residual, task_.team);
    preconditioner_.turn_with(elasticity_);
    tangent.apply(warped.u, warped.gradient);
    sums_.add(-1, warped.gradient, -1, residual);
    if (!loads_.empty())
      sums_.add(1, loads_, 1, residual);
    if (!solve_for(tangent, residual, predicted, warped.u, answer))
      return End::stopped;
    evaluate(warped);
    if (warped.energy < state_.energy) {
      elasticity_.step_pressures(warped.u, 1, task_.team);
      std::swap(state_, warped);
    }
    evaluate(state_); // inverted cells and energies are those of the state
  }
  return std::isinf(state_.energy) ? End::failed : End::settled;
}

FiniteMinimum::End FiniteMinimum::go_to(double fraction, Answer& answer) {
  const Scene from = scaled(scene_, fraction_), to = scaled(scene_, fraction);
  const Displacement before = state_.u;
  put_on_loads_of(to);
  is_unstable_ = false;
  carry(from, to);
  End end = predict(to, answer);
  const double reached = fraction_;
  if (end == End::settled) {
    fraction_ = fraction;
    end = descend(fraction < 1 ? start_tolerance : scene_.relaxation.tolerance, answer);
    if (end != End::failed)
      return end;
  }
  fraction_ = reached;
  state_.u = before;
  put_on_loads_of(from);
  evaluate(state_);
  return end;
}

/// Backtracking line search. @return false if no step lowers the energy
bool FiniteMinimum::step_downhill(const Displacement& direction, double slope, State& next) {
  for (double length = 1; length > std::numeric_limits<float>::epsilon();) {
    next.u = state_.u;
    sums_.add(length, direction, 1, next.u);
    evaluate(next);
    const double rise = next.energy - state_.energy;
    if (rise <= armijo * length * slope)
      return true;
    const double best = -slope * length * length / (2 * (rise - slope * length)); // of a parabola
    length = std::isfinite(best) ? std::clamp(best, 0.1 * length, 0.5 * length) : 0.1 * length;
  }
  return false;
}

/// Estimated error, relative to the absolute energy, which is negative where a muscle law is active.
/// @param slope of the energy along the direction to the estimated minimum
double FiniteMinimum::estimated_error(double slope) const {
  const double product = std::max(0.0, -slope), energy = std::max(2 * std::abs(state_.elastic), floor_);
  return std::min(1.0, limits_ ? Nearness{product, limits_->gap()}.error(energy)
                               : 2 * std::sqrt(product / energy));
}

void FiniteMinimum::find_newton_direction(double goal, Displacement& direction, Answer& answer) {
  TangentOperator tangent(elasticity_, limits_ ? &*limits_ : nullptr, preconditioner_, task_.team);
  Displacement residual = state_.gradient;
  sums_.add(0, residual, -1, residual);
  std::ranges::fill(direction.values(), 0.0);
  const double enough = 0.5 * std::pow(0.1 * goal, 2) * std::abs(state_.elastic);
  solve_for(tangent, residual, start_tolerance, direction, answer, limits_ ? 0 : enough);
  mask(direction);
}

/// Longest step, at most the whole one, that inverts no cell, whatever it does to the energy.
bool FiniteMinimum::step_on_trial(const Displacement& direction, State& next) {
  for (double length = 1; length > start_tolerance; length /= 2) {
    next.u = state_.u;
    sums_.add(length, direction, 1, next.u);
    evaluate(next);
    if (std::isfinite(next.energy)) {
      elasticity_.step_pressures(direction, length, task_.team);
      return true;
    }
  }
  return false;
}

FiniteMinimum::End FiniteMinimum::descend(double goal, Answer& answer, Convexity convexity) {
  State next{state_.u, state_.gradient};
  Displacement direction(scene_.specimen.grid);
  State base; // the last accepted one, and the search direction there
  Displacement downhill;
  double steepness = 0;
  int on_trial = 0;           // steps since the base
  bool is_indefinite = false; // the last exact tangent
  bool keeps_tangent = false; // the state has hardly changed since
  bool has_moved = false;     // since multipliers were last improved; never without limits
  for (int i = 0; i < (limits_ ? most_coupled_iterations : most_steps); ++i) {
    if (watch && on_trial == 0)
      watch(fraction_, state_.energy);
    if (task_.must_stop()) {
      if (on_trial > 0)
        std::swap(state_, base);
      return End::stopped;
    }
    if (on_trial == 0 && turn_loads())
      evaluate(state_);
    if (limits_ && limits_->are_penalties_out_of_date())
      penalized_->set_penalties(limits_->penalties());
    if (!keeps_tangent)
      linearise(convexity, on_trial == 0);
    const bool kept_tangent = std::exchange(keeps_tangent, false);
    find_newton_direction(goal, direction, answer);
    if (has_negative_curvature_ && convexity == Convexity::exact) {
      convexity = Convexity::positive;
      is_indefinite = true;
      continue;
    }
    if (has_failed_ && on_trial == 0)
      return limits_ ? End::stopped : End::failed;
    const double slope = sums_.dot(state_.gradient, direction); // fixed components are 0 in it
    answer.residual = estimated_error(slope);
    const double rounding = 16 * std::numeric_limits<double>::epsilon() *
                            (std::abs(state_.elastic) + std::abs(state_.elastic - state_.energy));
    const bool is_lowest = -slope <= std::max(floor_, rounding);
    if (on_trial == 0 && (answer.residual <= goal || (is_lowest && !limits_))) {
      if (convexity == Convexity::positive && !is_indefinite) {
        convexity = Convexity::exact;
        continue;
      }
      is_unstable_ = is_indefinite;
      return End::settled;
    }
    if (has_moved && (is_lowest || -slope <= limits_->gap())) {
      limits_->improve_multipliers();
      evaluate(state_);
      has_moved = false;
      continue;
    }
    if (on_trial == 0)
      base = state_, downhill = direction, steepness = slope;
    const bool is_finite = step_on_trial(direction, next);
    if (is_finite && next.energy <= base.energy + armijo * steepness) {
      keeps_tangent = convexity == Convexity::exact && !limits_ && on_trial == 0 && !kept_tangent &&
                      answer.residual <= 0.1 * start_tolerance;
      on_trial = 0;
    } else if (is_finite && next.energy <= base.energy - steepness / armijo && ++on_trial <= 2) {
      std::swap(state_, next);
      continue;
    } else {
      on_trial = 0;
      std::swap(state_, base);
      elasticity_.forget_pressures();
      if (!step_downhill(downhill, steepness, next)) {
        evaluate(state_);
        if (has_moved) { // improve multipliers once
          limits_->improve_multipliers();
          evaluate(state_);
          has_moved = false;
          continue;
        }
        if (limits_ || answer.residual > start_tolerance)
          return limits_ ? End::stopped : End::failed;
        linearise(Convexity::exact, true);
        return End::settled;
      }
    }
    has_moved = limits_.has_value();
    if (answer.residual <= small_change) {
      convexity = Convexity::exact;
      is_indefinite = false;
    }
    std::swap(state_, next);
  }
  return limits_ ? End::stopped : End::failed;
}

/// Conjugate gradients on the exact tangent, at which descents settle, with forces that excite every motion:
/// where some direction is not positive, they meet it. On a course they begin at the last answer's response.
void FiniteMinimum::look_for_instability(Answer& answer) {
  if (is_unstable_ || limits_)
    return;
  TangentOperator tangent(elasticity_, nullptr, preconditioner_, task_.team);
  Displacement push(scene_.specimen.grid), residual(push);
  std::uint32_t random = 1;
  for (double& value : push.values()) {
    random = random * 1664525U + 1013904223U;
    value = static_cast<double>(random >> 8) - (1 << 23);
  }
  if (course_.response.empty()) {
    course_.response = Displacement(scene_.specimen.grid);
    course_.push = 0;
  }
  tangent.apply(course_.response, residual);
  sums_.add(1, push, -1, residual);
  const bool is_first = course_.push == 0;
  solve_for(tangent, residual, is_first ? start_tolerance : 0, course_.response, answer,
            start_tolerance * start_tolerance * course_.push);
  if (is_first)
    course_.push = first_product_;
  is_unstable_ = has_negative_curvature_;
  if (is_unstable_)
    course_.response = Displacement();
}

/// Starts at the task's start in one step; at rest if that leads to no minimum.
FiniteMinimum::End FiniteMinimum::go_on(bool has_arrived, Answer& answer) {
  put_on_loads_of(scene_);
  state_.u = has_arrived ? task_.initial_state() : *task_.start;
  evaluate(state_);
  End end = std::isinf(state_.energy) ? End::failed : has_arrived ? End::settled : predict(scene_, answer);
  if (end == End::settled) {
    fraction_ = n_increments_ = 1;
    end = descend(scene_.relaxation.tolerance, answer, Convexity::exact);
  }
  if (end == End::failed || fraction_ == 0) {
    fraction_ = n_increments_ = 0;
    std::ranges::fill(state_.u.values(), 0.0);
    elasticity_.forget_pressures();
    evaluate(state_);
  }
  return end;
}

bool FiniteMinimum::solve(Answer& answer, std::optional<bool> has_arrived) {
  double increment = 1.0 / planned_increments();
  answer.residual = 1;
  End end = has_arrived ? go_on(*has_arrived, answer) : End::settled;
  for (int failures = 0; fraction_ < 1 && end != End::stopped; failures += end == End::failed ? 1 : 0) {
    if (task_.control.progress)
      task_.control.progress(0.99 * fraction_, "finite strain");
    const double next = fraction_ + increment;
    end = failures == most_failures ? End::stopped : go_to(next > 1 - 1e-9 ? 1 : next, answer);
    increment /= end == End::failed ? 2 : 1;
    n_increments_ += end == End::settled ? 1 : 0;
  }
  if (end == End::settled)
    look_for_instability(answer);
  return finish(end, answer);
}

bool FiniteMinimum::minimise_within(const LinkLimits& limits, PenalizedOperator& at_rest, Displacement start,
                                    Answer& answer) {
  penalized_ = &at_rest;
  limits_.emplace(scene_, limits, task_.team);
  put_on_loads_of(scene_);
  fraction_ = 1;
  state_.u = std::move(start);
  evaluate(state_);
  return finish(descend(scene_.relaxation.tolerance, answer), answer);
}

bool FiniteMinimum::finish(End end, Answer& answer) {
  answer.strain_energy = state_.elastic;
  answer.reaction.clear();
  for (std::size_t i = 0; i < scene_.prescribed.size() && end == End::settled; ++i)
    answer.reaction.push_back(state_.gradient(scene_.prescribed[i].component, scene_.prescribed[i].node));
  answer.displacement = std::move(state_.u);
  return end == End::settled;
}

} // namespace maille::deform
