#pragma once
/// `limits`: the chain mail by exact propagation, independent of any order.

#include "control/method.hpp"
#include "feasible/bounds/clipping.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Moves the prescribed components of a resting body and lets every other one follow as little as its links'
/// limits allow: clamp(x, L, U) with L_i = max_h(p_h - d(i, h)) and U_i = min_h(p_h + d(h, i)), d the
/// shortest path over the links' slack, each component for itself. No feasible state with these values moves
/// any node less. This is no elasticity: no component influences another.
///
/// A request that cannot be met is clipped (see clip) and gives Status::clamped. If the caller stops it, the
/// components not yet reached are at rest: the state is feasible, but not what was asked.
///
/// @return status done or clamped; refused for loads and for moves that are not finite; interrupted or
///         budget_reached. `iterations` counts the nodes settled by the searches, `residual` is 0
/// @post   no link is outside its limits by more than rounding_tolerance of the largest displacement
/// Cost        O(links log nodes) time per component that moves, 24 bytes a node
/// Repeatable  same bits in any order of the prescribed values
/// Source      docs/theory.md, Theorems 1 and 4. On a homogeneous box with one handle it equals Gibson 1997
/// Checked by  tests/deform/feasible/limits_test.cpp
Answer solve_limits(const Scene& scene, const Control& control = {});

/// The same from another feasible state: one step of a drag. A drag from rest that is monotone in every
/// component and met at every step ends in the same state in one step or in many; one that goes out and comes
/// back does not (the model is plastic).
///
/// @param limits of `scene`
/// @param start  a feasible state; components that were prescribed before and are not now are free
Answer drag_limits(const Scene& scene, const LinkLimits& limits, Displacement start,
                   const Control& control = {});

/// The same from rest. @param clock running since the answer was asked for: what it says is the set-up
Answer limits_from_rest(const Scene& scene, const LinkLimits& limits, const Control& control,
                        const Clock& clock);

/// clamp(start, L, U) for values that the limits permit.
/// @param prescribed clipped by clip(); @param start a feasible state
/// @return the nodes settled by the searches, for Answer::iterations
std::int64_t propagate(const Scene& scene, const LinkLimits& limits,
                       const std::vector<Prescribed>& prescribed, Displacement& state);

} // namespace maille::deform
