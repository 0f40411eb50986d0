#pragma once
/// Settings of smoothed aggregation for elasticity.

#include "maille/base/grid.hpp"

#include <Teuchos_ParameterList.hpp>
#include <vector>

namespace maille::fem_ref {

struct Box {
  Vec3 lower, upper;
};
/// @pre there are positions
Box box_around(const std::vector<Vec3>& positions);

/// Rigid motions at the nodes, one per column: translations, then rotations about the centre of the body's
/// bounding box.
std::vector<double> rigid_motions(const std::vector<Vec3>& positions, int dimension, const Box& around);
/// @param motions  must outlive the hierarchy's set-up
Teuchos::ParameterList amg_settings(int dimension, std::vector<double>& motions);

} // namespace maille::fem_ref
