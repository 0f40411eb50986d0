#pragma once
/// One component of the componentwise model within the limits of its links.

#include "elastic/componentwise/componentwise_kernel.hpp"
#include "elastic/componentwise/componentwise_solver.hpp"
#include "elastic/links/link_ranges.hpp"

namespace maille::deform {

/// Minimises the energy of a ComponentwiseSolver subject to low <= d_a u <= high on every link, by the
/// alternating direction method of multipliers.
///
/// With z = D u on the links, multipliers rho w y and the penalty rho w / 2 |D u - z|^2, whose weights are
/// the links' own, the step for u is the elastic problem again, with forces from z and y: one multigrid
/// cycle. The step for z is a clamp per link, so links whose limits are one number (rigid ones) are like any
/// other. rho is doubled or halved where one residual is far above the other (Boyd et al. 2011, 3.4.1);
/// over-relaxation 1.6.
///
/// Holds z and y of a link in one number, v = z + y: z is v clamped.
///
/// Source: docs/theory.md, sections 2 and 7; Boyd, Parikh, Chu, Peleato, Eckstein 2011
class ComponentwiseAdmm {
public:
  /// All must outlive this. @param forces dense [N]; empty: none
  ComponentwiseAdmm(const Grid& grid, ComponentwiseSolver& solver, const LinkRanges& ranges,
                    std::span<const double> forces, ThreadTeam& team);

  /// Changes `u` from the elastic minimum towards the minimum within the limits. `remaining` in the outcome
  /// is relative: the larger residual over the elastic norm, sqrt(sum w r^2 / sum w (D u)^2).
  SolveOutcome solve(std::vector<double>& u, double tolerance, const std::function<bool()>& must_stop);

  /// Force of all multipliers on a node [N]: with the elastic force and the loads it is what a prescribed
  /// node has to be held against.
  double limit_force(std::int64_t node) const;
  std::int64_t bytes() const;

private:
  /// Links along one axis.
  struct Axis {
    int grid = 0, level = 0;
    std::int64_t step = 0;         ///< from a node to the next
    std::vector<double> low, high; ///< a row of them, where all are the same
    std::vector<float> v;          ///< per node: z + y of its link to the next
  };
  /// The links along `axis` that start in a row of the level; none if there are none. @param v of the axis
  RowOfLinks row(const Axis& axis, float* v, int y, int z) const;
  void gather_forces(int z, std::vector<double>& target);
  LinkResiduals update_plane(int z, const double* u);
  void begin_with(const std::vector<double>& u);
  void change_penalty(double factor);

  ComponentwiseSolver& solver_;
  const LinkRanges& ranges_;
  ThreadTeam& team_;
  Index3 nodes_; ///< of the level
  std::vector<Axis> axes_;
  std::vector<double> loads_; ///< in the solver's unit; empty: none
  double rho_ = 3;
};

} // namespace maille::deform
