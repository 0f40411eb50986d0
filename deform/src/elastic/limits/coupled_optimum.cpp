#include "elastic/limits/coupled_optimum.hpp"

#include "control/method.hpp"
#include "elastic/componentwise/componentwise_problem.hpp"
#include "feasible/bounds/clipping.hpp"
#include "maille/scene/nodal_forces.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {
/// Multipliers are improved when the error at fixed multipliers is less than this part of that to the limits,
/// both squared. The one is measured with the penalties, in which the other counts so many times.
constexpr double enough_descent = 100;
/// The squares of the errors at fixed multipliers and to the limits count so much: measured against long
/// runs.
constexpr double part_of_descent = 0.25, part_of_gap = 36;
/// The multigrid is set up anew when so many of the links that are outside were not then, or the other way
/// round.
constexpr double enough_changes = 0.01;
constexpr int most_evaluations = 12; ///< of the slope along a direction
constexpr double flat_enough = 0.05; ///< beside the slope at the start

} // namespace

CoupledOptimum::CoupledOptimum(const CoupledTask& task, CoupledSystem& system)
    : CoupledOptimum(task, system, general_penalty) {}

CoupledOptimum::CoupledOptimum(const CoupledTask& task, CoupledSystem& system, double penalty)
    : task_(task), system_(system), moduli_(task.scene), residual_(task.scene.specimen.grid) {
  const Scene& scene = task.scene;
  const Grid& grid = scene.specimen.grid;
  const auto n = static_cast<std::size_t>(grid.n_nodes());
  is_fixed_.assign(d(), std::vector<bool>(n, false));
  has_voids_ = scene.specimen.n_matter_cells() < grid.n_cells();
  for (std::size_t node = 0; node < n && has_voids_; ++node)
    if (!scene.specimen.is_node(grid.node_at(static_cast<std::int64_t>(node))))
      for (auto& component : is_fixed_)
        component[node] = true;
  for (const Prescribed& p : task.prescribed)
    is_fixed_[static_cast<std::size_t>(p.component)][static_cast<std::size_t>(p.node)] = true;
  links_.reserve(d());
  for (std::size_t b = 0; b < d(); ++b)
    loads_.push_back(nodal_forces(scene, static_cast<int>(b)));
  for (std::size_t b = 0; b < d(); ++b)
    links_.emplace_back(scene, moduli_, *task.limits, static_cast<int>(b), is_fixed_[b], penalty);
  sums_.resize(static_cast<std::size_t>(grid.nodes()[d() - 1]));
}

double CoupledOptimum::dot(const Displacement& a, const Displacement& b) {
  return sum_over_planes([&](std::size_t first, std::size_t end) {
    double sum = 0;
    for (std::size_t c = 0; c < d(); ++c)
      for (std::size_t i = first; i < end; ++i)
        sum += a.component[c][i] * b.component[c][i];
    return sum;
  });
}

/// residual = f - K u where nodes are free, 0 elsewhere, and what the limits add.
void CoupledOptimum::begin(const Displacement& u) {
  rounding_ = rounding_tolerance(task_.scene.specimen.grid, largest_entry(u));
  system_.apply(u, residual_);
  energy_ = sum_over_planes([&](std::size_t first, std::size_t end) {
    double energy = 0;
    for (std::size_t b = 0; b < d(); ++b) {
      for (std::size_t i = first; i < end; ++i) {
        double& residual = residual_.component[b][i];
        energy += u.component[b][i] * residual;
        residual = (loads_[b].empty() ? 0 : loads_[b][i]) - residual;
      }
      for (std::size_t i = first; i < end && has_voids_; ++i)
        if (is_fixed_[b][i])
          residual_.component[b][i] = 0;
    }
    return energy;
  });
  for (const Prescribed& p : task_.prescribed)
    residual_(p.component, p.node) = 0;
  update_forces(u);
}

void CoupledOptimum::update_forces(const Displacement& u) {
  for (std::size_t b = 0; b < d(); ++b)
    links_[b].take_up(u.component[b], rounding_, task_.team);
  update_forces_of_known(u);
}

void CoupledOptimum::update_forces_of_known(const Displacement& u) {
  task_.team.run(static_cast<int>(d()), [&](int component, int) {
    const auto b = static_cast<std::size_t>(component);
    links_[b].update_forces(u.component[b], residual_.component[b]);
  });
}

/// The multigrid of the componentwise model, whose links that are outside have the penalties beside their
/// weights.
void CoupledOptimum::set_penalties(std::size_t b) {
  const Scene& scene = task_.scene;
  const int component = static_cast<int>(b);
  const double unit = largest_weight(scene, moduli_, component);
  LinkWeights weights = weights_per_link(scene, moduli_, component, unit);
  links_[b].set_penalties(weights, unit);
  std::vector<FixedNode> fixed;
  for (const Prescribed& p : task_.prescribed)
    if (p.component == component)
      fixed.push_back({p.node, 0});
  std::ranges::sort(fixed, {}, &FixedNode::node);
  componentwise_[b].reset(); // its memory first
  componentwise_[b] =
      std::make_unique<ComponentwiseSolver>(scene, std::move(weights), unit, std::move(fixed), task_.team);
}

void CoupledOptimum::precondition() {
  std::size_t outside = 0;
  for (const ActiveLinks& links : links_)
    outside += links.n_outside();
  const double enough = enough_changes * static_cast<double>(outside);
  componentwise_.resize(d());
  for (std::size_t b = 0; b < d(); ++b)
    if (componentwise_[b] == nullptr || static_cast<double>(links_[b].n_changed()) > enough) {
      set_penalties(b);
      last_ = 0;
    }
  for (std::size_t b = 0; b < d(); ++b) {
    ComponentwiseSolver& solver = *componentwise_[b];
    solver.precondition(residual_.component[b], correction_.component[b]);
    for (std::size_t i = 0; i < correction_.component[b].size(); ++i)
      if (is_fixed_[b][i])
        correction_.component[b][i] = 0;
      else if (solver.has_loose_nodes() && solver.is_loose(static_cast<std::int64_t>(i)))
        correction_.component[b][i] =
            residual_.component[b][i] / solver.stiffness_at(static_cast<std::int64_t>(i));
  }
}

double CoupledOptimum::gap() const {
  double sum = 0;
  for (const ActiveLinks& links : links_)
    sum += links.gap();
  return sum;
}

/// Along the direction, per step.
double CoupledOptimum::work_of_loads() const {
  double sum = 0;
  for (std::size_t b = 0; b < d(); ++b)
    for (std::size_t i = 0; i < loads_[b].size(); ++i)
      sum += loads_[b][i] * direction_.component[b][i];
  return sum;
}

void CoupledOptimum::take_over(const CoupledOptimum& coarse) {
  for (std::size_t b = 0; b < d(); ++b)
    links_[b].take_over(coarse.links_[b]);
}

void CoupledOptimum::improve_multipliers(const Displacement& u) {
  for (ActiveLinks& links : links_)
    links.update_multipliers();
  update_forces_of_known(u);
  last_ = 0;
}

/// The minimum along the links' direction, where a slope that only ever rises is 0: Newton's steps, kept
/// between bounds.
/// @param slope of the energy at the start, @param curvature of it
double CoupledOptimum::best_step(double slope, double curvature) {
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

void CoupledOptimum::set_direction_of_links() {
  task_.team.run(static_cast<int>(d()), [&](int component, int) {
    const auto b = static_cast<std::size_t>(component);
    const std::vector<double>& along = direction_.component[b];
    links_[b].set_direction([&](std::size_t node) { return along[node]; });
  });
}

double CoupledOptimum::slope_of_energy(double descent) const {
  // The residual has the limits' forces in it: their slope at 0 is taken off again.
  double slope = -descent;
  for (const ActiveLinks& links : links_)
    slope -= links.slope_at(0).first;
  return slope;
}

void CoupledOptimum::move(Displacement& u, double step, double slope, double curvature) {
  energy_ += step * (2 * (slope + work_of_loads()) + step * curvature);
  sum_over_planes([&](std::size_t first, std::size_t end) {
    for (std::size_t b = 0; b < d(); ++b)
      for (std::size_t i = first; i < end; ++i) {
        u.component[b][i] += step * direction_.component[b][i];
        residual_.component[b][i] -= step * image_.component[b][i];
      }
    return 0.0;
  });
  update_forces(u);
}

void CoupledOptimum::make_room() {
  if (!direction_.component.empty())
    return;
  direction_ = Displacement(task_.scene.specimen.grid);
  image_ = Displacement(task_.scene.specimen.grid);
}

/// image_ = K direction_ where components are free, 0 elsewhere.
void CoupledOptimum::find_image() {
  system_.apply(direction_, image_);
  for (const Prescribed& p : task_.prescribed)
    image_(p.component, p.node) = 0;
}

/// @pre correction_. @return false if nothing is left that can be told from rounding
bool CoupledOptimum::take_step(Displacement& u) {
  find_image();
  const double curvature = dot(direction_, image_);
  if (!(curvature > 0))
    return false;
  set_direction_of_links();
  const double slope = slope_of_energy(dot(residual_, direction_));
  move(u, best_step(slope, curvature), slope, curvature);
  return true;
}

bool CoupledOptimum::solve(Displacement& u, Answer& answer) {
  make_room();
  begin(u);
  if (correction_.component.empty())
    correction_ = Displacement(task_.scene.specimen.grid);
  double last_mixed = 0;
  while (answer.iterations < most_coupled_iterations && !task_.must_stop()) {
    precondition();
    const double now = dot(residual_, correction_), gap_now = gap();
    error_ = std::sqrt((part_of_descent * std::max(now, 0.0) + part_of_gap * gap_now) / energy_);
    if (error_ <= task_.scene.relaxation.tolerance)
      return true;
    if (!(now > 0)) { // at the minimum for these multipliers, but for rounding
      ++answer.iterations;
      improve_multipliers(u);
      continue;
    }
    const double beta = last_ > 0 ? std::max(0.0, (now - last_mixed) / last_) : 0;
    sum_over_planes([&](std::size_t first, std::size_t end) {
      for (std::size_t b = 0; b < d(); ++b)
        for (std::size_t i = first; i < end; ++i)
          direction_.component[b][i] = correction_.component[b][i] + beta * direction_.component[b][i];
      return 0.0;
    });
    last_ = now;
    if (!take_step(u))
      return true;
    ++answer.iterations;
    last_mixed = dot(residual_, correction_);
    if (now <= enough_descent * gap_now)
      improve_multipliers(u);
  }
  return false;
}

void CoupledOptimum::add_forces_of_limits(Displacement& forces) const {
  for (std::size_t b = 0; b < d(); ++b)
    links_[b].add_forces(forces.component[b]);
}

std::size_t CoupledOptimum::n_active() const {
  std::size_t sum = 0;
  for (const ActiveLinks& links : links_)
    sum += links.size();
  return sum;
}

std::int64_t CoupledOptimum::bytes() const {
  std::int64_t sum = moduli_.bytes();
  for (const Displacement* field : {&residual_, &direction_, &image_, &correction_})
    sum += bytes_of(*field);
  for (std::size_t b = 0; b < d(); ++b)
    sum += links_[b].bytes() +
           static_cast<std::int64_t>(is_fixed_[b].size() / 8 + loads_[b].size() * sizeof(double));
  for (const auto& solver : componentwise_)
    sum += solver == nullptr ? 0 : solver->bytes();
  return sum;
}

} // namespace maille::deform
