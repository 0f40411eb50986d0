#include "elastic/limits/newton_optimum.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {
/// Of the penalties over the links' own stiffness.
constexpr double penalty = 1000;
/// The same for a first direction of so many iterations, where multipliers of a coarser body are at hand,
/// which are right to about this tolerance. One direction alone knows less of what is left: it has to be so
/// much nearer.
constexpr double penalty_of_attempt = 4000, tolerance_of_attempt = 1e-2, margin_of_attempt = 0.8;
constexpr int iterations_of_attempt = 2;
/// The multigrid is told anew when so many of the links that are outside were not then, or the other way
/// round.
constexpr double enough_changes = 0.01;
/// Of the residual, by conjugate gradients for one direction.
constexpr double enough_reduction = 0.03;
constexpr int most_per_direction = 6;
constexpr double whole_step = 0.8, short_step = 0.5, useless_step = 0.3;
/// The square of the error to the limits counts so much, as in the general way.
constexpr double part_of_gap = 36;
constexpr int most_iterations = 20;
/// Of bodies that are no boxes, whose iterations do less, where a tolerance below a thousandth is asked.
constexpr int most_iterations_of_bodies = 200;
constexpr double tight = 1e-3;
/// Of tolerances: images of directions are in float32 then, and the residual that they change is.
constexpr double float32_is_enough = 1e-3;

} // namespace

NewtonOptimum::NewtonOptimum(const CoupledTask& task, CoupledSystem& system)
    : CoupledOptimum(task, system, penalty) {}

void NewtonOptimum::rely_on_multipliers() {
  relies_on_multipliers_ =
      is_uniform_box(task_.scene) && task_.scene.relaxation.tolerance >= tolerance_of_attempt;
}

void NewtonOptimum::set_penalties() {
  std::size_t outside = 0, changed = 0;
  for (const ActiveLinks& links : links_)
    outside += links.n_outside(), changed += links.n_changed();
  if (has_penalties_ && static_cast<double>(changed) <= enough_changes * static_cast<double>(outside))
    return;
  penalties_.clear();
  for (ActiveLinks& links : links_)
    links.set_penalties(penalties_);
  system_.set_penalties(penalties_);
  has_penalties_ = true;
}

/// In float32, as images are then. Loads would have to be summed up along directions, and are in float64.
bool NewtonOptimum::may_keep_directions() const {
  return system_.keeps_directions() && task_.scene.relaxation.tolerance >= float32_is_enough &&
         std::ranges::all_of(loads_, [](const auto& loads) { return loads.empty(); });
}

/// Towards the minimum of the quadratic model at the state. @return nothing if stopped
NewtonOptimum::Products NewtonOptimum::keep_direction(Answer& answer) {
  const auto [iterations, products] =
      system_.keep_direction(residual_, depth_, enough_reduction, task_.must_stop);
  answer.iterations += iterations;
  task_.team.run(static_cast<int>(d()), [&](int component, int) {
    links_[static_cast<std::size_t>(component)].set_direction(
        [&](std::size_t node) { return system_.kept(component, node); });
  });
  return products;
}

/// The same as direction_, with image_ = K direction_.
NewtonOptimum::Products NewtonOptimum::find_direction(Answer& answer) {
  answer.iterations +=
      system_.find_direction(residual_, depth_, enough_reduction, task_.must_stop, direction_);
  if (task_.must_stop())
    return {};
  find_image();
  set_direction_of_links();
  return find_products();
}

/// In one pass over memory.
NewtonOptimum::Products NewtonOptimum::find_products() {
  const Grid& grid = task_.scene.specimen.grid;
  const int planes = grid.nodes()[d() - 1];
  const auto in_plane = static_cast<std::size_t>(grid.n_nodes() / planes);
  products_.assign(static_cast<std::size_t>(planes), {});
  task_.team.run(planes, [&](int plane, int) {
    const std::size_t first = in_plane * static_cast<std::size_t>(plane);
    Products sum;
    for (std::size_t b = 0; b < d(); ++b)
      for (std::size_t i = first; i < first + in_plane; ++i) {
        const double along = direction_.component[b][i];
        sum.curvature += along * image_.component[b][i];
        sum.descent += along * residual_.component[b][i];
        sum.length += along * along;
      }
    products_[static_cast<std::size_t>(plane)] = sum;
  });
  Products sum;
  for (const Products& part : products_) {
    sum.curvature += part.curvature;
    sum.descent += part.descent;
    sum.length += part.length;
  }
  return sum;
}

void NewtonOptimum::move(Displacement& u, double slope, double curvature) {
  if (!keeps_directions_) {
    CoupledOptimum::move(u, length_, slope, curvature);
    return;
  }
  energy_ += length_ * (2 * slope + length_ * curvature);
  system_.move_along_kept(length_, u, residual_);
  update_forces(u);
}

/// To the minimum along the direction. @return false if nothing is left that can be told from rounding
bool NewtonOptimum::take_step(Displacement& u, const Products& products) {
  const double curvature = products.curvature;
  if (!(curvature > 0))
    return false;
  const double slope = slope_of_energy(products.descent);
  length_ = best_step(slope, curvature);
  depth_ = length_ > whole_step   ? std::min(most_per_direction, 2 * depth_)
           : length_ < short_step ? std::max(1, depth_ / 2)
                                  : depth_;
  // Links that stop a step say nothing of how far the minimum is.
  const double before = way_;
  way_ = std::max(1.0, length_ * length_) * curvature;
  const double ahead = length_ < short_step ? std::max(way_, before) : way_;
  // From energies to displacements, as that of the direction is.
  const double part = products.length / size_ / curvature;
  move(u, slope, curvature);
  error_ = std::min(1.0, std::sqrt(ahead * part + part_of_gap * gap() / energy_));
  return true;
}

/// One direction. @return whether the state is near enough after it
bool NewtonOptimum::attempt(Displacement& u, Answer& answer) {
  set_penalty(penalty_of_attempt);
  begin(u);
  set_penalties();
  depth_ = iterations_of_attempt;
  way_ = 0;
  const Products products = keeps_directions_ ? keep_direction(answer) : find_direction(answer);
  return !task_.must_stop() && take_step(u, products) &&
         error_ <= margin_of_attempt * task_.scene.relaxation.tolerance;
}

NewtonOptimum::End NewtonOptimum::iterate(Displacement& u, Answer& answer, int most) {
  set_penalty(penalty);
  begin(u);
  has_penalties_ = false;
  depth_ = 1;
  way_ = energy_;
  const std::int64_t end = answer.iterations + most;
  while (answer.iterations < end) {
    if (task_.must_stop())
      return End::stopped;
    set_penalties();
    const Products products = keeps_directions_ ? keep_direction(answer) : find_direction(answer);
    if (task_.must_stop())
      return End::stopped;
    if (!take_step(u, products))
      return End::used_up;
    if (error_ <= task_.scene.relaxation.tolerance)
      return End::found;
    if (length_ > useless_step && way_ <= part_of_gap * gap()) {
      for (ActiveLinks& links : links_)
        links.update_multipliers();
      update_forces_of_known(u);
    }
  }
  return End::used_up;
}

void NewtonOptimum::set_penalty(double rho) {
  for (ActiveLinks& links : links_)
    links.set_penalty(rho);
}

bool NewtonOptimum::solve(Displacement& u, Answer& answer) {
  keeps_directions_ = may_keep_directions();
  if (!keeps_directions_)
    make_room();
  size_ = dot(u, u);
  if (relies_on_multipliers_ && attempt(u, answer))
    return true;
  const bool goes_on = !is_uniform_box(task_.scene) && task_.scene.relaxation.tolerance < tight;
  const End end = iterate(u, answer, goes_on ? most_iterations_of_bodies : most_iterations);
  if (end != End::used_up)
    return end == End::found;
  set_penalty(general_penalty);
  return CoupledOptimum::solve(u, answer);
}

std::int64_t NewtonOptimum::bytes() const {
  return CoupledOptimum::bytes() + static_cast<std::int64_t>(products_.capacity() * sizeof(Products)) +
         static_cast<std::int64_t>(penalties_.capacity() * sizeof(PenaltyLink));
}

std::unique_ptr<CoupledOptimum> make_optimum(const CoupledTask& task, CoupledSystem& system) {
  if (system.has_multigrid())
    return std::make_unique<NewtonOptimum>(task, system);
  return std::make_unique<CoupledOptimum>(task, system);
}

} // namespace maille::deform
