#pragma once
/// Loads of a scene as forces on nodes.

#include "maille/scene/scene.hpp"

#include <vector>

namespace maille {

/// One component of the force on every node [N] (per metre in 2D): a traction's force goes to the nodes of its
/// face in equal parts, a cell's weight to its corners. That is what constant loads are worth to multilinear
/// displacements. Empty if the scene has no loads along this component.
std::vector<double> nodal_forces(const Scene& scene, int component);

} // namespace maille
