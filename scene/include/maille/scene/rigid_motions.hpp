#pragma once
/// Can the body, or a piece of it, still move without deforming?

#include "maille/scene/scene.hpp"

#include <string>

namespace maille {

/// How a part of the body can still move rigidly under the scene's conditions, e.g. `piece 2 of 3 (12 cells
/// about (0.01, 0.02, 0) m) can still turn about z`; empty where nothing can.
///
/// A motion without strain is rigid on each piece whose cells are joined through faces (a face carries 1, 2
/// or 4 nodes in 1D, 2D, 3D: enough to make the motions of both cells one), and pieces may share nodes
/// through edges and corners. So the motions of all pieces, made equal at shared nodes and zero at prescribed
/// components, span exactly the null space of the stiffness matrix. Where more than `largest_joint_problem`
/// motions are left in chains of pieces joined through edges and corners only, those are left to the solver
/// to judge. Cost: O(cells).
std::string remaining_rigid_motion(const Scene& scene);

inline constexpr int largest_joint_problem = 600;

} // namespace maille
