#include "elastic/krylov/flexible_gradients.hpp"

#include "elastic/model/lattice_elasticity.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

namespace maille::deform {

namespace {

/// Give up after this many iterations without a better residual.
constexpr std::int64_t patience = 1000;
/// Compare the residual with its rounding after this many iterations without a better one, and again after
/// as many.
constexpr std::int64_t steps_between_doubts = 10;
/// Residuals that are carried along drift away from the true ones by rounding.
constexpr int steps_between_residuals = 50;
/// Share of the tolerance that the estimate must reach: slender bodies converge in leaps, and the remaining
/// error may lie along a soft direction.
constexpr double share_of_tolerance = 1.0 / 3;

} // namespace

FlexibleGradients::FlexibleGradients(const CoupledTask& task)
    : FlexibleGradients(task, loads_of(task.scene), FixedMask(task.scene.specimen, task.prescribed)) {}

FlexibleGradients::FlexibleGradients(const CoupledTask& task, Loads forces, FixedMask fixed)
    : FieldGradients(static_cast<std::size_t>(task.scene.dimension()), std::move(fixed), FieldSums(task)),
      task_(task), forces_(std::move(forces)) {}

/// residual = f - K u where nodes are free, 0 elsewhere; the energy and the length of u too.
void FlexibleGradients::find_residual() {
  const Displacement& u = *u_;
  K_->apply(u, image_);
  energy_ = sums_.dot(u, image_);
  length_ = sums_.dot(u, u);
  sums_.sum([&](std::size_t first, std::size_t end) {
    for (std::size_t b = 0; b < residual_.n_components(); ++b)
      for (std::size_t i = first; i < end; ++i)
        residual_(b, i) = fixed_(b, i) ? 0 : (forces_[b].empty() ? 0 : forces_[b][i]) - image_(b, i);
    return 0.0;
  });
}

/// Updates energy and lengths too.
void FlexibleGradients::take_step(double step) {
  double with_forces = 0;
  for (std::size_t b = 0; b < forces_.size(); ++b)
    for (std::size_t i = 0; i < forces_[b].size(); ++i)
      with_forces += forces_[b][i] * direction_(b, i);
  energy_ += 2 * step * with_forces;
  FieldGradients::take_step(step);
  moved_ = step * step * sums_.dot(direction_, direction_);
  length_ = sums_.dot(*u_, *u_);
}

/// The larger of the error in the energy norm and that of the displacement, if steps go on shrinking as the
/// residual does.
double FlexibleGradients::estimate(double energy_of_error) const {
  const double rate = std::sqrt(error_.rate());
  const double of_displacement =
      rate < 1 && length_ > 0 ? std::sqrt(moved_ / length_) * rate / (1 - rate) : 1;
  return std::min(1.0, std::max(energy_of_error, of_displacement));
}

/// r . B r of a residual that is pure rounding: each entry is that of its diagonal's product, eps |K_ii u_i|,
/// with pseudo-random signs. Uses image_ and correction_.
double FlexibleGradients::left_by_rounding() {
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
  return sums_.dot(image_, correction_);
}

bool FlexibleGradients::is_at_rounding(double left) {
  constexpr double margin =
      100; // ten times in the energy norm: sums over a node's neighbours round more than once
  return is_left_by_rounding(left, std::max(energy_, first_error_)) &&
         std::abs(left) <= margin * left_by_rounding();
}

void FlexibleGradients::end_at_rounding(double left) {
  answer_->residual = error_.of_residual(left, std::max(energy_, first_error_));
  end_ = CoupledRound::finished;
}

/// No descent direction: the residual is at rounding level, or the solve has stagnated.
void FlexibleGradients::stall(double left) {
  if (left == 0 || is_at_rounding(left)) {
    end_at_rounding(left);
    return;
  }
  problem_ = "conjugate gradients came to no end: the error does not fall any more; the moduli or the sizes "
             "of the cells differ by more than float64 can tell";
  end_ = CoupledRound::stalled;
}

bool FlexibleGradients::is_stuck(double left) {
  if (best_ == 0 || left < 0.9 * best_) {
    best_ = left;
    best_at_ = answer_->iterations;
  }
  return answer_->iterations - best_at_ > patience;
}

bool FlexibleGradients::goes_on() {
  end_ = CoupledRound::stopped;
  if (answer_->iterations >= last_iteration_ || task_.must_stop())
    return false;
  if (task_.control.progress)
    task_.control.progress(std::min(0.99, static_cast<double>(answer_->iterations) / 30), "solving");
  return true;
}

bool FlexibleGradients::goes_on_from(double product) {
  if (!std::isfinite(product) || !std::isfinite(energy_)) {
    problem_ = "conjugate gradients diverged: the residual is not finite";
    end_ = CoupledRound::stalled;
    return false;
  }
  first_error_ = std::max(first_error_, product);
  if (is_to_check_) {
    answer_->residual = estimate(error_.of_residual(product, energy_));
    if (answer_->residual <= share_of_tolerance * task_.scene.relaxation.tolerance) {
      end_ = CoupledRound::finished;
      return false;
    }
  }
  if (!(product > 0) || is_stuck(product)) {
    stall(product);
    return false;
  }
  const std::int64_t in_doubt = answer_->iterations - best_at_;
  if (in_doubt > 0 && in_doubt % steps_between_doubts == 0) {
    if (is_at_rounding(product)) {
      end_at_rounding(product);
      return false;
    }
    K_->precondition(residual_, correction_);
  }
  return true;
}

std::optional<double> FlexibleGradients::find_step(double beta, double product) {
  const std::optional<double> step = FieldGradients::find_step(beta, product);
  if (!step)
    stall(product);
  return step;
}

bool FlexibleGradients::goes_on_after(double step, double product) {
  energy_ -= step * step * curvature_;
  ++answer_->iterations;
  error_.add(step, product);
  answer_->residual = estimate(error_.relative_to(energy_));
  is_to_check_ = answer_->residual <= share_of_tolerance * task_.scene.relaxation.tolerance;
  if (is_to_check_ || answer_->iterations % steps_between_residuals == 0)
    find_residual();
  return true;
}

CoupledRound FlexibleGradients::solve(ElasticOperator& K, Displacement& u, Answer& answer) {
  begin(K, u);
  answer_ = &answer;
  last_iteration_ = answer.iterations + most_coupled_iterations;
  is_to_check_ = false;
  find_residual();
  answer.residual = 1;
  conjugate_gradients(*this, *this);
  return end_;
}

void FlexibleGradients::find_energy_and_reactions(ElasticOperator& K, const Displacement& u, Answer& answer) {
  K.apply(u, image_);
  answer.strain_energy = 0.5 * sums_.dot(u, image_) - energy_of_springs(nodal_springs(task_.scene), u);
  answer.reaction.clear();
  for (const Prescribed& p : task_.scene.prescribed) {
    const auto b = static_cast<std::size_t>(p.component), i = static_cast<std::size_t>(p.node);
    answer.reaction.push_back(image_(b, i) - (forces_[b].empty() ? 0 : forces_[b][i]));
  }
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
