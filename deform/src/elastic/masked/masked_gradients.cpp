#include "elastic/masked/masked_gradients.hpp"

#include <algorithm>

namespace maille::deform {

MaskedGradients::MaskedGradients(MaskedMultigrid& multigrid, ThreadTeam& team)
    : multigrid_(multigrid), team_(team), state_(multigrid.finest().field()),
      direction_(multigrid.finest().field()) {}

void MaskedGradients::restart() {
  std::ranges::fill(state_.all(), 0.0F);
}

std::optional<double> MaskedGradients::find_step(double beta, double product) {
  const MaskedLevel& level = multigrid_.finest();
  float *const p = direction_.data(), *const q = multigrid_.finest().r.data();
  level.for_each_part(team_, [&](std::int64_t at, std::int64_t n, int) {
    direct_entries(n, multigrid_.finest().u.data() + at, static_cast<float>(beta), p + at);
  });
  level.apply(p, q, team_);
  const double curvature = multigrid_.sum_over_parts([&](std::int64_t at, std::int64_t n) {
    return mask_and_dot_entries(n, level.inverse() + at, p + at, q + at);
  });
  return curvature > 0 ? std::optional(product / curvature) : std::nullopt;
}

void MaskedGradients::take_step(double step) {
  const auto length = static_cast<float>(step);
  multigrid_.finest().for_each_part(team_, [&](std::int64_t at, std::int64_t n, int) {
    step_entries(n, -length, direction_.data() + at, state_.data() + at);
    step_entries(n, length, multigrid_.finest().r.data() + at, multigrid_.finest().f.data() + at);
  });
}

} // namespace maille::deform
