

#include "elastic/corotated/corotated_relaxation.hpp"

#include "elastic/limits/active_links.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <ranges>
#include <utility>
#include <vector>

namespace maille::deform {

void QuasiNewton::apply(Displacement& field,
                        const std::function<void(Displacement&, Displacement&)>& precondition) {
  std::vector<double> share;
  for (const Pair& pair : pairs_ | std::views::reverse) {
    share.push_back(pair.inverse * sums_.dot(pair.step, field));
    sums_.add(-share.back(), pair.change, 1, field);
  }
  Displacement corrected(grid_);
  precondition(field, corrected);
  field = std::move(corrected);
  for (const Pair& pair : pairs_) {
    sums_.add(share.back() - pair.inverse * sums_.dot(pair.change, field), pair.step, 1, field);
    share.pop_back();
  }
}

void QuasiNewton::remember(Displacement step, Displacement change_of_gradient, double slope) {
  const double curvature = sums_.dot(step, change_of_gradient);
  if (!(curvature > -least_curvature * slope))
    return;
  if (pairs_.size() == most_pairs)
    pairs_.pop_front();
  pairs_.push_back({std::move(step), std::move(change_of_gradient), 1 / curvature});
}

namespace {

/// A turn for which one increment is enough. Measured: see docs/large_rotation.md.
constexpr double turn_per_increment = std::numbers::pi / 2;
/// Cells that turn by more in one increment may have lost their way; by much less where loads turn them,
/// whose linear answer grows with the load and not with its sine.
constexpr double largest_turn = 2 * std::numbers::pi / 3, largest_turn_by_loads = std::numbers::pi / 4;
/// Increments are halved no further than to this part of the way.
constexpr double least_increment = 1.0 / 256;
/// How far a start and a state between increments are settled, in the energy norm.
constexpr double start_tolerance = 1e-2;
constexpr double armijo = 1e-4;
constexpr int most_trials = 12;
/// Strains of which the energy is rounding.
constexpr double rounding_strain = 1e-14;

/// Nodal forces of all loads but contraction, which turns with cells; no components where there are none.
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

/// Scales of taut limits are not looked for: nothing here asks for them.
Scene without_search(Scene scene) {
  scene.limits.taut_scale = 0;
  return scene;
}

} // namespace

CorotatedRelaxation::CorotatedRelaxation(const CoupledTask& task, std::shared_ptr<ElasticOperator> at_rest)
    : task_(task), scene_(without_search(task.scene)), linear_(scene_), elasticity_(scene_, linear_),
      preconditioner_(task, std::move(at_rest)), sums_(scene_.specimen.grid, task.team),
      memory_(scene_.specimen.grid, sums_) {
  state_.u = state_.gradient = Displacement(scene_.specimen.grid);
  floor_ = rounding_strain * rounding_strain * energy_of_unit_strain(scene_, linear_);
}

int CorotatedRelaxation::planned_increments() const {
  if (scene_.relaxation.increments > 0)
    return scene_.relaxation.increments;
  double angle = 0;
  for (const Turn& turn : scene_.turns)
    angle = std::max(angle, std::abs(turn.angle));
  for (const Drive& drive : scene_.drives)
    angle = std::max(angle, drive.turned());
  return std::max(1, static_cast<int>(std::ceil(angle / turn_per_increment - 1e-9)));
}

/// From the present increment to that of `to`.
double CorotatedRelaxation::turn_of_handles(const Scene& to) const {
  double angle = 0;
  for (std::size_t i = 0; i < to.turns.size(); ++i)
    angle = std::max(angle, std::abs(to.turns[i].angle - fraction_ * scene_.turns[i].angle));
  for (const Drive& drive : scene_.drives) // a bound: as much as in all of the rest
    angle = std::max(angle, drive.turned() / planned_increments());
  return angle;
}

void CorotatedRelaxation::mask(Displacement& field) const {
  for (const Prescribed& p : scene_.prescribed)
    field(p.component, p.node) = 0;
}

void CorotatedRelaxation::put_on_loads_of(const Scene& step) {
  loads_ = passive_loads_of(step);
  elasticity_.set_active_stress(step.active_stress);
}

void CorotatedRelaxation::evaluate(State& state) {
  state.elastic = state.energy = elasticity_.evaluate(state.u, state.gradient, task_.team);
  state.energy += elasticity_.active_energy();
  if (limits_)
    state.energy += limits_->evaluate(state.u, elasticity_, state.gradient);
  state.energy += energy_of_springs(linear_.springs(), state.u);
  for (const NodalSpring& spring : linear_.springs()) {
    const Vec3 pull = pull_of(spring, state.u);
    for (int b = 0; b < scene_.dimension(); ++b)
      state.gradient(b, spring.node) -= pull[b];
  }
  if (loads_.empty())
    return;
  state.energy -= sums_.dot(loads_, state.u);
  sums_.add(-1, loads_, 1, state.gradient);
}

/// As the object's frame goes from one increment to the next, so does the body.
void CorotatedRelaxation::carry(const Scene& from, const Scene& to) {
  const Frame before = object_frame(from), after = object_frame(to);
  to_object(from, before, state_.u);
  to_world(to, after, state_.u);
}

/// The second derivative of the energy in fixed frames, around the preconditioner that turns with them.
class CorotatedRelaxation::FixedFrames : public ElasticOperator {
public:
  explicit FixedFrames(CorotatedRelaxation& of) : of_(of), turned_(of.scene_.specimen.grid) {}
  void apply(const Displacement& u, Displacement& forces) override {
    of_.elasticity_.apply_in_fixed_frames(u, forces, of_.task_.team);
  }
  void precondition(const Displacement& residual, Displacement& correction) override {
    turned_ = residual;
    of_.preconditioner_.apply(turned_, correction);
  }

private:
  CorotatedRelaxation& of_;
  Displacement turned_;
};

/// d += a correction that brings the residual to a hundredth, with frames as they are. @return false if
/// stopped
bool CorotatedRelaxation::solve_in_fixed_frames(Displacement& d, const Displacement& residual,
                                                Answer& answer) {
  FixedFrames K(*this);
  FieldGradients gradients(residual.n_components(), FixedMask(scene_.specimen.grid, scene_.prescribed),
                           FieldSums(scene_.specimen.grid, task_.team));
  gradients.residual() = residual;
  mask(gradients.residual());
  gradients.begin(K, d);
  ReductionWatch reduced(most_coupled_iterations, start_tolerance, task_.must_stop, floor_);
  conjugate_gradients(gradients, reduced);
  answer.iterations += reduced.iterations();
  return !task_.must_stop();
}

/// From the last increment's state to a start for this one, with handles in place.
CorotatedRelaxation::End CorotatedRelaxation::predict(const Scene& to, Answer& answer) {
  evaluate(state_);
  preconditioner_.turn_with(elasticity_);
  const List<Eigen::Quaterniond> before = elasticity_.frames();
  Displacement d(scene_.specimen.grid), residual(d);
  for (const Prescribed& p : to.prescribed)
    d(p.component, p.node) = p.value - state_.u(p.component, p.node);
  elasticity_.apply_in_fixed_frames(d, residual, task_.team);
  sums_.add(-1, state_.gradient, -1, residual);
  if (!solve_in_fixed_frames(d, residual, answer))
    return End::stopped;

  State warped;
  warped.u = state_.u;
  sums_.add(1, d, 1, warped.u);
  warped.gradient = Displacement(scene_.specimen.grid);
  for (const Prescribed& p : to.prescribed)
    warped.u(p.component, p.node) = p.value;
  state_.u = warped.u;
  elasticity_.warp_frames(d);
  preconditioner_.turn_with(elasticity_);
  elasticity_.evaluate_in_fixed_frames(warped.u, residual, task_.team);
  sums_.add(0, residual, -1, residual);
  if (!loads_.empty())
    sums_.add(1, loads_, 1, residual);
  if (!solve_in_fixed_frames(warped.u, residual, answer))
    return End::stopped;
  evaluate(state_);
  const bool was_torn = is_torn();
  evaluate(warped);
  if (warped.energy < state_.energy && (was_torn || !is_torn()))
    state_ = std::move(warped);
  evaluate(state_);
  double least = 1; // cosine of half the largest turn of any frame
  const double allowed =
      scene_.has_loads() ? std::min(largest_turn, turn_of_handles(to) + largest_turn_by_loads) : largest_turn;
  for (std::size_t i = 0; i < before.size(); ++i)
    least = std::min(least, std::abs(before[i].dot(elasticity_.frames()[i])));
  return is_torn() || least < std::cos(allowed / 2) ? End::torn : End::settled;
}

bool CorotatedRelaxation::is_torn() const {
  return elasticity_.n_inverted() > 0;
}

CorotatedRelaxation::End CorotatedRelaxation::go_to(double fraction, Answer& answer) {
  const Scene from = scaled(scene_, fraction_), to = scaled(scene_, fraction);
  const Displacement before = state_.u;
  put_on_loads_of(to);
  memory_.forget();
  carry(from, to);
  End end = predict(to, answer);
  const bool may_halve = fraction - fraction_ > least_increment;
  if (end == End::stopped || (end == End::torn && may_halve)) {
    state_.u = before;
    put_on_loads_of(from);
    evaluate(state_);
    return end;
  }
  const double reached = std::exchange(fraction_, fraction);
  end = descend(fraction < 1 ? start_tolerance : scene_.relaxation.tolerance, answer);
  if (end == End::settled && is_torn() && may_halve) { // on the way down
    fraction_ = reached;
    state_.u = before;
    put_on_loads_of(from);
    evaluate(state_);
    return End::torn;
  }
  return end;
}

/// Tries ever shorter steps. @return false if none lowers the energy
bool CorotatedRelaxation::step_downhill(const Displacement& direction, double slope, State& next) {
  double length = 1;
  for (int trial = 0; trial < most_trials; ++trial) {
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

/// @param slope of the energy along the direction to where its minimum is thought to be
double CorotatedRelaxation::estimated_error(double slope) const {
  const double product = std::max(0.0, -slope), energy = std::max(2 * state_.elastic, floor_);
  return std::min(1.0, limits_ ? Nearness{product, limits_->gap()}.error(energy)
                               : 2 * std::sqrt(product / energy));
}

CorotatedRelaxation::End CorotatedRelaxation::descend(double goal, Answer& answer) {
  State next{state_.u, state_.gradient};
  bool has_moved = false; // since multipliers were last improved; never without limits
  for (int i = 0; i < most_coupled_iterations; ++i) {
    if (watch)
      watch(fraction_, state_.energy);
    if (task_.must_stop())
      return End::stopped;
    if (limits_ && limits_->are_penalties_out_of_date())
      penalized_->set_penalties(limits_->penalties());
    preconditioner_.turn_with(elasticity_);
    Displacement direction = state_.gradient;
    mask(direction);
    memory_.apply(direction, [&](Displacement& r, Displacement& z) {
      mask(r);
      preconditioner_.apply(r, z);
    });
    mask(direction);
    sums_.add(0, direction, -1, direction);
    const double slope = sums_.dot(state_.gradient, direction); // handles do not move along it
    answer.residual = estimated_error(slope);
    const double rounding = 16 * std::numeric_limits<double>::epsilon() *
                            (state_.elastic + std::abs(state_.elastic - state_.energy));
    const bool is_lowest = -slope <= std::max(floor_, rounding);
    if (answer.residual <= goal || (is_lowest && !limits_))
      return End::settled;
    if (has_moved && (is_lowest || Nearness{-slope, limits_->gap()}.asks_for_multipliers())) {
      limits_->improve_multipliers();
      evaluate(state_);
      has_moved = false;
      continue;
    }
    if (!step_downhill(direction, slope, next)) {
      evaluate(state_);
      if (memory_.is_empty()) // as far as the energy can tell; the residual says how far that is
        return limits_ ? End::stopped : End::settled;
      memory_.forget();
      has_moved = limits_.has_value();
      continue;
    }
    has_moved = limits_.has_value();
    Displacement step = next.u, change = next.gradient;
    sums_.add(-1, state_.u, 1, step);
    sums_.add(-1, state_.gradient, 1, change);
    mask(change);
    memory_.remember(std::move(step), std::move(change), slope);
    std::swap(state_, next);
    ++answer.iterations;
  }
  return End::stopped;
}

void CorotatedRelaxation::find_reactions(Answer& answer) const {
  for (const Prescribed& p : scene_.prescribed)
    answer.reaction.push_back(state_.gradient(p.component, p.node));
}

bool CorotatedRelaxation::solve(Answer& answer) {
  const double planned = 1.0 / planned_increments();
  double increment = planned;
  answer.residual = 1;
  End end = End::settled;
  while (fraction_ < 1 && end != End::stopped) {
    if (task_.control.progress)
      task_.control.progress(0.99 * fraction_, "bending");
    const double next = fraction_ + increment;
    end = go_to(next > 1 - 1e-9 ? 1 : next, answer);
    increment = end == End::torn ? increment / 2 : std::min(planned, 2 * increment);
    n_increments_ += end == End::settled ? 1 : 0;
  }
  return finish(end, answer);
}

bool CorotatedRelaxation::minimise_within(const LinkLimits& limits, PenalizedOperator& at_rest,
                                          Displacement start, Answer& answer) {
  penalized_ = &at_rest;
  limits_.emplace(scene_, limits, task_.team);
  memory_.forget();
  put_on_loads_of(scene_);
  fraction_ = 1;
  state_.u = std::move(start);
  evaluate(state_);
  return finish(descend(scene_.relaxation.tolerance, answer), answer);
}

bool CorotatedRelaxation::finish(End end, Answer& answer) {
  answer.strain_energy = state_.elastic;
  answer.reaction.clear();
  if (end == End::settled)
    find_reactions(answer);
  answer.displacement = std::move(state_.u);
  return end == End::settled;
}

} // namespace maille::deform
