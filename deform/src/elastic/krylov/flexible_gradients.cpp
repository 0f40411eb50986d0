#include "elastic/krylov/flexible_gradients.hpp"

#include "elastic/model/lattice_elasticity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

namespace maille::deform {

FlexibleGradients::FlexibleGradients(const CoupledTask& task)
    : FlexibleGradients(task, loads_of(task.scene), FixedMask(task.scene.specimen, task.prescribed)) {}

FlexibleGradients::FlexibleGradients(const CoupledTask& task, Loads forces, FixedMask fixed)
    : FieldGradients(static_cast<std::size_t>(task.scene.dimension()), std::move(fixed), FieldSums(task)),
      task_(task), forces_(std::move(forces)), convergence_(task.scene.relaxation.tolerance) {}

/// The energy and the length of u too.
void FlexibleGradients::find_residual() {
  energy_ = FieldGradients::find_residual(forces_);
  length_ = sums_.dot(*u_, *u_);
}

/// Updates energy and lengths too.
void FlexibleGradients::take_step(double step) {
  energy_ += 2 * step * work_of(forces_);
  FieldGradients::take_step(step);
  moved_ = step * step * sums_.dot(direction_, direction_);
  length_ = sums_.dot(*u_, *u_);
}

/// r . B r of a residual that is pure rounding: each entry is that of its diagonal's product, eps |K_ii u_i|,
/// with pseudo-random signs. Uses image_.
double FlexibleGradients::product_of_rounding() {
  const Displacement& u = *u_;
  if (diagonal_.empty())
    diagonal_ = LatticeElasticity(task_.scene, task_.team).diagonal();
  sums_.sum([&](std::size_t first, std::size_t end) {
    for (std::size_t b = 0; b < u.n_components(); ++b)
      for (std::size_t i = first; i < end; ++i) {
        const std::uint64_t mixed = (3 * i + b + 1) * 0x9e3779b97f4a7c15u;
        const double size = std::numeric_limits<double>::epsilon() * diagonal_(b, i) * std::abs(u(b, i));
        image_(b, i) = fixed_(b, i) ? 0 : (mixed >> 40) % 2 == 0 ? size : -size;
      }
    return 0.0;
  });
  K_->precondition(image_, correction_);
  const double product = sums_.dot(image_, correction_);
  K_->precondition(residual_, correction_);
  return product;
}

void FlexibleGradients::end(Convergence::End end) {
  answer_->residual = convergence_.residual();
  end_ = end == Convergence::End::converged ? CoupledRound::finished : CoupledRound::stalled;
  if (end == Convergence::End::diverged)
    problem_ = "conjugate gradients diverged: the residual is not finite";
  if (end == Convergence::End::stagnated)
    problem_ =
        "conjugate gradients stagnated: the error no longer falls; the moduli or the sizes of the cells "
        "differ by more than float64 resolves";
}

bool FlexibleGradients::should_continue() {
  end_ = CoupledRound::stopped;
  if (answer_->iterations >= last_iteration_ || task_.must_stop())
    return false;
  task_.show_progress(answer_->residual);
  return true;
}

bool FlexibleGradients::should_continue_from(double product) {
  const auto verdict =
      convergence_.judge(product, state(), answer_->iterations, [this] { return product_of_rounding(); });
  if (verdict)
    end(*verdict);
  return !verdict;
}

std::optional<double> FlexibleGradients::find_step(double beta, double product) {
  const std::optional<double> step = FieldGradients::find_step(beta, product);
  if (!step)
    end(convergence_.without_descent(product, energy_, [this] { return product_of_rounding(); }));
  return step;
}

bool FlexibleGradients::should_continue_after(double step, double product) {
  energy_ -= step * step * curvature_;
  ++answer_->iterations;
  convergence_.add(step, product);
  if (convergence_.should_recompute(state(), answer_->iterations))
    find_residual();
  answer_->residual = convergence_.residual();
  return true;
}

CoupledRound FlexibleGradients::solve(ElasticOperator& K, Displacement& u, Answer& answer) {
  begin(K, u);
  answer_ = &answer;
  last_iteration_ = answer.iterations + most_coupled_iterations;
  convergence_.begin();
  find_residual();
  answer.residual = 1;
  conjugate_gradients(*this, *this);
  return end_;
}

void FlexibleGradients::find_energy_and_reactions(ElasticOperator& K, const Displacement& u, Answer& answer) {
  K.apply(u, image_);
  answer.strain_energy = 0.5 * sums_.dot(u, image_) - energy_of_springs(nodal_springs(task_.scene), u);
  answer.reaction = reactions_of(task_.scene, forces_, image_);
}

bool FlexibleGradients::finish(ElasticOperator& K, Answer& answer) {
  const CoupledRound end = solve(K, answer.displacement, answer);
  if (end == CoupledRound::stalled) {
    answer.status = Status::failed;
    answer.message = problem_;
    answer.displacement = {};
    return false;
  }
  const bool is_converged = end == CoupledRound::finished;
  find_energy_and_reactions(K, answer.displacement, answer);
  if (!is_converged)
    answer.reaction.clear();
  return is_converged;
}

} // namespace maille::deform
