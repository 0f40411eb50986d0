#pragma once
/// Mesh, matrix and factor or hierarchy of one body, kept for as many loads as come; and whether a scene
/// can be solved at all, and by which family of solvers.

#include "maille/fem_ref/solve.hpp"
#include "solvers/linear_solvers.hpp"

#include <memory>

namespace maille::fem_ref {

class Solver::Kept {
public:
  virtual ~Kept() = default;
  virtual Result solve(const Scene& scene, Watch& watch) = 0;
  /// Whether the scene differs from the first one in loads and prescribed values alone.
  bool serves(const Scene& scene) const;

protected:
  explicit Kept(const Scene& scene) : scene_(scene) {}
  const Scene scene_; ///< the first that was asked
};

/// "fem_q1" or "fem_q2"
std::string method_name(const Options& options);

/// @pre why_refused(scene, options) is empty
std::unique_ptr<Solver::Kept> keep(const Scene& scene, const Options& options, Watch& watch);

/// Why the scene cannot be solved; empty where it can.
std::string why_refused(const Scene& scene, const Options& options);
/// True where geometric multigrid was asked for, or where nothing was and it is the quickest.
bool wants_multigrid(const Scene& scene, const Options& options);

} // namespace maille::fem_ref
