#pragma once
/// The witness: linear-elastic finite elements on exactly the cells of matter, by deal.II.

#include "maille/scene/answer.hpp"

#include <array>
#include <functional>
#include <optional>

namespace maille::fem_ref {

enum class LinearSolver { automatic, cholmod, umfpack, cg_amg };

struct Options {
  int degree = 1;                             ///< 1 or 2: fem_q1, fem_q2
  LinearSolver solver = LinearSolver::automatic; ///< automatic: CHOLMOD while its factor is small, else CG with AMG
  double tolerance = 1e-10;                   ///< relative residual of CG
  /// Body force [N/m^3] added to gravity, at a point of the object's frame; for manufactured solutions.
  std::function<Vec3(const Vec3& position)> body_force;
  /// Displacement [m] on the whole boundary instead of the scene's own conditions; for manufactured solutions.
  std::function<Vec3(const Vec3& position)> boundary_displacement;
  /// Where set, the L2 norm over the body of u - exact is computed by a quadrature of order degree + 3.
  std::function<Vec3(const Vec3& position)> exact;
};

struct Result {
  Answer answer;                  ///< at the scene's nodes
  std::optional<double> l2_error; ///< see Options::exact [m^(1 + d/2)]
  std::int64_t degrees_of_freedom = 0;
};

/// Solves the scene. Same nodes, same cells, same conditions as every other method: a hold or move acts on the
/// nodes that it selects, and for degree 2 also on the mid points of edges and faces all of whose corners it
/// selects, interpolated linearly.
/// @return status refused where the body can still move rigidly (`message` says how) or a limit of memory stands
///         in the way; failed where a solver gave up
Result solve(const Scene& scene, const Options& options, const Control& control = {});

} // namespace maille::fem_ref
