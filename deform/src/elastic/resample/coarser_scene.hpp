#pragma once
/// The same question on every second node, and from there to all of them.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"
#include "parallel/thread_team.hpp"

#include <optional>
#include <span>
#include <string>

namespace maille::deform {

/// A coarse cell holds what most of its 2^dimension cells hold, and the fibres of the first of those; what is
/// prescribed is known at the nodes that stay, and tractions on the faces that do. Limits, gravity and
/// settings are those of `fine`.
/// @param prescribed in place of the scene's
/// @return nothing where an axis has an odd number of cells, or fewer than 8, or where what is held of the
///         coarser body lets it move rigidly
/// Cost    O(cells), but O(prescribed) for boxes of one material
std::optional<Scene> coarser_scene(const Scene& fine, const std::vector<Prescribed>& prescribed);

/// Why `coarse` asks something else than `fine`; empty if refined(coarse) is `fine` with `prescribed`: then
/// the two differ by nothing but the mesh.
/// Cost    O(cells), but O(prescribed) for boxes of one material, and a number per node of the coarser
///         lattice
std::string what_coarsening_loses(const Scene& coarse, const Scene& fine,
                                  const std::vector<Prescribed>& prescribed);

/// Linear between the coarse nodes that are nodes of the body; at fine nodes without one around, and where
/// there is no matter, `to` stays as it is.
/// @param from one or more fields, one after the other, of one number per node of `coarse`
/// @param to per node of `fine`, which has twice the cells along every axis
void interpolate(const Specimen& coarse, std::span<const double> from, const Specimen& fine,
                 std::span<double> to, ThreadTeam& team);

} // namespace maille::deform
