#pragma once
/// Cached mesh, matrix and factor or hierarchy of one body, for any number of loads; whether a scene can be
/// solved, and by which family of solvers.

#include "maille/fem_ref/solve.hpp"
#include "solvers/linear_solvers.hpp"

#include <memory>

namespace maille::fem_ref {

class Solver::Kept {
public:
  virtual ~Kept() = default;
  virtual Result solve(const Scene& scene, Watch& watch) = 0;
  /// True if the scene differs from the cached one only in loads and prescribed values.
  bool serves(const Scene& scene) const;

protected:
  explicit Kept(const Scene& scene) : scene_(scene) {}
  const Scene scene_; ///< first scene
};

/// "fem_q1" or "fem_q2"
std::string method_name(const Options& options);

/// @pre why_refused(scene, options) is empty
std::unique_ptr<Solver::Kept> keep(const Scene& scene, const Options& options, Watch& watch);

/// Reason that the scene cannot be solved; empty if it can.
std::string why_refused(const Scene& scene, const Options& options);
/// True if geometric multigrid was requested, or is the fastest for automatic choice.
bool wants_multigrid(const Scene& scene, const Options& options);

} // namespace maille::fem_ref
