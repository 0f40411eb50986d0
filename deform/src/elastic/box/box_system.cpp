#include "elastic/box/box_system.hpp"

#include "control/method.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <utility>

namespace maille::deform {

void BoxSystem::apply_to_plane(int z, const Displacement& u, Displacement& forces) {
  const std::size_t n = multigrid_.in_plane(), first = n * static_cast<std::size_t>(z);
  const double* const plane = multigrid_.forces_of_plane(u, z);
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = 0; i < n; ++i)
      forces(b, first + i) = unit_ * plane[b * n + i];
}

void BoxSystem::apply(const Displacement& u, Displacement& forces) {
  const BoxLevel& level = multigrid_.finest();
  multigrid_.team_for(level).run(level.A().nodes[2], [&](int z, int) { apply_to_plane(z, u, forces); });
}

void BoxSystem::apply_at(const std::vector<Prescribed>& prescribed, const Displacement& u,
                         Displacement& forces) {
  const BoxLevel& level = multigrid_.finest();
  std::vector<std::uint8_t> is_asked(static_cast<std::size_t>(level.A().nodes[2]), 0);
  for (const Prescribed& p : prescribed)
    is_asked[static_cast<std::size_t>(p.node) / multigrid_.in_plane()] = 1;
  multigrid_.team_for(level).run(level.A().nodes[2], [&](int z, int) {
    if (is_asked[static_cast<std::size_t>(z)] != 0)
      apply_to_plane(z, u, forces);
  });
}

void BoxSystem::set_penalties(const List<PenaltyLink>& links) {
  List<PenaltyLink> in_units = links;
  for (PenaltyLink& link : in_units)
    link.stiffness /= unit_;
  multigrid_.set_penalties(std::move(in_units));
}

/// Into the multigrid's right-hand side.
void BoxSystem::take_in(const Displacement& residual) {
  BoxLevel& level = multigrid_.finest();
  if (!(scale_ > 0))
    scale_ = largest_entry(residual) / unit_;
  if (!(scale_ > 0))
    scale_ = 1;
  const double to_level = 1 / (scale_ * unit_);
  multigrid_.team_for(level).run(level.A().nodes[2], [&](int z, int) {
    narrow_box(level.A(), z, to_level, residual.values().data(), level.f.data());
  });
}

/// x += steps.of_state p, and that in float64.
void BoxSystem::take_over(const BoxSteps& steps, const float* p, float* x, Displacement& direction) {
  BoxLevel& level = multigrid_.finest();
  multigrid_.team_for(level).run(level.A().nodes[2], [&](int z, int) {
    finish_box(level.A(), z, steps, p, level.r.data(), x, level.f.data(), scale_, false,
               direction.values().data());
  });
}

double BoxSystem::precondition(const Displacement& residual, Displacement& correction) {
  take_in(residual);
  const double product = multigrid_.precondition();
  float* const u = multigrid_.finest().u.data();
  take_over({}, u, u, correction);
  return product * scale_ * scale_ * unit_;
}

/// From a state of nothing.
BoxGradients& BoxSystem::gradients() {
  if (!gradients_)
    gradients_.emplace(multigrid_);
  gradients_->restart();
  return *gradients_;
}

int BoxSystem::find_direction(const Displacement& residual, int most, double reduction,
                              const std::function<bool()>& must_stop, Displacement& direction) {
  if (most == 1) {
    precondition(residual, direction);
    return 1;
  }
  take_in(residual);
  ReductionWatch watch(most, reduction, must_stop);
  BoxGradients& found = gradients();
  conjugate_gradients(found, watch);
  take_over(found.steps(), found.direction(), found.state(), direction);
  return watch.iterations();
}

CoupledSystem::KeptDirection BoxSystem::keep_direction(const Displacement& residual, int most,
                                                       double reduction,
                                                       const std::function<bool()>& must_stop) {
  take_in(residual);
  BoxLevel& level = multigrid_.finest();
  const BoxOperator& A = level.A();
  KeptDirection direction{1, {}};
  float *x = level.u.data(), *p = nullptr, step = 0;
  if (most == 1)
    direction.products.descent = multigrid_.precondition();
  else {
    ReductionWatch watch(most, reduction, must_stop);
    BoxGradients& found = gradients();
    conjugate_gradients(found, watch);
    direction.iterations = watch.iterations();
    direction.products.descent = watch.descent();
    x = found.state();
    p = found.direction();
    step = std::exchange(found.steps().of_state, 0.0F);
  }
  std::vector<double> length(static_cast<std::size_t>(A.nodes[2]));
  const auto curvature = multigrid_.sums();
  run_stages(multigrid_.team_for(level), A.nodes[2], 2, [&](int stage, int z) {
    const auto plane = static_cast<std::size_t>(z);
    if (stage == 0 && step != 0)
      update_box_direction(A, z, p, 0, step, p, x);
    else if (stage == 1) {
      length[plane] = dot_box(A, z, x, x);
      curvature[plane] = apply_box_and_dot(A, z, x, level.r.data(), level.scratch());
    }
  });
  kept_ = x;
  const double square = scale_ * scale_;
  direction.products.curvature = multigrid_.total() * square * unit_;
  direction.products.descent *= square * unit_;
  for (const double part : length)
    direction.products.length += part * square;
  return direction;
}

void BoxSystem::move_along_kept(double step, Displacement& u, Displacement& residual) {
  BoxLevel& level = multigrid_.finest();
  multigrid_.team_for(level).run(level.A().nodes[2], [&](int z, int) {
    move_box(level.A(), z, step * scale_, kept_, u.values().data(), -step * scale_ * unit_, level.r.data(),
             residual.values().data());
  });
}

BoxGradients::BoxGradients(BoxMultigrid& multigrid)
    : multigrid_(multigrid), state_(multigrid.finest().field_size()),
      direction_(multigrid.finest().field_size()) {}

void BoxGradients::restart() {
  std::fill_n(state_.data(), multigrid_.finest().field_size(), 0.0F);
  steps_ = {};
}

double BoxGradients::precondition() {
  return multigrid_.precondition(std::exchange(steps_.of_residual, 0.0F));
}

std::optional<double> BoxGradients::find_step(double beta, double product) {
  BoxLevel& level = multigrid_.finest();
  const BoxOperator& A = level.A();
  float *const z_field = level.u.data(), *const q = level.r.data(), *const p = direction_.data();
  const float step_before = std::exchange(steps_.of_state, 0.0F);
  const auto sums = multigrid_.sums();
  run_stages(multigrid_.team_for(level), A.nodes[2], 2, [&](int stage, int z) {
    if (stage == 0)
      update_box_direction(A, z, z_field, static_cast<float>(beta), step_before, p, state_.data());
    else
      sums[static_cast<std::size_t>(z)] =
          apply_box_and_dot(A, z, p, q, level.scratch()) + level.penalties().add(z, p, q);
  });
  const double curvature = multigrid_.total();
  return curvature > 0 ? std::optional(product / curvature) : std::nullopt;
}

void BoxGradients::take_step(double step) {
  steps_.of_state = steps_.of_residual = static_cast<float>(step);
}

} // namespace maille::deform
