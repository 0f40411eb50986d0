#pragma once
/// `sweep`: the relaxation of Gibson 1995, voxel by voxel; kept as the oracle of faster relaxers.

#include "lattice/link_table.hpp"
#include "maille/scene/answer.hpp"

#include <limits>
#include <vector>

namespace maille::deform {

class ComponentSweep {
public:
  /// @param table must outlive this; @param u one value per node of the body, prescribed ones in place [m]
  ComponentSweep(const LinkTable& table, int component, List<double> u,
                 const std::vector<Prescribed>& prescribed);

  /// Every free node moves to the mean of its neighbours, within its links' limits. @return the largest move
  double relax_elastic();
  /// Every free node that breaks limits moves as little as they ask. @return the largest move
  double relax_deformable();

  int component() const { return component_; }
  const List<double>& values() const { return u_; }
  /// Nodes whose component is free and that have a neighbour, ascending.
  const List<std::int32_t>& free_nodes() const { return free_; }

private:
  template<class Rule>
  double sweep(Rule rule);

  const LinkTable& table_;
  int component_;
  List<double> u_;
  List<std::int32_t> free_;
};

struct Jams {
  std::int64_t groups = 0;
  double farthest = 0; ///< the most that a group would move before its outer links stop it [m]
};

/// Looks at a state in which no single node can come nearer to the mean of its neighbours.
///
/// Nodes of a group are joined by links that stop one of their ends. A group is jammed if its links to other
/// nodes pull it on as a whole, and let it. At the least energy within the limits there are none; that there
/// are none does not prove the least energy (only shifts of whole groups are tried).
///
/// @param rounding how near to its limit a link counts as stopped [m]
/// @param smallest shorter moves of a group are not reported [m]
/// Cost O(links)
Jams find_jams(const LinkTable& table, const ComponentSweep& component, double rounding, double smallest);

/// Relaxes a body one node after the other, as Gibson 1995 (Object Deformation) describes it; handles are
/// clipped (see clip). **elastic**: from the answer of `limits`, every free component of every node moves to
/// the mean of its linked neighbours, clamped to what its links leave it; feasible after every move. Active
/// limits may block groups of nodes; `message` counts these. **deformable**: from rest with the handles
/// placed, a node with links outside their limits moves as little as they ask; feasible once converged.
///
/// @return status done, clamped, budget_reached (sweeps or seconds), interrupted, or refused for loads and
///         moves that are not finite. `iterations` counts sweeps; `residual`, with scene.relaxation.tolerance
///         as its goal: last change * rho / (1 - rho), rho the contraction of the last sweeps, over the
///         largest prescribed displacement, 1 while nothing can be said
/// Cost        O(links) a sweep, O(n^2) sweeps for n nodes along the body; 390 bytes a node in 3D
/// Repeatable  same input, same bits
/// Source      Gibson 1995; docs/theory.md, section 2. Departures: the start; displacements in place of
///             positions (the same at equal spacing); ended by an estimate where the source never ends
/// Checked by  tests/deform/elastic/sweep_test.cpp
Answer solve_sweep(const Scene& scene, const Control& control = {});

/// The same from another state, into which the handles are placed first.
/// @param limits of `scene`; @param start feasible for the elastic mode, any for the deformable one
Answer relax_sweep(const Scene& scene, const LinkLimits& limits, const Displacement& start,
                   const Control& control = {});

/// Estimates the error that remains from the changes of successive sweeps: if every change is rho times the
/// one before, those still to come add up to change * rho / (1 - rho).
///
/// rho is the geometric mean over the last eighth of the sweeps and over the last quarter, whichever says
/// more is left: one window alone is fooled when a limit becomes active or the largest change changes place.
class ErrorEstimate {
public:
  /// @param noise changes of this size are noise: the iteration can do no better [m]
  explicit ErrorEstimate(double noise) : rounding_(noise) {}
  /// @param change the largest change of the latest sweep [m]
  void add(double change);
  /// What remains [m]; +infinity while nothing can be said.
  double remaining() const { return remaining_; }

private:
  double remaining_after(std::size_t window) const;

  double rounding_;
  double remaining_ = std::numeric_limits<double>::infinity();
  std::vector<double> changes_;
};

/// Held at the peak, at most [bytes].
std::int64_t bytes_for_sweep(const Scene& scene);

} // namespace maille::deform
