#pragma once
/// From every second node of a body to all of them.

#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <span>

namespace maille::deform {

/// Linear between the coarse nodes that are nodes of the body; at fine nodes without one around, and where
/// there is no matter, `to` stays as it is.
/// @param from one number per node of `coarse`; @param to per node of `fine`, which has twice the cells along
///        every axis
void interpolate(const Specimen& coarse, const std::vector<double>& from, const Specimen& fine,
                 std::vector<double>& to, ThreadTeam& team);
/// All components.
void interpolate(const Specimen& coarse, const Displacement& from, const Specimen& fine, Displacement& to,
                 ThreadTeam& team);

} // namespace maille::deform
