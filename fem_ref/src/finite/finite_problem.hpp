#pragma once
/// Scenes of finite strain: total Lagrangian, Newton's method, adaptive increments.

#include "kept_problem.hpp"

namespace maille::fem_ref {

/// @pre scene.strain is finite, and why_refused(scene, options) is empty
std::unique_ptr<Solver::Kept> keep_finite(const Scene& scene, const Options& options);

/// Unsupported feature of a finite-strain scene, in words; empty for supported scenes and for small strain.
std::string why_no_finite_strain(const Scene& scene, const Options& options);

} // namespace maille::fem_ref
