#pragma once
/// The witness: finite elements on exactly the cells of matter, by deal.II.
///
/// One hexahedron a cell, Q1 or Q2; conditions are the scene's own, at the scene's nodes. Small strain:
/// linear elasticity, full integration. Finite strain: total Lagrange by the materials' laws, Q1-P0 or Q2-P1.
/// It shares no code with the lattice methods but the scene and the material. Reactions are residuals of the
/// unconstrained equations. The equations are solved by a sparse factor, AMG or matrix-free multigrid.

#include "maille/scene/answer.hpp"

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>

namespace maille::fem_ref {

/// How the equations are solved: sparse Cholesky, CG with smoothed-aggregation AMG of Trilinos, CG with
/// deal.II's matrix-free geometric multigrid (boxes of one material with even numbers of cells).
enum class LinearSolver { automatic, cholmod, cg_amg, gmg };
/// As on the command line, in the order of the enumeration.
inline constexpr std::array<std::string_view, 4> linear_solver_names{"automatic", "cholmod", "amg", "gmg"};
std::optional<LinearSolver> linear_solver_named(std::string_view name);

struct Options {
  int degree = 1; ///< 1 or 2: fem_q1, fem_q2
  /// automatic: in 3D geometric multigrid for boxes of more than 4,000 nodes whose hierarchy ends in a small
  /// mesh; else CHOLMOD while its factor is cheaper than iterating (3D: to some 20,000 unknowns Q1, 50,000
  /// Q2; 2D: to half a million), else CG with smoothed-aggregation AMG. Answer::algorithm says which, and
  /// why.
  LinearSolver solver = LinearSolver::automatic;
  /// Relative residual of CG. An answer that leaves more than twice that, and more than 1e-8, is corrected by
  /// the same solver; it has failed where more than 1e-6 stays and the last correction was more than 1e-5 of
  /// the displacement.
  double tolerance = 1e-10;
  /// Body force [N/m^3] added to gravity, at a point of the object's frame; for manufactured solutions.
  std::function<Vec3(const Vec3& position)> body_force;
  /// Where set, every node stands at shape(its place on the grid) [m], and cells are isoparametric: curved
  /// specimens for benchmarks. Tractions are per area of the shape. Not together with body_force or exact.
  std::function<Vec3(const Vec3& position)> shape;
  /// Also recover Answer::nodal_strain and nodal_stress: strain at the points of the Gauss rule of `degree`
  /// points per axis (Barlow 1976), linear from there to the corners of the cell, then the mean by volume
  /// over the cells around a node that are of the material most of them are of.
  bool recover_stress = false;
  /// Displacement [m] on the whole boundary instead of the scene's own conditions; for manufactured
  /// solutions.
  std::function<Vec3(const Vec3& position)> boundary_displacement;
  /// Where set, the L2 norm over the body of u - exact is computed by a quadrature of order degree + 3.
  std::function<Vec3(const Vec3& position)> exact;
};

struct Result {
  Answer answer;                       ///< at the scene's nodes
  std::optional<double> l2_error;      ///< see Options::exact [m^(1 + d/2)]
  std::int64_t degrees_of_freedom = 0; ///< free and prescribed; Answer::algorithm counts the free ones
};

/// Solves the scene with deal.II's FE_Q of the given degree: same nodes, same cells, same conditions as every
/// other method. For degree 2 mid points of edges, faces and cells are prescribed where all corners are, and
/// edges inside the body where both ends are.
///
/// @return status refused where the body can still move rigidly (`message` says how) or memory stands in the
///         way; failed where a solver gave up; interrupted or budget_reached with CG's state, or, before its
///         first iteration and from direct solvers, with nothing moved but what is prescribed. Converged
///         answers have `reaction` K u - f (degree 2: at corners) and `strain_energy` u K u / 2
/// Threads     Control::threads for deal.II's sums and for BLAS, numbers of the whole process: one solve at a
///             time. The last bits depend on them. Where Control can stop it, a thread of its own solves: see
///             ranks.hpp
/// Ranks       where start_ranks() found several, all of them must ask the same: docs/cluster.md
/// Process     the first CG starts MPI unless the program has; it ends with the process. Nothing is printed
/// Source      full Gauss integration of B^T C B, nothing against locking; docs/developers/finite_elements.md
/// Checked by  tests/fem_ref/
Result solve(const Scene& scene, const Options& options, const Control& control = {});

/// What solve() is expected to take: fitted on one core of a server of 2023, good to a factor of 3.
struct Estimate {
  double seconds = 0;
  double bytes = 0; ///< of the process, at its peak
};
Estimate estimate(const Scene& scene, const Options& options);

/// The same, and the mesh with its factor or hierarchy is kept for as long as scenes ask for the same body,
/// materials and prescribed components: other loads and other prescribed values then cost a substitution or a
/// few iterations. Answers are those of solve(): of factors to the last bit, of iterations within their
/// tolerance.
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
