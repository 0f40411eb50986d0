#pragma once
/// Multigrid for one component of the componentwise model.

#include "elastic/componentwise/componentwise_level.hpp"
#include "parallel/thread_team.hpp"

#include <memory>
#include <vector>

namespace maille::deform {

/// A hierarchy of levels and the V-cycle through them: two Jacobi steps with Chebyshev's weights before and
/// after each coarse correction, and a dense inverse on the coarsest level. One cycle from nothing is a
/// symmetric positive definite map, as conjugate gradients need it.
///
/// Levels are rediscretised, not Galerkin products: seven weights a node at most on every level
/// (docs/theory.md, sections 2 and 7b: arithmetic means; semicoarsening under anisotropy), and anchors
/// beside fixed nodes. Figures: docs/developers/relaxation.md.
class ComponentwiseMultigrid {
public:
  /// @param finest of the body; @param team outlives this
  ComponentwiseMultigrid(std::unique_ptr<ComponentwiseLevel> finest, ThreadTeam& team);

  ComponentwiseLevel& finest() { return *levels_.front(); }
  const ComponentwiseLevel& finest() const { return *levels_.front(); }
  int n_levels() const { return static_cast<int>(levels_.size()); }

  /// finest().u = B finest().f. @return u . f
  double precondition();
  /// Full multigrid: finest().u solves A u = f with the fixed values, about as well as the grid can tell.
  /// Right-hand sides of coarser levels are made from the finest one if `has_forces`.
  void solve_from_coarsest(bool has_forces);

  /// Calls visit(plane) for all planes of the finest level and returns the sum in a fixed order.
  template<class Visit>
  double sum_over_planes(Visit&& visit);
  ThreadTeam& team() { return team_; }

  std::int64_t bytes() const;

private:
  enum class Start { zero, coarser }; ///< from nothing, or from what the next coarser level holds
  void cycle(std::size_t level, Start start, double* dot_per_plane);
  void go_down(std::size_t level, Start start);
  void come_up(std::size_t level, double* dot_per_plane);
  void restrict_to(std::size_t level, const PaddedArray& fine_values);
  ThreadTeam& team_for(const ComponentwiseLevel& level);
  void factor_coarsest();
  void solve_coarsest(bool starts_from_zero);

  ThreadTeam& team_;
  ThreadTeam alone_{1};
  std::vector<std::unique_ptr<ComponentwiseLevel>> levels_;
  /// Per level and fine plane: the coarse planes that can be summed up then, as a range of `triggered_`.
  std::vector<std::vector<std::vector<int>>> triggered_;
  std::vector<double> sums_;           ///< per plane of the finest level
  std::vector<std::int64_t> unknowns_; ///< of the coarsest level, as places in its arrays
  std::vector<double> inverse_;        ///< dense, of the coarsest level
};

template<class Visit>
double ComponentwiseMultigrid::sum_over_planes(Visit&& visit) {
  team_for(finest()).run(finest().nodes()[2],
                         [&](int z, int) { sums_[static_cast<std::size_t>(z)] = visit(z); });
  double sum = 0;
  for (int z = 0; z < finest().nodes()[2]; ++z)
    sum += sums_[static_cast<std::size_t>(z)];
  return sum;
}

} // namespace maille::deform
