#include "elastic/elastic_methods.hpp"

#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/krylov/elastic_run.hpp"
#include "elastic/limits/constrained_minimum.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/tied/tied_methods.hpp"
#include "feasible/feasible_set.hpp"
#include "maille/deform/plan.hpp"
#include "maille/scene/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// One relaxation, component after component.
class Relaxation : private ElasticRun {
public:
  Relaxation(const Scene& scene, const Control& control);
  Answer run();
  /// True if limits are taut without a given scale, though loads pull.
  bool has_no_slack() const {
    return scene_.has_loads() && scene_.limits.from == LimitSource::taut && limits_->taut_scale() == 0;
  }

private:
  void relax(int component);
  void stay_within(ComponentwiseSolver& solver, const List<double>& forces, int component);
  void react(int component, const ComponentwiseSolver& solver, const List<double>& forces);
  void keep_energy(ComponentwiseSolver& solver, int component);
  void finish();
  Answer failure() const;
  double scale_of(std::span<const double> u) const;

  CellModuli moduli_;
  std::array<double, 3> energy_{};
  std::array<bool, 3> is_feasible_{true, true, true};
  bool used_multipliers_ = false;
  double scale_ = 0; ///< largest displacement that is really prescribed [m]
};

Relaxation::Relaxation(const Scene& scene, const Control& control)
    : ElasticRun(scene, control, "relaxed", scene.limits_bind_relaxed()),
      moduli_(scene, CellModuli::Weights::of_relaxed) {
  answer_.displacement = Displacement(scene.specimen.grid);
  answer_.reaction.assign(scene.prescribed.size(), 0);
  for (const Prescribed& p : clipping_.prescribed)
    scale_ = std::max(scale_, std::abs(p.value));
  answer_.seconds.setup = clock_.seconds();
}

double Relaxation::scale_of(std::span<const double> u) const {
  double largest = scale_;
  if (largest == 0)
    for (const double value : u)
      largest = std::max(largest, std::abs(value));
  return largest;
}

void Relaxation::relax(int component) {
  List<FixedNode> fixed = fixed_nodes(clipping_.prescribed, component);
  const List<double> forces = nodal_forces(scene_, component);
  const bool is_at_rest =
      forces.empty() && std::ranges::all_of(fixed, [](const FixedNode& f) { return f.value == 0; });
  if (is_at_rest)
    return;
  const double before = clock_.seconds();
  ComponentwiseSolver solver(scene_, moduli_, component, std::move(fixed), team_);
  answer_.seconds.setup += clock_.seconds() - before;
  if (solver.has_loose_nodes())
    for (std::size_t node = 0; node < forces.size(); ++node)
      if (forces[node] != 0 && solver.is_loose(static_cast<std::int64_t>(node))) {
        answer_.status = Status::failed;
        answer_.message =
            fmt::format("a load pulls along {} at node {}, which no link joins to a node that is held or "
                        "moved along {}: nothing says where it ends",
                        "xyz"[component], node, "xyz"[component]);
        return;
      }
  const std::span<double> u = answer_.displacement.component(component);
  const auto stop = [this] { return must_stop(); };
  double scale = scale_;
  if (scale == 0) { // loads alone: the start gives the scale of displacements
    solver.solve(u, forces, std::numeric_limits<double>::infinity(), false, stop);
    scale = scale_of(u);
  }
  const SolveOutcome outcome =
      solver.solve(u, forces, scene_.relaxation.tolerance * scale, scale_ == 0, stop);
  answer_.iterations += outcome.iterations;
  const double residual = scale > 0 ? outcome.remaining / scale : 0;
  answer_.residual = std::max(answer_.residual, std::isfinite(residual) ? residual : 1);
  if (outcome.was_stopped && !stopped_)
    stopped_ = Status::budget_reached;
  const auto [least, most] = range_of(u);
  const bool is_outside =
      limits_ && breaks_limits(scene_, *limits_, team_, component, u,
                               rounding_tolerance(scene_.specimen.grid, std::max(-least, most)));
  is_feasible_[component] = !is_outside;
  if (is_outside)
    stay_within(solver, forces, component);
  else {
    react(component, solver, forces);
    keep_energy(solver, component);
  }
}

void Relaxation::stay_within(ComponentwiseSolver& solver, const List<double>& forces, int component) {
  if (stopped_)
    return;
  used_multipliers_ = true;
  const CoupledTask task = this->task();
  ComponentwiseSystem system(task, moduli_, solver, component);
  Loads loads;
  loads[component] = forces;
  ConstrainedMinimum minimum(task, system, moduli_, {component}, std::move(loads));
  const std::span<double> all = answer_.displacement.component(component);
  Displacement u(1, all.size());
  std::ranges::copy(all, u.values().begin());
  if (!minimum.solve(u, scene_.relaxation.tolerance, answer_) && !stopped_)
    stopped_ = Status::budget_reached;
  std::ranges::copy(u.values(), all.begin());
  answer_.residual = std::max(answer_.residual, std::min(1.0, minimum.error()));
  react(component, solver, forces);
  Displacement of_limits = minimum.release_residual();
  std::ranges::fill(of_limits.values(), 0.0);
  minimum.add_forces_of_limits(of_limits);
  for (std::size_t i = 0; i < scene_.prescribed.size(); ++i)
    if (scene_.prescribed[i].component == component)
      answer_.reaction[i] += of_limits(0, scene_.prescribed[i].node);
}

/// Reactions of the links at prescribed nodes.
void Relaxation::react(int component, const ComponentwiseSolver& solver, const List<double>& forces) {
  const std::span<const double> u = answer_.displacement.component(component);
  for (std::size_t i = 0; i < scene_.prescribed.size(); ++i) {
    const Prescribed& p = scene_.prescribed[i];
    if (p.component == component)
      answer_.reaction[i] = solver.elastic_force(u, p.node) - (forces.empty() ? 0 : forces[p.node]);
  }
}

void Relaxation::keep_energy(ComponentwiseSolver& solver, int component) {
  energy_[component] = solver.energy(answer_.displacement.component(component));
}

/// Makes the answer feasible, with the prescribed values, however the solve ended.
void Relaxation::finish() {
  const bool was_cut_short = stopped_.has_value();
  if (was_cut_short || std::ranges::find(is_feasible_, false) != is_feasible_.end()) {
    if (limits_)
      FeasibleSet(scene_, *limits_, control_.threads).bring_in(clipping_.prescribed, answer_.displacement);
    else
      for (const Prescribed& p : clipping_.prescribed)
        answer_.displacement(p.component, p.node) = p.value;
    for (int component = 0; component < scene_.dimension(); ++component)
      if (was_cut_short || !is_feasible_[component]) {
        ComponentwiseSolver weights(scene_, moduli_, component, fixed_nodes(clipping_.prescribed, component),
                                    team_);
        keep_energy(weights, component);
      }
  }
  answer_.strain_energy = energy_[0] + energy_[1] + energy_[2];
}

Answer Relaxation::run() {
  for (int component = 0; component < scene_.dimension() && !must_stop(); ++component) {
    if (control_.progress)
      control_.progress(static_cast<double>(component) / scene_.dimension(), "relaxing");
    relax(component);
    if (answer_.status == Status::failed)
      return failure();
  }
  finish();
  answer_.algorithm = fmt::format("elastic, {}, multigrid in conjugate gradients{}",
                                  moduli_.is_homogeneous_box() ? "homogeneous box" : "weights per link",
                                  used_multipliers_ ? ", limits by multipliers" : "");
  return ended(true);
}

Answer Relaxation::failure() const {
  Answer answer = refusal("relaxed", answer_.message);
  answer.status = Status::failed;
  return answer;
}

/// All feasible states have energy 0; `limits` gives the one nearest to rest.
Answer least_movement(const Scene& scene, const Control& control) {
  Answer answer =
      scene.tied.ties.empty() ? solve_by_cheapest_way(scene, control) : solve_limits_tied(scene, control);
  answer.method = "relaxed";
  if (has_displacement(answer.status)) {
    answer.algorithm = "deformable, least movement by " + answer.algorithm;
    answer.strain_energy = 0;
  }
  return answer;
}

} // namespace

Answer solve_relaxed(const Scene& scene, const Control& control) {
  const bool is_elastic = scene.relaxation.mode == RelaxationMode::elastic;
  if (std::string reason = is_elastic ? reason_of_moves(scene) : reason_to_refuse(scene, "relaxed");
      !reason.empty())
    return refusal("relaxed", std::move(reason));
  if (scene.contracts())
    return refusal(
        "relaxed",
        "relaxed carries no contraction: its components do not feel each other, so a fibre cannot pull; use "
        "coupled or finite elements");
  const bool is_tied = !scene.tied.ties.empty();
  if (!is_tied && !springs_are_along_axes(scene))
    return refusal("relaxed",
                   "relaxed carries springs to the ground along the axes of the grid only: one along "
                   "another direction joins components, which do not feel each other");
  if (!is_elastic)
    return least_movement(scene, control);
  return in_arena("relaxed", control, [&] {
    if (is_tied)
      return solve_relaxed_tied(scene, control);
    Relaxation relaxation(scene, control);
    return relaxation.has_no_slack()
               ? refusal("relaxed",
                         "taut limits take their scale from the moves of the scene, and here only loads "
                         "move the body: no link "
                         "has any play; leave [limits] out, give some, or ask by moves")
               : relaxation.run();
  });
}

} // namespace maille::deform
