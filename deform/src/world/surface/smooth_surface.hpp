#pragma once
/// The smooth surface that voxels approximate.

#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <vector>

namespace maille::deform {

/// Moves corners of a surface's cells onto the smooth surface that the cells approximate.
///
/// On an ellipsoid the corners move towards its middle, onto the ellipsoid. On other bodies they move along
/// the gradient of the volume fraction, to the place where twice its Gaussian mean less the mean of twice the
/// variance is 1/2. This is the face itself where the surface is flat; on curved surfaces the error is of
/// fourth order in the width; edges are rounded by about the width. Corners without such a place within a
/// cell stay: parts thinner than two cells keep their shape.
///
/// @param body each cell is full or empty @param[in,out] corners from the grid's lower corner [m]
/// Cost  about 0.3 ms a corner, except for ellipsoids
void make_smooth(const Specimen& body, std::vector<Eigen::Vector3d>& corners);

} // namespace maille::deform
