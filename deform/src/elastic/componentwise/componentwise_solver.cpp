#include "elastic/componentwise/componentwise_solver.hpp"

#include "elastic/componentwise/componentwise_kernel.hpp"
#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Reduction of the error per round in float32; then the residual is recomputed in float64.
constexpr double reduction_per_residual = 1e-4;

/// Estimates the remaining error from the changes of successive steps.
class StepErrors {
public:
  void add(double change) {
    contraction_ = {contraction_[1], contraction_[2], last_ > 0 ? change / last_ : 0};
    last_ = change;
    ++steps_;
  }
  double remaining() const {
    if (last_ == 0)
      return 0;
    if (steps_ < 2)
      return std::numeric_limits<double>::infinity();
    const double rho = std::max({contraction_[0], contraction_[1], contraction_[2], least_contraction});
    return rho < 1 ? safety * last_ * rho / (1 - rho) : std::numeric_limits<double>::infinity();
  }

private:
  static constexpr double least_contraction = 0.1; ///< smaller measured rates are not trusted
  static constexpr double safety = 2;
  int steps_ = 0;
  double last_ = 0;
  std::array<double, 3> contraction_{0, 0, 0};
};

List<FixedNode> with_loose_ones(const List<FixedNode>& fixed, const std::vector<bool>& loose) {
  List<FixedNode> all = fixed;
  for (std::size_t node = 0; node < loose.size(); ++node)
    if (loose[node])
      all.push_back({static_cast<std::int64_t>(node), 0});
  std::ranges::sort(all, {}, &FixedNode::node);
  return all;
}

} // namespace

ComponentwiseSolver::ComponentwiseSolver(const Scene& scene, const CellModuli& moduli, int component,
                                         List<FixedNode> fixed, ThreadTeam& team)
    : ComponentwiseSolver(
          scene, link_weights(scene, moduli, component, largest_weight(scene, moduli, component)),
          largest_weight(scene, moduli, component), fixed,
          loose_nodes(scene, fixed, springs_along(nodal_springs(scene), component, 1)),
          springs_along(nodal_springs(scene), component, largest_weight(scene, moduli, component)), team) {}

ComponentwiseSolver::ComponentwiseSolver(const Scene& scene, LinkWeights weights, double unit,
                                         List<FixedNode> fixed, std::vector<bool> is_loose, Anchors springs,
                                         ThreadTeam& team)
    : grid_(scene.specimen.grid), unit_(unit), fixed_(std::move(fixed)), is_loose_(std::move(is_loose)) {
  const Index3 nodes = level_nodes(grid_);
  std::array<std::vector<double>, 3> place;
  for (std::size_t a = 0; a < 3; ++a)
    for (int i = 0; i < nodes[a]; ++i)
      place[a].push_back(i);
  multigrid_ = std::make_unique<ComponentwiseMultigrid>(
      std::make_unique<ComponentwiseLevel>(nodes, std::move(place), std::move(weights),
                                           with_loose_ones(fixed_, is_loose_), std::move(springs)),
      team);
  direction_ = PaddedArray(multigrid_->finest().u.size());
}

void ComponentwiseSolver::begin_from_coarsest(std::span<double> u) {
  ComponentwiseLevel& finest = multigrid_->finest();
  load_field(
      finest, multigrid_->team(), [&](std::size_t) { return forces_.empty() ? nullptr : forces_.data(); },
      Vec3{1, 1, 1}, finest.f.data());
  multigrid_->solve_from_coarsest(!forces_.empty());
  store_field(finest, multigrid_->team(), finest.u.data(), Vec3{1, 1, 1},
              [&](std::size_t) { return u.data(); });
  for (const FixedNode& fixed : finest.fixed())
    u[fixed.node] = fixed.value;
}

/// Forces minus spring forces, in unit_; null if there are none.
const double* ComponentwiseSolver::forces_less_springs(std::span<const double> u) {
  const Anchors& springs = multigrid_->finest().anchors();
  if (springs.empty())
    return forces_.empty() ? nullptr : forces_.data();
  with_springs_ = forces_;
  with_springs_.resize(u.size(), 0);
  for (const auto& [node, stiffness] : springs)
    with_springs_[node] -= stiffness * u[node];
  return with_springs_.data();
}

/// Loads the scaled residual as the right-hand side of the multigrid. @return the scale
double ComponentwiseSolver::begin_correction(std::span<const double> u, const double* forces) {
  ComponentwiseLevel& finest = multigrid_->finest();
  const auto find = [&](double scale) {
    double largest = 0;
    std::vector<double> of_plane(finest.nodes()[2]);
    multigrid_->team().run(finest.nodes()[2], [&](int z, int) {
      of_plane[z] = find_true_residual(finest, z, u.data(), forces, scale, finest.f.data());
    });
    for (const double value : of_plane)
      largest = std::max(largest, value);
    return largest;
  };
  // Weights are 1 at most, so residuals are about as large as displacements: no float32 overflows there.
  const double largest = find(1);
  if (largest > 1e-20 && largest < 1e20)
    return 1;
  if (largest > 0)
    find(1 / largest);
  return largest;
}

/// One round of conjugate gradients in float32 on the finest level's f; steps are added to u directly.
class ComponentwiseSolver::Correction : public GradientSpace {
public:
  /// @param scale of the residual
  Correction(ComponentwiseSolver& solver, std::span<double> u, double scale)
      : multigrid_(*solver.multigrid_), direction_(solver.direction_), u_(u), scale_(scale),
        sums_(static_cast<std::size_t>(multigrid_.finest().nodes()[2])), largest_(sums_) {}

  double precondition() override { return multigrid_.precondition(); }
  std::optional<double> find_step(double beta, double product) override {
    ComponentwiseLevel& finest = multigrid_.finest();
    const ComponentwiseOperator& A = finest.A();
    run_stages(multigrid_.team(), A.nodes[2], 2, [&](int stage, int z) {
      const auto i = static_cast<std::size_t>(z);
      if (stage == 0)
        largest_[i] = update_direction(A, z, finest.u.data(), static_cast<float>(beta), direction_.data());
      else
        sums_[i] = apply_and_dot(A, z, direction_.data(), finest.r.data());
    });
    const double curvature = std::accumulate(sums_.begin(), sums_.end(), 0.0);
    return curvature > 0 && std::isfinite(curvature) ? std::optional(product / curvature) : std::nullopt;
  }
  void take_step(double step) override {
    ComponentwiseLevel& finest = multigrid_.finest();
    const ComponentwiseOperator& A = finest.A();
    multigrid_.team().run(A.nodes[2], [&](int z, int) {
      sums_[z] = deform::take_step(A, z, step, scale_, direction_.data(), finest.r.data(), u_.data(),
                                   finest.f.data());
    });
  }
  /// Largest change of any node, in the last step or the last correction [m].
  double change() const {
    return scale_ * std::max(*std::ranges::max_element(sums_), *std::ranges::max_element(largest_));
  }

private:
  ComponentwiseMultigrid& multigrid_;
  PaddedArray& direction_;
  std::span<double> u_;
  double scale_;
  std::vector<double> sums_, largest_; ///< per plane
};

/// Watches one round, after which the residual is recomputed.
class ComponentwiseSolver::Watch : public GradientWatch {
public:
  Watch(const Correction& correction, SolveOutcome& outcome, double tolerance,
        const std::function<bool()>& must_stop)
      : correction_(correction), outcome_(outcome), tolerance_(tolerance), must_stop_(must_stop) {}

  bool should_continue() override {
    outcome_.was_stopped = must_stop_ && must_stop_();
    return !outcome_.was_stopped && outcome_.iterations < most_coupled_iterations;
  }
  bool should_continue_after(double, double) override {
    const double change = correction_.change();
    ++outcome_.iterations;
    first_change_ = std::max(first_change_, change);
    errors_.add(change);
    if (std::isfinite(errors_.remaining()))
      outcome_.remaining = errors_.remaining();
    is_done_ = outcome_.remaining <= tolerance_;
    return !is_done_ && change > reduction_per_residual * first_change_;
  }
  bool is_done() const { return is_done_; }
  double first_change() const { return first_change_; }

private:
  const Correction& correction_;
  SolveOutcome& outcome_;
  double tolerance_;
  const std::function<bool()>& must_stop_;
  StepErrors errors_;
  double first_change_ = 0;
  bool is_done_ = false;
};

void ComponentwiseSolver::apply(std::span<const double> u, std::span<double> forces) const {
  const ComponentwiseLevel& finest = multigrid_->finest();
  multigrid_->team().run(finest.nodes()[2],
                         [&](int z, int) { find_forces(finest, z, u.data(), unit_, forces.data()); });
  for (const auto& [node, stiffness] : finest.anchors())
    forces[node] += unit_ * stiffness * u[node];
}

/// True if fixed values and forces are far from the limits of float32.
bool ComponentwiseSolver::fits_float32() const {
  constexpr double large = 1e30;
  double largest = 0;
  for (const FixedNode& fixed : multigrid_->finest().fixed())
    largest = std::max(largest, std::abs(fixed.value));
  for (const double force : forces_)
    largest = std::max(largest, std::abs(force));
  return largest == 0 || (largest > 1 / large && largest < large);
}

/// Without forces, every displacement lies between the fixed values. Float32 may violate this where weights
/// differ extremely, and recovery from there takes many iterations.
void ComponentwiseSolver::keep_between_fixed_values(std::span<double> u) const {
  double least = 0, most = 0; // without fixed nodes all is at rest
  for (const FixedNode& fixed : multigrid_->finest().fixed()) {
    least = std::min(least, fixed.value);
    most = std::max(most, fixed.value);
  }
  const double range = most - least; // iterations correct smaller excesses
  const auto is_near = [&](double value) { return value >= least - range && value <= most + range; };
  if (std::ranges::all_of(u, is_near))
    return;
  for (double& value : u)
    value = value > least ? std::min(value, most) : least; // NaN too
}

SolveOutcome ComponentwiseSolver::solve(std::span<double> u, std::span<const double> forces, double tolerance,
                                        bool is_warm, const std::function<bool()>& must_stop) {
  forces_.assign(forces.begin(), forces.end());
  for (double& force : forces_)
    force /= unit_;
  SolveOutcome outcome;
  if (!is_warm) {
    if (fits_float32()) {
      begin_from_coarsest(u);
      if (forces_.empty())
        keep_between_fixed_values(u);
    } else { // corrections are scaled, the start is not
      std::ranges::fill(u, 0.0);
      for (const FixedNode& fixed : multigrid_->finest().fixed())
        u[fixed.node] = fixed.value;
    }
    outcome.iterations = 1;
  }
  outcome.remaining = std::numeric_limits<double>::infinity();
  double best_change = std::numeric_limits<double>::infinity();
  while (outcome.iterations < most_coupled_iterations) {
    const double scale = begin_correction(u, forces_less_springs(u));
    if (scale == 0) {
      outcome.remaining = 0;
      return outcome;
    }
    Correction correction(*this, u, scale);
    Watch watch(correction, outcome, tolerance, must_stop);
    conjugate_gradients(correction, watch);
    if (outcome.was_stopped || watch.is_done())
      return outcome;
    const double first_change = watch.first_change();
    // No progress in a whole round: the error is at rounding level.
    if (first_change >= 0.5 * best_change || first_change == 0) {
      outcome.remaining = std::min(outcome.remaining, std::max(first_change, best_change));
      outcome.was_stopped = !std::isfinite(outcome.remaining); // not a single step was possible
      return outcome;
    }
    best_change = first_change;
  }
  outcome.was_stopped = true;
  return outcome;
}

void ComponentwiseSolver::precondition(std::span<const double> residual, std::span<double> correction) {
  ComponentwiseLevel& finest = multigrid_->finest();
  double largest = 0;
  for (const double value : residual)
    largest = std::max(largest, std::abs(value));
  if (largest == 0) {
    std::ranges::fill(correction, 0.0);
    return;
  }
  const double to_level = 1 / largest, back = largest / unit_;
  load_field(
      finest, multigrid_->team(), [&](std::size_t) { return residual.data(); },
      Vec3{to_level, to_level, to_level}, finest.f.data());
  multigrid_->precondition();
  store_field(finest, multigrid_->team(), finest.u.data(), Vec3{back, back, back},
              [&](std::size_t) { return correction.data(); });
}

double ComponentwiseSolver::energy(std::span<const double> u) {
  const ComponentwiseLevel& finest = multigrid_->finest();
  return unit_ * multigrid_->sum_over_planes([&](int z) { return energy_of_plane(finest, z, u.data()); });
}

double ComponentwiseSolver::elastic_force(std::span<const double> u, std::int64_t node) const {
  const ComponentwiseLevel& finest = multigrid_->finest();
  const auto spring = finest.anchors().find(node);
  const double of_spring = spring == finest.anchors().end() ? 0 : spring->second * u[node];
  return unit_ * (force_on(finest, finest.node_at(node), u.data()) + of_spring);
}

double ComponentwiseSolver::stiffness_at(std::int64_t node) const {
  const ComponentwiseLevel& finest = multigrid_->finest();
  return unit_ * finest.diagonal(finest.node_at(node));
}

} // namespace maille::deform
