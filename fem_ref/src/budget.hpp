#pragma once
/// Whether a scene can be solved, and by which family of solvers.

#include "maille/fem_ref/solve.hpp"

namespace maille::fem_ref {

/// Why the scene cannot be solved; empty where it can.
std::string why_refused(const Scene& scene, const Options& options);
/// True where geometric multigrid was asked for, or where nothing was and it is the quickest.
bool wants_multigrid(const Scene& scene, const Options& options);

} // namespace maille::fem_ref
