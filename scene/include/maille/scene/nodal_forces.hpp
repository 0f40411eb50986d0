#pragma once
/// Loads of a scene as forces on nodes.

#include "maille/scene/scene.hpp"

#include <vector>

namespace maille {

/// One component of the force on every node [N] (per metre in 2D): a traction's force goes to the nodes of
/// its face in equal parts, a cell's weight to its corners, and a cell's active stress pulls its corners
/// together by
/// - integral of B^T stress. That is what constant loads are worth to multilinear displacements, and of
/// active stress to any whose mean strain in a cell is theirs; its forces have neither a sum nor a moment.
/// Empty if the scene has no loads along this component.
std::vector<double> nodal_forces(const Scene& scene, int component);

} // namespace maille
