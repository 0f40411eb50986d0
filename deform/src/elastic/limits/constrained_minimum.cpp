#include "elastic/limits/constrained_minimum.hpp"

#include "control/method.hpp"
#include "feasible/bounds/clipping.hpp"
#include "lattice/tolerances.hpp"
#include "maille/scene/scene.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

namespace maille::deform {

namespace {

/// A direction ends where the slope is at most this share of that at its start. More takes steps that descend
/// less, less takes more evaluations of the slope.
constexpr double flat_enough = 0.05;

} // namespace

ConstrainedMinimum::ConstrainedMinimum(const CoupledTask& task, PenalizedOperator& system,
                                       const CellModuli& moduli, const std::vector<int>& components,
                                       Loads loads, double stiffer)
    : FieldGradients(components.size(), FixedMask(task.scene.specimen, task.prescribed).of(components),
                     FieldSums(task)),
      task_(task), system_(system) {
  links_.reserve(components.size());
  for (std::size_t k = 0; k < components.size(); ++k) {
    loads_.push_back(std::move(loads[components[k]]));
    links_.emplace_back(task.scene, moduli, *task.limits, components[k], fixed_, k, stiffer * penalty_factor);
  }
}

/// Adds what the limits add.
void ConstrainedMinimum::find_residual() {
  rounding_ = rounding_tolerance(task_.scene.specimen.grid, largest_entry(*u_));
  energy_ = FieldGradients::find_residual(loads_);
  update_forces();
}

void ConstrainedMinimum::update_forces() {
  for (std::size_t k = 0; k < links_.size(); ++k)
    links_[k].add_violated(u_->component(k), rounding_, task_.team);
  update_forces_of_known();
}

void ConstrainedMinimum::update_forces_of_known() {
  task_.team.run(static_cast<int>(links_.size()),
                 [&](int k, int) { links_[k].update_forces(u_->component(k), residual_.component(k)); });
}

void ConstrainedMinimum::improve_multipliers() {
  for (ActiveLinks& links : links_)
    links.update_multipliers();
  update_forces_of_known();
}

void ConstrainedMinimum::update_penalties() {
  if (!are_penalties_out_of_date())
    return;
  penalties_.clear();
  for (ActiveLinks& links : links_)
    links.set_penalties(penalties_);
  system_.set_penalties(penalties_);
  has_penalties_ = true;
}

bool ConstrainedMinimum::are_penalties_out_of_date() const {
  std::size_t outside = 0, changed = 0;
  for (const ActiveLinks& links : links_)
    outside += links.n_outside(), changed += links.n_changed();
  return !has_penalties_ || static_cast<double>(changed) > enough_changes * static_cast<double>(outside);
}

double ConstrainedMinimum::gap() const {
  double sum = 0;
  for (const ActiveLinks& links : links_)
    sum += links.gap();
  return sum;
}

void ConstrainedMinimum::begin_with(const ConstrainedMinimum& coarse) {
  for (std::size_t i = 0; i < links_.size(); ++i)
    links_[i].begin_with(coarse.links_[i]);
}

void ConstrainedMinimum::begin_with(const List<KeptMultiplier>& multipliers) {
  for (ActiveLinks& links : links_)
    links.begin_with(multipliers);
}

List<KeptMultiplier> ConstrainedMinimum::multipliers() const {
  List<KeptMultiplier> all;
  for (const ActiveLinks& links : links_)
    links.keep_multipliers(all);
  return all;
}

/// Root of the slope along the direction, which is monotonic: Newton steps, safeguarded by bounds.
/// @param slope of the energy at the start, @param curvature of it
double ConstrainedMinimum::best_step(double slope, double curvature) const {
  double step = 0, low = 0, high = std::numeric_limits<double>::infinity(), first = 0;
  for (int evaluation = 0; evaluation < iteration_cap; ++evaluation) {
    double value = slope + step * curvature, rise = curvature;
    for (const ActiveLinks& links : links_) {
      const ActiveLinks::Slope of_links = links.slope_at(step);
      value += of_links.first;
      rise += of_links.second;
    }
    if (evaluation == 0)
      first = std::abs(value);
    else if (std::abs(value) <= flat_enough * first)
      break;
    (value < 0 ? low : high) = step;
    const double next = step - value / rise;
    step = next > low && next < high ? next : (low + high) / 2;
  }
  return step;
}

void ConstrainedMinimum::add_forces_of_limits(Displacement& forces) const {
  for (std::size_t i = 0; i < links_.size(); ++i)
    links_[i].add_forces(forces.component(i));
}

std::size_t ConstrainedMinimum::n_active() const {
  std::size_t sum = 0;
  for (const ActiveLinks& links : links_)
    sum += links.size();
  return sum;
}

bool ConstrainedMinimum::should_continue() {
  if (answer_->iterations >= last_iteration_ || task_.must_stop())
    is_found_ = false;
  return !is_found_;
}

bool ConstrainedMinimum::should_continue_from(double product) {
  if (!std::isfinite(product)) { // diverged: no further step is defined
    is_found_ = false;
    return false;
  }
  gap_ = gap();
  error_ = Nearness{product, gap_}.error(energy_);
  if (error_ <= tolerance_)
    is_found_ = true;
  else if (!(product > 0)) { // at the minimum for these multipliers, but for rounding
    ++answer_->iterations;
    improve_multipliers();
    return false;
  }
  return !is_found_;
}

std::optional<double> ConstrainedMinimum::find_step(double beta, double product) {
  const std::optional<double> step = FieldGradients::find_step(beta, product);
  if (!step) { // the residual is at rounding level
    is_found_ = true;
    return step;
  }
  for (std::size_t k = 0; k < links_.size(); ++k)
    links_[k].set_direction(direction_.component(k));
  // The residual includes the forces of limits: subtract their slope at 0.
  slope_ = -*step * curvature_;
  for (const ActiveLinks& links : links_)
    slope_ -= links.slope_at(0).first;
  return best_step(slope_, curvature_);
}

void ConstrainedMinimum::take_step(double step) {
  energy_ += step * (2 * (slope_ + work_of(loads_)) + step * curvature_);
  FieldGradients::take_step(step);
  update_forces();
  overlap_ = sums_.dot(residual_, correction_); // with the limits' new forces
}

bool ConstrainedMinimum::should_continue_after(double, double product) {
  ++answer_->iterations;
  if (!Nearness{product, gap_}.asks_for_multipliers())
    return !are_penalties_out_of_date();
  improve_multipliers();
  return false;
}

bool ConstrainedMinimum::solve(Displacement& u, double error_tolerance, Answer& answer) {
  begin(system_, u);
  tolerance_ = error_tolerance;
  answer_ = &answer;
  last_iteration_ = answer.iterations + most_coupled_iterations;
  find_residual();
  is_found_.reset();
  while (!is_found_) {
    update_penalties();
    conjugate_gradients(*this, *this);
  }
  return *is_found_;
}

} // namespace maille::deform
