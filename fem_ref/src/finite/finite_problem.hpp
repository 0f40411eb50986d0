#pragma once
/// Scenes of finite strain: total Lagrange, Newton's method, increments that adapt.

#include "kept_problem.hpp"

namespace maille::fem_ref {

/// @pre scene.strain is finite, and why_refused(scene, options) is empty
std::unique_ptr<Solver::Kept> keep_finite(const Scene& scene, const Options& options);

/// What finite strain cannot answer; empty for other scenes, and where it can.
std::string why_no_finite_strain(const Scene& scene, const Options& options);

} // namespace maille::fem_ref
