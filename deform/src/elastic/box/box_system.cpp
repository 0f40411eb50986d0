#include "elastic/box/box_system.hpp"

#include "control/method.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <utility>

namespace maille::deform {

void BoxSystem::apply(const Displacement& u, Displacement& forces) {
  if (by_cells_) {
    by_cells_->apply(u, forces, multigrid_.team());
    return;
  }
  const BoxLevel& level = multigrid_.finest();
  multigrid_.team_for(level).run(level.A().nodes[2], [&](int z, int) {
    const std::size_t n = multigrid_.in_plane(), first = n * static_cast<std::size_t>(z);
    const double* const plane = multigrid_.forces_of_plane(u, z);
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < n; ++i)
        forces(b, first + i) = unit_ * plane[b * n + i];
  });
}

void BoxSystem::precondition(const Displacement& residual, Displacement& correction) {
  BoxLevel& level = multigrid_.finest();
  const double size = largest_entry(residual), to_level = size > 0 ? 1 / size : 0;
  ThreadTeam& team = multigrid_.team_for(level);
  load_field(
      level, team, [&](std::size_t c) { return residual.component(c).data(); },
      Vec3{to_level, to_level, to_level}, level.f.data());
  multigrid_.precondition();
  float* const u = level.u.data();
  team.run(level.n_planes(), [&](int z, int) {
    finish_box(level.A(), z, {}, u, level.r.data(), u, level.f.data(), size / unit_, false,
               correction.values().data());
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
      sums[z] = apply_box_and_dot(A, z, p, q, level.scratch());
  });
  const double curvature = multigrid_.total();
  return curvature > 0 ? std::optional(product / curvature) : std::nullopt;
}

void BoxGradients::take_step(double step) {
  steps_.of_state = steps_.of_residual = static_cast<float>(step);
}

} // namespace maille::deform
