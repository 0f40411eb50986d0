#pragma once
/// The smooth surface that voxels stand for.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Moves corners of a surface's cells onto the smooth surface that the cells stand for.
///
/// On an ellipsoid the corners go onto it, towards its middle. On other bodies they go along the gradient of
/// the volume fraction, to where twice its Gaussian mean less the mean of twice the variance is 1/2. That is
/// the face itself where the surface is flat, off by the fourth power of the width where it is curved, and
/// rounds edges by about the width. Corners without such a place within a cell stay: parts thinner than two
/// cells keep their form.
///
/// @param body each cell is matter or none @param[in,out] corners from the grid's lower corner [m]
/// Cost  of all but ellipsoids some 0.3 ms a corner
void make_smooth(const Specimen& body, std::vector<Eigen::Vector3d>& corners);

} // namespace maille::deform
