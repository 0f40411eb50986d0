#pragma once
/// Solver for one component of the componentwise model: set up once, solved for any forces.
///
/// The model couples no components: each one is a weighted graph Laplacian over the links, so three scalar
/// problems replace one elastic problem. This is `relaxed`, and the preconditioner of several solvers.

#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/componentwise/componentwise_multigrid.hpp"
#include "elastic/model/cell_moduli.hpp"

#include "maille/base/arena.hpp"

#include <functional>
#include <span>

namespace maille::deform {

/// Result of an iteration.
struct SolveOutcome {
  int iterations = 0;   ///< steps of conjugate gradients; the start by full multigrid is one
  double remaining = 0; ///< estimated largest error of any node [m]
  bool was_stopped = false;
};

/// Minimises 1/2 sum over links of w_ab (d_a u_b)^2 + 1/2 sum over springs of k_bb u_b^2 - f . u for one
/// component b, where w_ab is the sum over the cells of matter at the link of V / 2^(dimension - 1)
/// modulus_ab / h_a^2 [N/m].
///
/// Conjugate gradients around one multigrid cycle, in float32 on the correction, whose right-hand side is the
/// residual in float64; after every four digits the residual is found anew. Starts by full multigrid.
///
/// Error  estimated from the changes c_k of successive steps: 2 c rho / (1 - rho), rho the largest of the
///        last three ratios of changes and 0.1. A single step gives no estimate.
class ComponentwiseSolver {
public:
  /// @param fixed prescribed values of the component [m], ascending by node; nodes without a chain of links
  /// to any of them stay at rest
  ComponentwiseSolver(const Scene& scene, const CellModuli& moduli, int component, List<FixedNode> fixed,
                      ThreadTeam& team);
  /// The same with given weights. @param weights, springs of level_nodes(grid), in units of `unit` [N/m];
  /// @param is_loose what loose_nodes() says of `fixed`
  ComponentwiseSolver(const Scene& scene, LinkWeights weights, double unit, List<FixedNode> fixed,
                      std::vector<bool> is_loose, Anchors springs, ThreadTeam& team);

  /// Changes `u` (dense, [m]) to the minimum.
  /// @param forces dense [N]; empty: none
  /// @param tolerance on the largest error of any node [m]
  /// @param is_warm true: `u` is a start that has the prescribed values; false: `u` is ignored
  /// @param must_stop asked before every iteration; the state is usable if it stops
  SolveOutcome solve(std::span<double> u, std::span<const double> forces, double tolerance, bool is_warm,
                     const std::function<bool()>& must_stop);

  /// forces = K u, everywhere [N]; dense.
  void apply(std::span<const double> u, std::span<double> forces) const;
  /// correction = B residual, B one multigrid cycle from nothing: symmetric and positive definite on the
  /// nodes that are neither fixed nor loose, but for rounding to float32. @param residual dense [N];
  /// @param correction dense [m]
  void precondition(std::span<const double> residual, std::span<double> correction);

  /// Elastic energy, without that of springs [J].
  double energy(std::span<const double> u);
  /// Reaction at a prescribed node: the force of its links and spring [N].
  double elastic_force(std::span<const double> u, std::int64_t node) const;
  /// True if no chain of links joins a node to a fixed one, so that its position is undetermined. @pre a node
  /// of the body
  bool is_loose(std::int64_t node) const { return !is_loose_.empty() && is_loose_[node]; }
  /// The sum of the weights of a node's links [N/m].
  double stiffness_at(std::int64_t node) const;
  bool has_loose_nodes() const { return !is_loose_.empty(); }

  ComponentwiseMultigrid& multigrid() { return *multigrid_; }
  /// Weights are stored in this [N/m].
  double unit() const { return unit_; }

private:
  void begin_from_coarsest(std::span<double> u);
  bool fits_float32() const;
  void keep_between_fixed_values(std::span<double> u) const;
  double begin_correction(std::span<const double> u, const double* forces);
  class Correction;
  class Watch;

  Grid grid_;
  double unit_ = 1;
  List<FixedNode> fixed_;
  std::vector<bool> is_loose_; ///< empty where none is
  std::unique_ptr<ComponentwiseMultigrid> multigrid_;
  PaddedArray direction_;
  const double* forces_less_springs(std::span<const double> u);

  List<double> forces_;       ///< in unit_
  List<double> with_springs_; ///< forces_ and what springs pull with, where there are some
};

/// Nodes along the axes of the level: those of the grid, but a 2D body is stored as planes of one row each,
/// so that loops over planes can run in parallel.
Index3 level_nodes(const Grid& grid);
/// The level's axis for an axis of the grid.
int level_axis(const Grid& grid, int axis);

/// V / h_a^2 per axis of the grid: a link inside one kind of matter weighs its modulus times this [m].
Vec3 weight_per_modulus(const Grid& grid);
/// Weight of one link for one component: the sum over the cells of the body around it [N/m].
double link_weight(const Specimen& body, const CellModuli& moduli, const Index3& tail, int axis,
                   int component);

/// Weights of one component in units of `unit` [N/m].
LinkWeights link_weights(const Scene& scene, const CellModuli& moduli, int component, double unit);
/// The same as one number per link, on boxes too.
LinkWeights weights_per_link(const Scene& scene, const CellModuli& moduli, int component, double unit);
/// The largest weight that a link inside any cell's matter has [N/m].
double largest_weight(const Scene& scene, const CellModuli& moduli, int component);

/// Stiffness of springs to the ground for one component, in units of `unit` [N/m].
/// @param springs ascending by node
Anchors springs_along(const List<NodalSpring>& springs, int component, double unit);
/// True if no spring to the ground joins components.
bool springs_are_along_axes(const Scene& scene);

/// Nodes of the body without a chain of links to a fixed node or a spring; empty if none.
std::vector<bool> loose_nodes(const Scene& scene, const List<FixedNode>& fixed, const Anchors& springs);

} // namespace maille::deform
