#pragma once
/// From any state to a legal one that keeps holds and handles.

#include "feasible/bounds/admission.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// What the limits admit of the scene's requests, by the cheapest way. See admit().
Admission admit_fast(const Scene& scene, const LinkLimits& limits, int threads);

/// Changes `state` to a legal one in which the prescribed components have their values: the nearest legal
/// state (repair), then the least change that brings the prescribed nodes to their values (clamp between the
/// bounds that they span).
/// @param prescribed admitted
/// @return bytes held meanwhile
std::int64_t make_legal(const Scene& scene, const LinkLimits& limits,
                        const std::vector<Prescribed>& prescribed, Displacement& state, int threads);

} // namespace maille::deform
