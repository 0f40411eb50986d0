#pragma once
/// The componentwise operator in float64, on dense fields: residuals that stay true, forces and energy.

#include "elastic/componentwise/componentwise_level.hpp"

namespace maille::deform {

/// r = scale (f - A u) in float32 where nodes may move, 0 elsewhere, for one plane.
/// @param u dense; @param f dense, in the operator's unit; nullptr: no forces
/// @return the largest |f - A u| in the plane
double find_true_residual(const ComponentwiseLevel& level, int z, const double* u, const double* f,
                          double scale, float* r);
/// f = scale A u for one plane, whether nodes may move or not; dense.
void find_forces(const ComponentwiseLevel& level, int z, const double* u, double scale, double* f);
/// Half of the sum of weight (difference)^2 over the links that start in a plane.
double energy_of_plane(const ComponentwiseLevel& level, int z, const double* u);
/// (A u) of one node, whether it may move or not.
double force_on(const ComponentwiseLevel& level, const Index3& at, const double* u);

} // namespace maille::deform
