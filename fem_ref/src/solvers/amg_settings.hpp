#pragma once
/// What smoothed aggregation is told about elasticity.

#include "maille/base/grid.hpp"

#include <Teuchos_ParameterList.hpp>
#include <vector>

namespace maille::fem_ref {

struct Box {
  Vec3 lower, upper;
};
/// @pre there are positions
Box box_around(const std::vector<Vec3>& positions);

/// Displacements without strain at the nodes, one column each: shifts, then turns about the middle of the box
/// around the whole body.
std::vector<double> rigid_motions(const std::vector<Vec3>& positions, int dimension, const Box& around);
/// @param motions  must outlive the hierarchy's set-up
Teuchos::ParameterList amg_settings(int dimension, std::vector<double>& motions);

} // namespace maille::fem_ref
