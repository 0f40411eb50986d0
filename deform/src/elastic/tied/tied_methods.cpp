#include "elastic/tied/tied_methods.hpp"

#include "elastic/krylov/elastic_run.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/tied/tied_model.hpp"
#include "maille/scene/plausibility.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Penalty of the least movement, over the body's length [1]: the fewest iterations on bodies of 10 to 48
/// cells; a third of it takes half as many again.
constexpr double penalty_per_cell = 0.1;

/// The links of the componentwise model, per component.
using Links = std::array<std::unique_ptr<ComponentwiseLevel>, 3>;

/// The componentwise model, and springs of any direction.
class RelaxedModel : public TiedModel {
public:
  RelaxedModel(const CoupledTask& task, CellModuli moduli)
      : RelaxedModel(task, links_of(task.scene, moduli), std::move(moduli)) {}

  void apply(const Displacement& u, Displacement& forces) override {
    for (std::size_t b = 0; b < 3; ++b)
      task().team.run(links_[b]->n_planes(), [&](int z, int) {
        find_forces(*links_[b], z, u.component(b).data(), 1, forces.component(b).data());
      });
    for (const NodalSpring& spring : springs_) {
      const Vec3 pull = pull_of(spring, u);
      for (std::size_t b = 0; b < 3; ++b)
        forces(b, spring.node) -= pull[b];
    }
  }
  /// Energy of the links [J].
  double energy(const Displacement& u) const {
    double sum = 0;
    for (std::size_t b = 0; b < 3; ++b)
      for (int z = 0; z < links_[b]->n_planes(); ++z)
        sum += energy_of_plane(*links_[b], z, u.component(b).data());
    return sum;
  }

private:
  RelaxedModel(const CoupledTask& task, Links&& links, CellModuli&& moduli)
      : RelaxedModel(task, std::move(links), std::move(moduli), diagonal_of(task.scene, links)) {}
  RelaxedModel(const CoupledTask& task, Links&& links, CellModuli&& moduli, const Displacement& diagonal)
      : TiedModel(task, std::move(moduli), diagonal, springs_at_ties(task.scene, diagonal)),
        links_(std::move(links)), springs_(nodal_springs(task.scene)) {}
  static Links links_of(const Scene& scene, const CellModuli& moduli) {
    const Index3 nodes = level_nodes(scene.specimen.grid);
    Links links;
    for (int b = 0; b < 3; ++b) {
      std::array<std::vector<double>, 3> place;
      for (std::size_t a = 0; a < 3; ++a)
        for (int i = 0; i < nodes[a]; ++i)
          place[a].push_back(i);
      links[b] = std::make_unique<ComponentwiseLevel>(
          nodes, std::move(place), weights_per_link(scene, moduli, b, 1), List<FixedNode>());
    }
    return links;
  }
  static Displacement diagonal_of(const Scene& scene, const Links& links) {
    Displacement diagonal(scene.specimen.grid);
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < diagonal.n_nodes(); ++i)
        diagonal(b, i) = links[b]->diagonal(links[b]->node_at(static_cast<std::int64_t>(i)));
    for (const NodalSpring& spring : nodal_springs(scene))
      for (int b = 0; b < 3; ++b)
        diagonal(b, spring.node) += spring.stiffness(b, b);
    return diagonal;
  }

  Links links_;
  List<NodalSpring> springs_;
};

/// Half the sum of squares of all displacements, scaled to the weight of a link; preconditioned by the
/// diagonal, because only penalties couple nodes.
class MovementModel : public TiedModel {
public:
  MovementModel(const CoupledTask& task, CellModuli moduli)
      : TiedModel(task, std::move(moduli), everywhere(task.scene.specimen.grid), {}),
        diagonal_(everywhere(task.scene.specimen.grid)) {}
  void apply(const Displacement& u, Displacement& forces) override {
    const double stiffness = stiffness_on(task().scene.specimen.grid);
    for (std::size_t i = 0; i < forces.values().size(); ++i)
      forces.values()[i] = stiffness * u.values()[i];
  }
  void set_penalties(const List<PenaltyLink>& links) override {
    const Grid& grid = task().scene.specimen.grid;
    diagonal_ = everywhere(grid);
    for (const PenaltyLink& link : links)
      for (const std::int64_t node : {link.node, link.node + grid.stride(link.axis)})
        diagonal_(link.component, node) += link.stiffness;
  }

private:
  /// The stiffness of the shortest wave of links along each axis.
  static double stiffness_on(const Grid& grid) {
    const Vec3 weight = weight_per_modulus(grid);
    return 4 * (weight[0] + weight[1] + weight[2]);
  }
  static Displacement everywhere(const Grid& grid) {
    Displacement all(grid);
    std::ranges::fill(all.values(), stiffness_on(grid));
    return all;
  }
  void precondition_bodies(const Displacement& residual, Displacement& correction) override {
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < residual.n_nodes(); ++i)
        correction(b, i) = fixed()(b, i) ? 0 : residual(b, i) / diagonal_(b, i);
  }

  Displacement diagonal_;
};

class TiedRun : public ElasticRun {
public:
  using ElasticRun::ElasticRun;
  Answer relaxed();
  Answer least_movement();
};

Answer TiedRun::relaxed() {
  const CoupledTask task = this->task();
  RelaxedModel model(task, CellModuli(scene_, CellModuli::Weights::of_relaxed));
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
    answer_.algorithm += ", limits by multipliers";
    is_converged = keep_within_limits(model, loads, {}, true, u, answer_) && is_converged;
  } else {
    Displacement forces(scene_.specimen.grid);
    model.apply(u, forces);
    subtract_loads(loads, forces);
    answer_.reaction = reactions_of_tied(model, forces);
  }
  answer_.strain_energy = model.energy(u);
  return ended(is_converged);
}

Answer TiedRun::least_movement() {
  const CoupledTask task = this->task();
  MovementModel model(task, CellModuli(scene_, CellModuli::Weights::equal));
  Displacement& u = answer_.displacement = task.initial_state();
  model.ties().bring_together(u);
  answer_.algorithm = "least movement by multipliers on bodies that slide";
  answer_.seconds.setup = clock_.seconds();
  if (largest_entry(u) == 0)
    return ended(true);
  // Limits act on waves as long as the body, whose stretches are smaller than the displacements by that
  // factor. The norm is a sum over nodes, but ties are judged one by one.
  const Index3& n = scene_.specimen.grid.cells();
  const SearchScale scale{penalty_per_cell * std::max({n[0], n[1], scene_.tied.planes}),
                          std::sqrt(static_cast<double>(scene_.specimen.grid.n_nodes()))};
  return ended(keep_within_limits(model, Loads{}, scale, false, u, answer_));
}

} // namespace

Answer solve_relaxed_tied(const Scene& scene, const Control& control) {
  if (const std::string motion = remaining_rigid_motion(scene); !motion.empty())
    return refusal("relaxed", motion + ": hold or move more of it");
  return TiedRun(scene, control, "relaxed", scene.limits_bind_relaxed()).relaxed();
}

Answer solve_limits_tied(const Scene& scene, const Control& control) {
  return in_arena("limits", control,
                  [&] { return TiedRun(scene, control, "limits", true).least_movement(); });
}

} // namespace maille::deform
