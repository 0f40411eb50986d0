#include "elastic/limits/constrained_minimum.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {
/// Newton steps: penalty over the links' own stiffness, and the reduction of the residual by conjugate
/// gradients for one direction. The multigrid of boxes converges with a high penalty; that of other bodies
/// does not.
struct Steps {
  double penalty, enough_reduction;
};
constexpr Steps of_boxes{1000, 0.03}, of_bodies{20, 0.1};
constexpr int most_per_direction = 6;
constexpr double whole_step = 0.8, short_step = 0.5, useless_step = 0.3;
constexpr int most_iterations = 20;
/// Limit on other bodies than boxes, for tolerances below `tight`: an iteration does less there.
constexpr int most_iterations_of_bodies = 200;
constexpr double tight = 1e-3;
/// From this tolerance on, images of directions and the residual may be float32.
constexpr double float32_is_enough = 1e-3;

} // namespace

/// In float32, as images are then. Loads would have to be summed up along directions, and are in float64.
bool ConstrainedMinimum::may_keep_directions() const {
  return system_.keeps_directions() && task_.scene.relaxation.tolerance >= float32_is_enough &&
         std::ranges::all_of(loads_, [](const auto& loads) { return loads.empty(); });
}

/// Towards the minimum of the quadratic model at the state, and its image. @return nothing if stopped
ConstrainedMinimum::Products ConstrainedMinimum::find_direction(Answer& answer) {
  if (keeps_directions_) {
    const auto [iterations, products] =
        system_.keep_direction(residual_, depth_, of_boxes.enough_reduction, task_.must_stop);
    answer.iterations += iterations;
    task_.team.run(static_cast<int>(links_.size()), [&](int i, int) {
      const int component = components_[static_cast<std::size_t>(i)];
      links_[static_cast<std::size_t>(i)].set_direction(
          [&](std::size_t node) { return system_.kept(component, node); });
    });
    return products;
  }
  answer.iterations += system_.find_direction(
      residual_, depth_, (is_box_ ? of_boxes : of_bodies).enough_reduction, task_.must_stop, direction_);
  if (task_.must_stop())
    return {};
  find_image();
  return sums_.sum([&](std::size_t first, std::size_t end) { // in one pass over memory
    Products sum;
    for (std::size_t k = 0; k < components_.size(); ++k)
      for (std::size_t i = first; i < end; ++i) {
        const double along = direction_(k, i);
        sum += {along * image_(k, i), along * residual_(k, i), along * along};
      }
    return sum;
  });
}

/// Steps to the minimum along the direction. @return false if the residual is at rounding level
bool ConstrainedMinimum::take_newton_step(Displacement& u, const Products& products) {
  curvature_ = products.curvature;
  if (!(curvature_ > 0))
    return false;
  slope_ = slope_of_energy(products.descent);
  length_ = best_step(slope_, curvature_);
  depth_ = length_ > whole_step   ? std::min(most_per_direction, 2 * depth_)
           : length_ < short_step ? std::max(1, depth_ / 2)
                                  : depth_;
  // Links that stop a step say nothing of how far the minimum is.
  const double before = way_;
  way_ = std::max(1.0, length_ * length_) * curvature_;
  const double ahead = length_ < short_step ? std::max(way_, before) : way_;
  // From energies to displacements, as that of the direction is.
  const double part = products.length / size_ / curvature_;
  if (keeps_directions_) {
    energy_ += length_ * (2 * slope_ + length_ * curvature_);
    system_.move_along_kept(length_, u, residual_);
    update_forces(u);
  } else
    move(u, length_);
  error_ = std::min(1.0, std::sqrt(ahead * part + Nearness::part_of_gap * gap() / energy_));
  return true;
}

ConstrainedMinimum::End ConstrainedMinimum::newton(Displacement& u, Answer& answer, int most) {
  set_penalty((is_box_ ? of_boxes : of_bodies).penalty);
  begin(u);
  depth_ = 1;
  way_ = energy_;
  const std::int64_t end = answer.iterations + most;
  while (answer.iterations < end) {
    if (task_.must_stop())
      return End::stopped;
    set_penalties(system_);
    const Products products = find_direction(answer);
    if (task_.must_stop())
      return End::stopped;
    if (!take_newton_step(u, products))
      return End::used_up;
    if (error_ <= task_.scene.relaxation.tolerance)
      return End::found;
    if (length_ > useless_step && way_ <= Nearness::part_of_gap * gap())
      improve_multipliers(u);
  }
  return End::used_up;
}

bool ConstrainedMinimum::solve(Displacement& u, Answer& answer) {
  if (!system_.finds_directions())
    return go_on_by_gradients(u, answer);
  is_box_ = is_uniform_box(task_.scene);
  keeps_directions_ = may_keep_directions();
  if (!keeps_directions_)
    make_room();
  size_ = sums_.dot(u, u);
  const bool goes_on = !is_box_ && task_.scene.relaxation.tolerance < tight;
  const End end = newton(u, answer, goes_on ? most_iterations_of_bodies : most_iterations);
  return end == End::used_up ? go_on_by_gradients(u, answer) : end == End::found;
}

} // namespace maille::deform
