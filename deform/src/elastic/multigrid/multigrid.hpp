#pragma once
/// Multigrid: the V-cycle over the levels of any kind of body, as a preconditioner.
///
/// A symmetric V-cycle: Jacobi steps with Chebyshev's weights before and after coarser levels, and a direct
/// solve at the bottom. Started at 0 it is a symmetric positive definite map, as conjugate gradients require.
/// Same bits for any number of threads.
///
/// Source  docs/theory.md, sections 2 and 3; Trottenberg, Oosterlee and Schueller, Multigrid, 2001

#include "elastic/multigrid/coarsest_solve.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <concepts>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

namespace maille::deform {

/// Axes whose links have at least this share of the strongest ones' stiffness are coarsened: relaxation
/// smooths along those only (docs/theory.md, section 2).
inline constexpr double share_of_strongest = 0.35;

/// The start of relaxation on a level.
struct CycleStart {
  bool from_coarser = false; ///< at the interpolated u of the next coarser level; else at 0
  float step = 0;            ///< f -= step r comes first
};

/// A level that may be the last one, with fields u and f of its own: its unknowns and its matrix.
template<class L>
concept CoarsestLevel = requires(const L& of, const CoarsestSolve& coarsest,
                                 const CoarsestSolve::Visit& visit) {
  { of.unknowns() } -> std::same_as<CoarsestSolve::Unknowns>;
  of.for_each_entry(coarsest.unknowns(), visit);
};

/// A level of a V-cycle, whose fields u, f and r are its own.
template<class L>
concept CycleLevel = CoarsestLevel<L> &&
    requires(L& level, L& coarser, const L& of, ThreadTeam& team, CycleStart start, double* products) {
  /// u = some steps of relaxation for A u = f; coarser.f = the restricted residual.
  level.go_down(coarser, team, start);
  /// u += interpolation of coarser.u, and the steps in reverse order.
  /// @param products of u and f by plane, or null
  level.come_up(coarser, team, products);
  { of.n_nodes() } -> std::convertible_to<std::int64_t>;
  { L::nodes_worth_threads } -> std::convertible_to<std::int64_t>; ///< threads do not pay on fewer
};

template<class Level>
class Multigrid {
public:
  /// @param team outlives this
  explicit Multigrid(ThreadTeam& team) : team_(team) { static_assert(CoarsestLevel<Level>); }

  std::size_t n_levels() const { return levels_.size(); }
  Level& level(std::size_t i) { return *levels_[i]; }
  const Level& level(std::size_t i) const { return *levels_[i]; }
  /// level(i).u = one cycle for A u = level(i).f.
  void cycle(std::size_t i, CycleStart start = {}, double* products = nullptr) requires CycleLevel<Level> {
    if (i + 1 == n_levels())
      return solve_coarsest();
    Level& here = level(i);
    here.go_down(level(i + 1), team_for(here), start);
    cycle(i + 1);
    here.come_up(level(i + 1), team_for(here), products);
  }
  ThreadTeam& team() { return team_; }
  ThreadTeam& team_for(const Level& level) {
    return level.n_nodes() < Level::nodes_worth_threads ? alone_ : team_;
  }

protected:
  const CoarsestSolve& coarsest() const { return *coarsest_; }
  /// u = the solution of A u = f on the last level.
  void solve_coarsest() {
    Level& last = *levels_.back();
    std::fill_n(last.u.data(), last.u.size(), 0.0F);
    coarsest_->add_solution(last.f.data(), last.u.data());
  }
  /// Factors the present last level. @return false where it is not fixed well enough
  bool factor_coarsest() {
    const Level& last = *levels_.back();
    if (numbered_ != &last)
      coarsest_ = std::make_unique<CoarsestSolve>(last.unknowns());
    numbered_ = &last;
    return coarsest_->factor(
        [&](const CoarsestSolve::Visit& visit) { last.for_each_entry(coarsest_->unknowns(), visit); });
  }

  std::vector<std::unique_ptr<Level>> levels_; ///< the finest first

private:
  std::unique_ptr<CoarsestSolve> coarsest_;
  const Level* numbered_ = nullptr; ///< that the unknowns of coarsest_ are of
  ThreadTeam& team_;
  ThreadTeam alone_{1};
};

} // namespace maille::deform
