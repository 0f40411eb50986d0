#include "elastic/limits/constrained_minimum.hpp"

#include "control/method.hpp"
#include "feasible/bounds/clipping.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace maille::deform {

namespace {
/// Penalty of conjugate gradients, over the links' own stiffness. The cycle includes penalties, so a high one
/// is cheap and gives good multipliers; on bodies other than boxes it includes them less accurately.
constexpr double penalty_of_boxes = 100, penalty_of_bodies = 30;
/// Rebuild the multigrid when this share of the active links has changed since it was built.
constexpr double enough_changes = 0.01;
constexpr int most_evaluations = 12; ///< of the slope along a direction
constexpr double flat_enough = 0.05; ///< beside the slope at the start

std::int64_t nodes_per_plane(const Grid& grid) {
  return grid.n_nodes() / grid.nodes()[static_cast<std::size_t>(grid.dimension()) - 1];
}

} // namespace

ConstrainedMinimum::ConstrainedMinimum(const CoupledTask& task, CoupledSystem& system,
                                       const CellModuli& moduli, const std::vector<int>& components)
    : task_(task), system_(system), components_(components),
      penalty_(task.scene.specimen.n_matter_cells() < task.scene.specimen.grid.n_cells() ? penalty_of_bodies
                                                                                         : penalty_of_boxes),
      is_fixed_(components.size()), loads_(is_fixed_.size()),
      preconditioner_(task.scene, moduli, components, task.prescribed, task.team),
      sums_(task.scene.specimen.grid, task.team, nodes_per_plane(task.scene.specimen.grid)) {
  const Specimen& body = task.scene.specimen;
  const Grid& grid = body.grid;
  has_voids_ = body.n_matter_cells() < grid.n_cells();
  links_.reserve(components.size());
  for (std::size_t k = 0; k < components.size(); ++k) {
    is_fixed_[k].assign(static_cast<std::size_t>(grid.n_nodes()), false);
    for (std::size_t node = 0; node < is_fixed_[k].size() && has_voids_; ++node)
      is_fixed_[k][node] = !body.is_node(grid.node_at(static_cast<std::int64_t>(node)));
    loads_[k] = nodal_forces(task.scene, components[k]);
  }
  for_each_prescribed([&](std::size_t k, std::size_t node) { is_fixed_[k][node] = true; });
  for (std::size_t k = 0; k < components.size(); ++k)
    links_.emplace_back(task.scene, moduli, *task.limits, components[k], is_fixed_[k], penalty_);
  residual_ = field();
}

template<class Visit>
void ConstrainedMinimum::for_each_prescribed(const Visit& visit) const {
  for (const Prescribed& p : task_.prescribed)
    if (const auto place = std::ranges::find(components_, p.component); place != components_.end())
      visit(static_cast<std::size_t>(place - components_.begin()), static_cast<std::size_t>(p.node));
}

Displacement ConstrainedMinimum::field() const {
  return Displacement(components_.size(), is_fixed_.front().size());
}

void ConstrainedMinimum::make_room() {
  if (!direction_.empty())
    return;
  direction_ = field();
  image_ = field();
}

/// residual = f - K u where nodes are free, 0 elsewhere, and what the limits add.
void ConstrainedMinimum::begin(const Displacement& u) {
  rounding_ = rounding_tolerance(task_.scene.specimen.grid, largest_entry(u));
  system_.apply(u, residual_);
  energy_ = sums_.sum([&](std::size_t first, std::size_t end) {
    double energy = 0;
    for (std::size_t k = 0; k < components_.size(); ++k) {
      for (std::size_t i = first; i < end; ++i) {
        double& residual = residual_(k, i);
        energy += u(components_[k], i) * residual;
        residual = (loads_[k].empty() ? 0 : loads_[k][i]) - residual;
      }
      for (std::size_t i = first; i < end && has_voids_; ++i)
        if (is_fixed_[k][i])
          residual_(k, i) = 0;
    }
    return energy;
  });
  for_each_prescribed([&](std::size_t k, std::size_t node) { residual_(k, node) = 0; });
  update_forces(u);
}

void ConstrainedMinimum::update_forces(const Displacement& u) {
  for (std::size_t i = 0; i < links_.size(); ++i)
    links_[i].take_up(u.component(components_[i]), rounding_, task_.team);
  update_forces_of_known(u);
}

void ConstrainedMinimum::update_forces_of_known(const Displacement& u) {
  task_.team.run(static_cast<int>(links_.size()), [&](int i, int) {
    const auto k = static_cast<std::size_t>(i);
    links_[k].update_forces(u.component(components_[k]), residual_.component(k));
  });
}

void ConstrainedMinimum::improve_multipliers(const Displacement& u) {
  for (ActiveLinks& links : links_)
    links.update_multipliers();
  update_forces_of_known(u);
}

void ConstrainedMinimum::set_penalty(double rho) {
  for (ActiveLinks& links : links_)
    links.set_penalty(rho);
  has_penalties_ = false;
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

/// Along the direction, per step.
double ConstrainedMinimum::work_of_loads() const {
  double sum = 0;
  for (std::size_t b = 0; b < loads_.size(); ++b)
    for (std::size_t i = 0; i < loads_[b].size(); ++i)
      sum += loads_[b][i] * direction_(b, i);
  return sum;
}

void ConstrainedMinimum::take_over(const ConstrainedMinimum& coarse) {
  for (std::size_t i = 0; i < links_.size(); ++i)
    links_[i].take_over(coarse.links_[i]);
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

/// The minimum along the links' direction, where a slope that only ever rises is 0: Newton's steps, kept
/// between bounds.
/// @param slope of the energy at the start, @param curvature of it
double ConstrainedMinimum::best_step(double slope, double curvature) const {
  double step = 0, low = 0, high = std::numeric_limits<double>::infinity(), first = 0;
  for (int evaluation = 0; evaluation < most_evaluations; ++evaluation) {
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

/// Slope of the energy along the direction of the links, without the forces of the limits.
/// @param descent residual_ . direction
double ConstrainedMinimum::slope_of_energy(double descent) const {
  // The residual has the limits' forces in it: their slope at 0 is taken off again.
  double slope = -descent;
  for (const ActiveLinks& links : links_)
    slope -= links.slope_at(0).first;
  return slope;
}

/// image_ = K direction_ where components are free, 0 elsewhere; the links know the direction.
void ConstrainedMinimum::find_image() {
  system_.apply(direction_, image_);
  for_each_prescribed([&](std::size_t k, std::size_t node) { image_(k, node) = 0; });
  task_.team.run(static_cast<int>(links_.size()), [&](int i, int) {
    const std::span<const double> along = direction_.component(i);
    links_[static_cast<std::size_t>(i)].set_direction([&](std::size_t node) { return along[node]; });
  });
}

void ConstrainedMinimum::move(Displacement& u, double step) {
  energy_ += step * (2 * (slope_ + work_of_loads()) + step * curvature_);
  sums_.add(step, direction_, 1, u, static_cast<std::size_t>(components_.front()));
  sums_.add(-step, image_, 1, residual_);
  update_forces(u);
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

double ConstrainedMinimum::precondition() {
  preconditioner_.precondition(residual_, correction_);
  return sums_.dot(residual_, correction_);
}

bool ConstrainedMinimum::goes_on() {
  if (answer_->iterations >= most_coupled_iterations || task_.must_stop())
    is_found_ = false;
  return !is_found_;
}

bool ConstrainedMinimum::goes_on_from(double product) {
  gap_ = gap();
  error_ = Nearness{product, gap_}.error(energy_);
  if (error_ <= task_.scene.relaxation.tolerance)
    is_found_ = true;
  else if (!(product > 0)) { // at the minimum for these multipliers, but for rounding
    ++answer_->iterations;
    improve_multipliers(*state_);
    return false;
  }
  return !is_found_;
}

std::optional<double> ConstrainedMinimum::find_step(double beta, double) {
  sums_.add(1, correction_, beta, direction_);
  find_image();
  curvature_ = sums_.dot(direction_, image_);
  if (!(curvature_ > 0)) { // the residual is at rounding level
    is_found_ = true;
    return std::nullopt;
  }
  slope_ = slope_of_energy(sums_.dot(residual_, direction_));
  return best_step(slope_, curvature_);
}

void ConstrainedMinimum::take_step(double step) {
  move(*state_, step);
  overlap_ = sums_.dot(residual_, correction_);
}

bool ConstrainedMinimum::goes_on_after(double, double product) {
  ++answer_->iterations;
  if (!Nearness{product, gap_}.asks_for_multipliers())
    return !are_penalties_out_of_date();
  improve_multipliers(*state_);
  return false;
}

/// Each time anew where multipliers or the preconditioner are others.
bool ConstrainedMinimum::go_on_by_gradients(Displacement& u, Answer& answer) {
  make_room();
  set_penalty(penalty_);
  begin(u);
  if (correction_.empty())
    correction_ = field();
  state_ = &u;
  answer_ = &answer;
  is_found_.reset();
  while (!is_found_) {
    set_penalties(preconditioner_);
    conjugate_gradients(*this, *this);
  }
  return *is_found_;
}

} // namespace maille::deform
