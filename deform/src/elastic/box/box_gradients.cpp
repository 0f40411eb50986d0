#include "elastic/box/box_gradients.hpp"

#include "parallel/thread_team.hpp"

#include <algorithm>
#include <utility>

namespace maille::deform {

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
