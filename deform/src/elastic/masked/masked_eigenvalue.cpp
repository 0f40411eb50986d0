#include "elastic/krylov/chebyshev.hpp"
#include "elastic/masked/masked_multigrid.hpp"

#include <cmath>

namespace maille::deform {

namespace {

constexpr std::size_t steps_for_eigenvalue = 10;
constexpr double safety_of_eigenvalue = 1.05;

/// -1 or 1, the same on every machine.
float noise(std::size_t i) {
  auto mixed = static_cast<std::uint32_t>(i) + 1;
  mixed = (mixed ^ mixed >> 16) * 0x85ebca6bu;
  mixed = (mixed ^ mixed >> 13) * 0xc2b2ae35u;
  return (mixed ^ mixed >> 16) & 1 ? 1.0f : -1.0f;
}

} // namespace

/// Of the finest level, preconditioned by its diagonal: u is the direction, f the residual. The state is not
/// kept.
class MaskedMultigrid::FinestDirections : public GradientSpace {
public:
  explicit FinestDirections(MaskedMultigrid& all) : all_(all), inverse_(all.finest_->inverse()) {}
  double precondition() override {
    return all_.sum_over_parts([&](std::int64_t first, std::int64_t n) {
      start_entries(n, 1, inverse_ + first, all_.f.data() + first, all_.r.data() + first);
      return dot_entries(n, all_.f.data() + first, all_.r.data() + first);
    });
  }
  std::optional<double> find_step(double beta, double product) override {
    for_each_part([&](std::int64_t first, std::int64_t n) {
      direct_entries(n, all_.r.data() + first, static_cast<float>(beta), all_.u.data() + first);
    });
    all_.finest_->apply(all_.u.data(), all_.r.data(), all_.team_);
    return product / all_.sum_over_parts([&](std::int64_t first, std::int64_t n) {
      return mask_and_dot_entries(n, inverse_ + first, all_.u.data() + first, all_.r.data() + first);
    });
  }
  void take_step(double step) override {
    for_each_part([&](std::int64_t first, std::int64_t n) {
      step_entries(n, static_cast<float>(step), all_.r.data() + first, all_.f.data() + first);
    });
  }

private:
  template<class Work>
  void for_each_part(const Work& work) {
    all_.finest_->for_each_part(all_.team_, [&](std::int64_t first, std::int64_t n, int) { work(first, n); });
  }

  MaskedMultigrid& all_;
  const float* inverse_;
};

/// The same of a coarser one.
class MaskedMultigrid::CoarserDirections : public GradientSpace {
public:
  CoarserDirections(MaskedMultigrid& all, Level& level) : all_(all), level_(level) {}
  double precondition() override {
    double product = 0;
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      product += double{level_.f[i]} * double{level_.f[i]} * double{level_.inverse[i]};
    return product;
  }
  std::optional<double> find_step(double beta, double product) override {
    const auto weight = static_cast<float>(beta);
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      level_.u[i] = level_.inverse[i] * level_.f[i] + weight * level_.u[i];
    all_.for_rows(level_.n(), [&](std::int32_t first, std::int32_t end) {
      apply_blocks(level_.A, first, end, level_.u.data(), level_.r.data());
    });
    double curvature = 0;
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      curvature += level_.inverse[i] > 0 ? double{level_.u[i]} * double{level_.r[i]} : 0;
    return product / curvature;
  }
  void take_step(double step) override {
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      level_.f[i] -= level_.inverse[i] > 0 ? static_cast<float>(step) * level_.r[i] : 0;
  }

private:
  MaskedMultigrid& all_;
  Level& level_;
};

/// Of inverse diagonal times operator, from a few steps of conjugate gradients for a noisy right-hand side.
double MaskedMultigrid::largest_eigenvalue() {
  const float* const inverse = finest_->inverse();
  for (std::size_t i = 0; i < static_cast<std::size_t>(finest_->field_size()); ++i)
    f[i] = inverse[i] > 0 ? noise(i) / std::sqrt(inverse[i]) : 0;
  FinestDirections directions(*this);
  RitzValues values(steps_for_eigenvalue);
  conjugate_gradients(directions, values);
  return safety_of_eigenvalue * values.largest();
}

double MaskedMultigrid::largest_eigenvalue(Level& level) {
  for (std::size_t i = 0; i < level.u.size(); ++i)
    level.f[i] = level.inverse[i] > 0 ? noise(i) / std::sqrt(level.inverse[i]) : 0;
  CoarserDirections directions(*this, level);
  RitzValues values(steps_for_eigenvalue);
  conjugate_gradients(directions, values);
  return safety_of_eigenvalue * values.largest();
}

} // namespace maille::deform
