#pragma once
/// Conjugate gradients on one multigrid level, preconditioned by its diagonal: they tell the level's largest
/// eigenvalue (see largest_eigenvalue_seen_by).
///
/// The level's fields are used: u is the direction, f the residual, r the correction and then A u. The state
/// is not stored.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/masked/masked_kernel.hpp"

#include <cstdint>
#include <optional>

namespace maille::deform {

template<class Level>
class DiagonalGradients : public GradientSpace {
public:
  DiagonalGradients(Level& level, ThreadTeam& team) : level_(level), team_(team) {}
  double precondition() override {
    level_.for_each_part(team_, [&](std::int64_t first, std::int64_t n) {
      start_entries(n, 1, level_.inverse() + first, level_.f.data() + first, level_.r.data() + first);
    });
    return level_.dot(level_.f.data(), level_.r.data(), team_);
  }
  std::optional<double> find_step(double beta, double product) override {
    level_.for_each_part(team_, [&](std::int64_t first, std::int64_t n) {
      direct_entries(n, level_.r.data() + first, static_cast<float>(beta), level_.u.data() + first);
    });
    level_.exchange_borders(level_.u);
    return product / level_.apply_and_dot(level_.u.data(), level_.r.data(), team_);
  }
  void take_step(double step) override {
    level_.for_each_part(team_, [&](std::int64_t first, std::int64_t n) {
      step_entries(n, static_cast<float>(step), level_.r.data() + first, level_.f.data() + first);
    });
  }

private:
  Level& level_;
  ThreadTeam& team_;
};

} // namespace maille::deform
