#pragma once
/// The directions whose stresses a scene's dimension says are zero.

#include "maille/materials/elasticity.hpp"

namespace maille {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Adds to `strain` the lateral strains that free matter takes on: those at which the stress C
/// strain + active is zero in the directions that are free (1D: all but the first; plane stress: those out of
/// the plane; else none). Voigt order 11 22 33 23 13 12, engineering shear.
void release_free_directions(const Matrix6& C, const Vector6& active, int dimension, PlaneAssumption plane,
                             Vector6& strain);

} // namespace maille
