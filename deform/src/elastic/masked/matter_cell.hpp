#pragma once
/// The stiffness of one cell in the numbers of MatterOperator.

#include "elastic/masked/matter_kernel.hpp"
#include "elastic/model/lattice_elasticity.hpp"

#include <Eigen/Core>

#include <array>

namespace maille::deform {

using CellCoefficients = std::array<double, MatterOperator::n_coefficients>;
/// Rows and columns: 3 corner + component.
using CellMatrix = Eigen::Matrix<double, 24, 24>;

/// @param scale per axis: spacing over the unit of length; forces are those of displacements times it
CellCoefficients coefficients_of(const LatticeElasticity::Kind& kind, const Vec3& spacing, const Vec3& scale,
                                 double unit);
CellMatrix cell_matrix(const CellCoefficients& c);

} // namespace maille::deform
