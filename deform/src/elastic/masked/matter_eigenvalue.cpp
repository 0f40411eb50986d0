#include "elastic/krylov/chebyshev.hpp"
#include "elastic/masked/matter_multigrid.hpp"

#include <cmath>

namespace maille::deform {

namespace {

constexpr int steps_for_eigenvalue = 10;
constexpr double safety_of_eigenvalue = 1.05;

/// -1 or 1, the same on every machine.
float noise(std::size_t i) {
  auto mixed = static_cast<std::uint32_t>(i) + 1;
  mixed = (mixed ^ mixed >> 16) * 0x85ebca6bu;
  mixed = (mixed ^ mixed >> 13) * 0xc2b2ae35u;
  return (mixed ^ mixed >> 16) & 1 ? 1.0f : -1.0f;
}

} // namespace

/// Of inverse diagonal times operator, from a few steps of conjugate gradients for a noisy right-hand side: u
/// is the direction, f the residual.
double MatterMultigrid::largest_eigenvalue() {
  const float* const inverse = finest_->inverse();
  const auto size = static_cast<std::size_t>(finest_->field_size());
  for (std::size_t i = 0; i < size; ++i)
    f[i] = inverse[i] > 0 ? noise(i) / std::sqrt(inverse[i]) : 0;
  RitzValues values;
  double last = 0;
  for (int k = 0; k < steps_for_eigenvalue; ++k) {
    const double now = sum_over_parts([&](std::int64_t first, std::int64_t n) {
      start_entries(n, 1, inverse + first, f.data() + first, r.data() + first);
      return dot_entries(n, f.data() + first, r.data() + first);
    });
    if (!(now > 0))
      break;
    finest_->for_each_part(team_, [&](std::int64_t first, std::int64_t n, int) {
      direct_entries(n, r.data() + first, static_cast<float>(k > 0 ? now / last : 0), u.data() + first);
    });
    finest_->apply(u.data(), r.data(), team_);
    const double curvature = sum_over_parts([&](std::int64_t first, std::int64_t n) {
      return mask_and_dot_entries(n, inverse + first, u.data() + first, r.data() + first);
    });
    const double step = now / curvature;
    finest_->for_each_part(team_, [&](std::int64_t first, std::int64_t n, int) {
      step_entries(n, static_cast<float>(step), r.data() + first, f.data() + first);
    });
    values.add(step, k > 0 ? now / last : 0);
    last = now;
  }
  return safety_of_eigenvalue * values.largest();
}

double MatterMultigrid::largest_eigenvalue(Level& level) {
  const std::size_t size = level.u.size();
  for (std::size_t i = 0; i < size; ++i)
    level.f[i] = level.inverse[i] > 0 ? noise(i) / std::sqrt(level.inverse[i]) : 0;
  RitzValues values;
  double last = 0;
  for (int k = 0; k < steps_for_eigenvalue; ++k) {
    double now = 0, curvature = 0;
    for (std::size_t i = 0; i < size; ++i)
      now += double{level.f[i]} * double{level.f[i]} * double{level.inverse[i]};
    if (!(now > 0))
      break;
    const auto beta = static_cast<float>(k > 0 ? now / last : 0);
    for (std::size_t i = 0; i < size; ++i)
      level.u[i] = level.inverse[i] * level.f[i] + beta * level.u[i];
    for_rows(level.n(), [&](std::int32_t first, std::int32_t end) {
      apply_blocks(level.A, first, end, level.u.data(), level.r.data());
    });
    for (std::size_t i = 0; i < size; ++i)
      curvature += level.inverse[i] > 0 ? double{level.u[i]} * double{level.r[i]} : 0;
    const double step = now / curvature;
    for (std::size_t i = 0; i < size; ++i)
      level.f[i] -= level.inverse[i] > 0 ? static_cast<float>(step) * level.r[i] : 0;
    values.add(step, k > 0 ? now / last : 0);
    last = now;
  }
  return safety_of_eigenvalue * values.largest();
}

} // namespace maille::deform
