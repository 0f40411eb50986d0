#pragma once
/// The reference: finite elements on exactly the body's cells, by deal.II.
///
/// One hexahedron per cell, Q1 or Q2, with the boundary conditions of the scene at its nodes. Small strain:
/// linear elasticity, full integration. Finite strain: total Lagrangian with the materials' laws, Q1-P0 or
/// Q2-P1. The code shares only the scene and the material with the lattice methods. Reactions are residuals
/// of the unconstrained equations. Linear solvers: sparse factor, AMG or matrix-free multigrid.

#include "maille/scene/answer.hpp"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

namespace maille::fem_ref {

/// Linear solvers: sparse Cholesky (CHOLMOD), CG with smoothed-aggregation AMG of Trilinos, CG with deal.II's
/// matrix-free geometric multigrid (only boxes of one material with even numbers of cells).
enum class LinearSolver { automatic, cholmod, cg_amg, gmg };
/// Names on the command line, in the order of the enumeration.
inline constexpr std::array<std::string_view, 4> linear_solver_names{"automatic", "cholmod", "amg", "gmg"};
std::optional<LinearSolver> linear_solver_named(std::string_view name);

struct Options {
  int degree = 1; ///< 1 or 2: fem_q1, fem_q2
  /// automatic: in 3D geometric multigrid for boxes of more than 4,000 nodes whose hierarchy ends in a small
  /// mesh; else CHOLMOD while its factor is cheaper than iterating (3D: to some 20,000 unknowns Q1, 50,000
  /// Q2; 2D: to half a million), else CG with smoothed-aggregation AMG. Answer::algorithm says which, and
  /// why.
  LinearSolver solver = LinearSolver::automatic;
  /// Relative residual of CG. If the residual of the answer exceeds twice this and 1e-8, the same solver
  /// corrects the answer. The solve fails if the residual stays above 1e-6 and the last correction exceeds
  /// 1e-5 of the displacement.
  double tolerance = 1e-10;
  /// Body force [N/m^3] added to gravity, by position in the object's frame; for manufactured solutions.
  std::function<Vec3(const Vec3& position)> body_force;
  /// If set, moves every node to shape(grid position) [m], and cells are isoparametric: curved specimens for
  /// benchmarks. Tractions are per area of the mapped face. Incompatible with body_force and exact.
  std::function<Vec3(const Vec3& position)> shape;
  /// Also recover Answer::nodal_strain and nodal_stress: strain at the points of the Gauss rule of `degree`
  /// points per axis (Barlow 1976), extrapolated linearly to the corners of the cell, then averaged by volume
  /// over those cells around a node that have the most frequent material.
  bool recover_stress = false;
  /// Displacement [m] on the whole boundary, in place of the boundary conditions of the scene; for
  /// manufactured solutions.
  std::function<Vec3(const Vec3& position)> boundary_displacement;
  /// If set, computes the L2 norm of u - exact over the body, by a quadrature of order degree + 3.
  std::function<Vec3(const Vec3& position)> exact;
};

struct Result {
  Answer answer;                       ///< at the scene's nodes
  std::optional<double> l2_error;      ///< see Options::exact [m^(1 + d/2)]
  std::int64_t degrees_of_freedom = 0; ///< free and prescribed; Answer::algorithm counts the free ones
};

/// Solves the scene with deal.II's FE_Q of the given degree, with the nodes, cells and conditions of every
/// other method. For degree 2, mid-points of edges, faces and cells are prescribed if all their corners are,
/// and mid-points of edges inside the body if both ends are.
///
/// @return status refused if the body can still move rigidly (`message` says how) or memory does not suffice;
///         failed if a solver failed; interrupted or budget_reached with the current state of CG, or, before
///         its first iteration and from direct solvers, with the prescribed displacements only. Converged
///         answers have `reaction` K u - f (degree 2: at corners) and `strain_energy` u K u / 2
/// Threads     Control::threads for deal.II's sums and for BLAS. These settings are global to the process:
///             one solve at a time. The last bits of the answer depend on them. If Control can stop it, the
///             solve runs in its own thread: see ranks.hpp
/// Ranks       if start_ranks() found several, all of them must call this with the same arguments:
///             docs/cluster.md
/// Process     the first CG starts MPI if the program has not; MPI ends with the process. Prints nothing
/// Source      full Gauss integration of B^T C B, no remedy for locking; docs/developers/finite_elements.md
/// Checked by  tests/fem_ref/
Result solve(const Scene& scene, const Options& options, const Control& control = {});

/// Estimated cost of solve(): fitted on one core of a server of 2023, within a factor of 3.
struct Estimate {
  double seconds = 0;
  double bytes = 0; ///< peak memory of the process
};
Estimate estimate(const Scene& scene, const Options& options);

/// Same as solve(), but caches the mesh with its factor or hierarchy while successive scenes have the same
/// body, materials and prescribed components. Other loads and other prescribed values then cost a
/// substitution or a few iterations. Answers equal those of solve(): to the last bit with factors, within
/// their tolerance with iterations.
class Solver {
public:
  explicit Solver(Options options);
  ~Solver();
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;

  Result solve(const Scene& scene, const Control& control = {});

  class Kept; ///< mesh and factor or hierarchy
private:
  Result solve_rubbing(Scene& split, const Control& control);

  Options options_;
  std::unique_ptr<Kept> kept_;
};

} // namespace maille::fem_ref
