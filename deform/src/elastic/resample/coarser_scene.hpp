#pragma once
/// The same question on twice the spacing, and interpolation back.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"
#include "parallel/thread_team.hpp"

#include <optional>
#include <span>
#include <string>

namespace maille::deform {

/// A coarse cell has the majority material of its 2^dimension cells, and the fibres of the first of these.
/// Prescribed values are taken at the remaining nodes, tractions at the remaining faces. Limits, gravity and
/// settings are those of `fine`.
/// @param prescribed in place of the scene's
/// @return nothing if an axis has an odd number of cells or fewer than 8, or if the remaining holds leave a
/// rigid motion
/// Cost    O(cells), but O(prescribed) for boxes of one material
std::optional<Scene> coarser_scene(const Scene& fine, const std::vector<Prescribed>& prescribed);

/// Why `coarse` is a different question than `fine`; empty if refined(coarse) equals `fine` with
/// `prescribed`, so that only the mesh differs.
/// Cost    O(cells), but O(prescribed) for boxes of one material, and a number per node of the coarser
///         lattice
std::string what_coarsening_loses(const Scene& coarse, const Scene& fine,
                                  const std::vector<Prescribed>& prescribed);

/// Linear interpolation between the coarse nodes of the body. `to` is unchanged at fine nodes without such a
/// neighbour, and where there is no matter.
/// @param from one or more fields, one after the other, of one number per node of `coarse`
/// @param to per node of `fine`, which has twice the cells along every axis
void interpolate(const Specimen& coarse, std::span<const double> from, const Specimen& fine,
                 std::span<double> to, ThreadTeam& team);

} // namespace maille::deform
