#pragma once
/// Frames that turn with every cell, for bodies that bend.

#include "maille/scene/answer.hpp"

#include <Eigen/Geometry>

#include <cstdint>
#include <vector>

namespace maille {

/// True if the scene asks for them: in 1D there is nothing to turn.
inline bool in_blocks(const Scene& scene) {
  return scene.relaxation.frame == StrainFrame::blocks && scene.dimension() > 1;
}

/// The mean displacement gradient of a cell [component][axis], from its corners [1]; zero outside of the
/// scene's dimension.
Eigen::Matrix3d displacement_gradient(const Grid& grid, const Displacement& displacement, const Index3& cell);

/// The rotation of every cell of matter, nearest to I + displacement_gradient; without turn elsewhere. By
/// cell.
/// Cost  O(cells), a quarter to one microsecond each
std::vector<Eigen::Quaterniond> block_rotations(const Scene& scene, const Displacement& displacement);

/// The largest amount by which a link breaks its limits in the mean frame of the cells that it borders, in
/// units of its rest length; 0 if none does.
double largest_violation_in_blocks(const Scene& scene, const LinkLimits& limits,
                                   const Displacement& displacement);

} // namespace maille
