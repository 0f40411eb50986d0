#include "elastic/tied/tied_methods.hpp"

#include "control/method.hpp"
#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/tied/tied_limits.hpp"
#include "feasible/feasible_set.hpp"
#include "maille/scene/plausibility.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

constexpr std::int64_t nodes_worth_threads = 8000;

/// The componentwise model, and springs of any direction.
class RelaxedModel : public TiedModel {
public:
  RelaxedModel(const CoupledTask& task, const CellModuli& moduli, const TiedLinks& links)
      : TiedModel(task, with_springs(links.diagonal(), nodal_springs(task.scene))), links_(links),
        springs_(nodal_springs(task.scene)) {
    const List<NodalSpring> soft = springs_at_ties(task.scene, diagonal());
    for (int b = 0; b < 3; ++b) {
      const double unit = largest_weight(task.scene, moduli, b);
      Anchors anchors;
      for (const NodalSpring& spring : soft)
        if (spring.stiffness(b, b) > 0)
          anchors.emplace_hint(anchors.end(), spring.node, spring.stiffness(b, b) / unit);
      List<FixedNode> fixed = fixed_nodes(task.prescribed, b);
      std::vector<bool> loose = loose_nodes(task.scene, fixed, anchors);
      bodies_[static_cast<std::size_t>(b)] = std::make_unique<ComponentwiseSolver>(
          task.scene, weights_per_link(task.scene, moduli, b, unit), unit, std::move(fixed), std::move(loose),
          std::move(anchors), task.team);
    }
  }

  void apply(const Displacement& u, Displacement& forces) override {
    std::ranges::fill(forces.values(), 0.0);
    links_.add_forces(u, 1, forces, task().team);
    for (const NodalSpring& spring : springs_) {
      const Vec3 pull = pull_of(spring, u);
      for (std::size_t b = 0; b < 3; ++b)
        forces(b, spring.node) -= pull[b];
    }
  }

private:
  static Displacement with_springs(Displacement diagonal, const List<NodalSpring>& springs) {
    for (const NodalSpring& spring : springs)
      for (int b = 0; b < 3; ++b)
        diagonal(b, spring.node) += spring.stiffness(b, b);
    return diagonal;
  }
  void precondition_bodies(const Displacement& residual, Displacement& correction) override {
    for (std::size_t b = 0; b < 3; ++b) {
      ComponentwiseSolver& body = *bodies_[b];
      body.precondition(residual.component(b), correction.component(b));
      for (std::int64_t i = 0; body.has_loose_nodes() && i < std::ssize(residual.component(b)); ++i)
        if (body.is_loose(i))
          correction(b, i) = residual(b, i) / body.stiffness_at(i);
    }
  }

  const TiedLinks& links_;
  List<NodalSpring> springs_;
  std::array<std::unique_ptr<ComponentwiseSolver>, 3> bodies_;
};

/// Half the squares of all movements.
class MovementModel : public TiedModel {
public:
  MovementModel(const CoupledTask& task, const TiedLinks& links)
      : TiedModel(task, ones(task.scene.specimen.grid)), of_links_(links.diagonal()) {}

  void apply(const Displacement& u, Displacement& forces) override { forces = u; }
  void set_penalty(double penalty) override { penalty_ = penalty; }

private:
  static Displacement ones(const Grid& grid) {
    Displacement all(grid);
    std::ranges::fill(all.values(), 1.0);
    return all;
  }
  void precondition_bodies(const Displacement& residual, Displacement& correction) override {
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < residual.n_nodes(); ++i)
        correction(b, i) = fixed()(b, i) ? 0 : residual(b, i) / (1 + penalty_ * of_links_(b, i));
  }

  Displacement of_links_;
  double penalty_ = 0;
};

/// One question: its limits, what they permit of it, and when to stop.
class TiedQuestion {
public:
  TiedQuestion(const Scene& scene, const Control& control, bool limits_bind, std::string method)
      : scene_(scene), control_(control),
        team_(scene.specimen.grid.n_nodes() < nodes_worth_threads ? 1 : std::max(1, control.threads)) {
    answer_.method = std::move(method);
    clipping_.prescribed = scene.prescribed;
    if (!limits_bind)
      return;
    limits_.emplace(scene);
    if (!permit_all_that_is_prescribed(*limits_, scene))
      clipping_ = FeasibleSet(scene, *limits_, control.threads).clip();
  }
  Answer relaxed();
  Answer least_movement();

private:
  CoupledTask task() {
    return {scene_,
            control_,
            clipping_.prescribed,
            team_,
            clock_,
            [this] { return must_stop(); },
            limits_ ? &*limits_ : nullptr};
  }
  bool must_stop() {
    if (!stopped_)
      stopped_ = reason_to_stop(control_, clock_);
    return stopped_.has_value();
  }
  Answer ended(bool is_converged);

  const Scene& scene_;
  const Control& control_;
  Clock clock_;
  ThreadTeam team_;
  std::optional<LinkLimits> limits_;
  Clipping clipping_;
  Answer answer_;
  std::optional<Status> stopped_;
};

Answer TiedQuestion::ended(bool is_converged) {
  if (!is_converged && !stopped_)
    stopped_ = Status::budget_reached;
  if (stopped_)
    answer_.reaction.clear();
  if (const std::string cut = describe(scene_, clipping_); !cut.empty())
    answer_.message = answer_.message.empty() ? cut : cut + "; " + answer_.message;
  answer_.n_cut = clipping_.n_cut;
  answer_.status = stopped_ ? *stopped_ : clipping_.n_cut > 0 ? Status::clamped : Status::done;
  answer_.seconds.solve = clock_.seconds() - answer_.seconds.setup;
  return std::move(answer_);
}

Answer TiedQuestion::relaxed() {
  const CoupledTask task = this->task();
  const CellModuli moduli(scene_, CellModuli::Weights::of_relaxed);
  TiedLinks links = links_of_matter(scene_, moduli);
  RelaxedModel model(task, moduli, links);
  const Loads loads = loads_of(scene_);
  Displacement& u = answer_.displacement = task.initial_state();
  model.ties().bring_together(u);
  answer_.algorithm = "elastic, multigrid a component in conjugate gradients on bodies that slide";
  answer_.seconds.setup = clock_.seconds();
  FlexibleGradients gradients(task, loads, model.fixed());
  const CoupledRound end = gradients.solve(model, u, answer_);
  if (end == CoupledRound::stalled) {
    Answer failed = refusal(answer_.method, gradients.problem());
    failed.status = Status::failed;
    return failed;
  }
  bool is_converged = end == CoupledRound::finished;
  if (limits_ && breaks_limits(scene_, *limits_, team_, u, 0)) {
    answer_.algorithm += ", limits by alternating directions";
    is_converged = keep_within_limits(model, links, loads, 1, true, u, answer_) && is_converged;
  } else {
    Displacement forces(scene_.specimen.grid);
    model.apply(u, forces);
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < loads[b].size(); ++i)
        forces(b, i) -= loads[b][i];
    answer_.reaction = reactions_of_tied(model, forces);
  }
  Displacement forces(scene_.specimen.grid);
  links.add_forces(u, 1, forces, team_);
  double twice = 0;
  for (std::size_t i = 0; i < u.values().size(); ++i)
    twice += u.values()[i] * forces.values()[i];
  answer_.strain_energy = 0.5 * twice;
  return ended(is_converged);
}

Answer TiedQuestion::least_movement() {
  const CoupledTask task = this->task();
  TiedLinks links(scene_, [](const Index3&, int, int) { return 1.0; });
  MovementModel model(task, links);
  Displacement& u = answer_.displacement = task.initial_state();
  model.ties().bring_together(u);
  answer_.algorithm = "least movement by alternating directions on bodies that slide";
  answer_.seconds.setup = clock_.seconds();
  if (largest_entry(u) == 0)
    return ended(true);
  // What balances the slowest wave along the body and the quickest, 12: see Boyd et al., section 3.
  const Index3& n = scene_.specimen.grid.cells();
  const double longest = std::max({n[0], n[1], scene_.tied.planes});
  const double penalty = longest / (std::numbers::pi * std::sqrt(12.0));
  const bool is_converged = keep_within_limits(model, links, Loads{}, penalty, false, u, answer_);
  return ended(is_converged);
}

} // namespace

Answer solve_relaxed_tied(const Scene& scene, const Control& control) {
  if (const std::string motion = remaining_rigid_motion(scene); !motion.empty())
    return refusal("relaxed", motion + ": hold or move more of it");
  return TiedQuestion(scene, control, scene.limits_bind_relaxed(), "relaxed").relaxed();
}

Answer solve_limits_tied(const Scene& scene, const Control& control) {
  return in_arena("limits", control,
                  [&] { return TiedQuestion(scene, control, true, "limits").least_movement(); });
}

} // namespace maille::deform
