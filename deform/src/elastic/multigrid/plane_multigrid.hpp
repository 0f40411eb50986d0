#pragma once
/// Multigrid plane by plane: a plane goes through all steps of one leg of the cycle while it is in the cache.

#include "elastic/multigrid/multigrid.hpp"

namespace maille::deform {

/// A level that go_down_planes() and come_up_planes() can process. z is a plane; u, f, r are fields of the
/// level.
template<class L>
concept PlaneLevel = requires(L& level, const L& coarser, const L& of, int z, float weight, float step,
                              const float* from, float* to, bool replaces) {
  { of.n_planes() } -> std::same_as<int>;
  { of.relaxation() } -> std::same_as<const std::vector<float>&>; ///< the weights of Jacobi's steps
  level.start(z, weight, step, to);                               ///< f -= step r, and a Jacobi step from 0
  of.relax(z, weight, from, to);
  level.find_residual(z);                          ///< r = f - A u
  of.restrict_to(coarser, z, from, to);            ///< plane z of the coarser one
  of.prolong_from(coarser, z, from, replaces, to); ///< or adds
  { of.dot(z, from, from) } -> std::same_as<double>;
  of.coarse_planes_after(z); ///< coarse planes whose restriction is complete after plane z
};

/// Relaxation alternates between u and r, and ends in u.
template<PlaneLevel Level>
void go_down_planes(Level& fine, Level& coarse, ThreadTeam& team, CycleStart start) {
  const std::vector<float>& weights = fine.relaxation();
  const int steps = static_cast<int>(weights.size()), ahead = start.from_coarser ? 1 : 0;
  const auto after = [&](int number) {
    return (steps - 1 - number) % 2 == 0 ? fine.u.data() : fine.r.data();
  };
  run_stages(team, fine.n_planes(), steps + 2 + ahead, [&](int stage, int z) {
    const int step = stage - ahead;
    if (step < 0)
      fine.prolong_from(coarse, z, coarse.u.data(), true, after(-1));
    else if (step == 0 && !start.from_coarser)
      fine.start(z, weights[0], start.step, after(0)); // does not change r, which other planes still need
    else if (step < steps)
      fine.relax(z, weights[step], after(step - 1), after(step));
    else if (step == steps)
      fine.find_residual(z);
    else
      for (const int z_coarse : fine.coarse_planes_after(z))
        fine.restrict_to(coarse, z_coarse, fine.r.data(), coarse.f.data());
  });
}

template<PlaneLevel Level>
void come_up_planes(Level& fine, const Level& coarse, ThreadTeam& team, double* products) {
  const std::vector<float>& weights = fine.relaxation();
  const int steps = static_cast<int>(weights.size());
  float *const u = fine.u.data(), *const r = fine.r.data();
  const auto after = [&](int number) { return number % 2 == 0 ? u : r; };
  run_stages(team, fine.n_planes(), steps + (products == nullptr ? 1 : 2), [&](int stage, int z) {
    if (stage == 0)
      fine.prolong_from(coarse, z, coarse.u.data(), false, u);
    else if (stage <= steps)
      fine.relax(z, weights[steps - stage], after(stage - 1), after(stage));
    else
      products[z] = fine.dot(z, after(steps), fine.f.data());
  });
  if (steps % 2 != 0)
    std::swap(fine.u, fine.r);
}

/// A hierarchy in which each level makes the next. A level says whether it is the last: is_small(), or
/// is_thin(nodes of the finest) where coarser levels would not help.
template<PlaneLevel Level>
class PlaneMultigrid : public Multigrid<Level> {
public:
  PlaneMultigrid(std::unique_ptr<Level> finest, ThreadTeam& team) : Multigrid<Level>(team) {
    this->levels_.push_back(std::move(finest));
    bool is_factored = false;
    while (!is_factored && !this->levels_.back()->is_small()) {
      is_factored = this->levels_.back()->is_thin(this->level(0).n_nodes()) && this->factor_coarsest();
      std::unique_ptr<Level> next = is_factored ? nullptr : this->levels_.back()->coarser();
      if (next == nullptr)
        break;
      this->levels_.push_back(std::move(next));
    }
    if (!is_factored)
      this->factor_coarsest();
    sums_.resize(finest_planes());
  }

  Level& finest() { return this->level(0); }
  const Level& finest() const { return this->level(0); }
  /// finest().f -= step finest().r; then finest().u = one cycle for A u = finest().f, started at 0. Changes
  /// finest().r. @return u . f
  double precondition(float step = 0) {
    for (int z = 0; this->n_levels() == 1 && z < finest_planes(); ++z)
      finest().start(z, 0, step, finest().u.data());
    this->cycle(0, {.step = step}, sums_.data());
    if (this->n_levels() > 1) // summed up on the way
      return total();
    return sum_over_planes([&](int z) { return finest().dot(z, finest().u.data(), finest().f.data()); });
  }
  /// Calls work(z) for all planes of the finest level. @return the sum of what it returns
  template<class Work>
  double sum_over_planes(Work&& work) {
    this->team_for(finest()).run(finest_planes(), [&](int z, int) { sums_[z] = work(z); });
    return total();
  }
  /// The sum of sums(), in the order of planes.
  double total() const { return std::accumulate(sums_.begin(), sums_.end(), 0.0); }
  std::span<double> sums() { return sums_; }

private:
  int finest_planes() const { return finest().n_planes(); }

  std::vector<double> sums_;
};

} // namespace maille::deform
