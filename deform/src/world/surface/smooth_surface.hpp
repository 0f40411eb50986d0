#pragma once
/// The smooth surface that voxels stand for.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Moves corners of a surface's cells onto the smooth surface that the cells stand for.
///
/// Of an ellipsoid: onto it, towards its middle. Of all else: along the gradient of its matter, to where
/// twice the Gaussian mean of that less the mean of twice the variance is 1/2. That is the face itself where
/// the surface is flat, off by the fourth power of the width where it is curved, and rounds edges by about
/// the width. Corners that find no such place within a cell stay: what is thinner than two cells keeps its
/// form.
///
/// @param body each cell is matter or none @param[in,out] corners from the grid's lower corner [m]
/// Cost  of all but ellipsoids some 0.3 ms a corner
void make_smooth(const Specimen& body, std::vector<Eigen::Vector3d>& corners);

} // namespace maille::deform
