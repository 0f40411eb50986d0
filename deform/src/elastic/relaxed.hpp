#pragma once
/// `relaxed`: the relaxation of Gibson (1995) with the material's weights, by multigrid, within limits where
/// a scene asks for some.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Minimises the energy of the componentwise model, each displacement component on its own, within the limits
/// that the scene asks for. scene.relaxation.mode `elastic`: links have the material's stiffness; there is no
/// Poisson effect. `deformable`: links cost nothing within their limits; the answer is that of `limits`.
///
/// @return status done, clamped (requests clipped, see clip), budget_reached or interrupted: feasible and
///         with the prescribed values however it ends; refused for moves not finite, contracting fibres,
///         loads in deformable mode or alone within taut limits; failed where a load pulls at matter that
///         nothing holds. `iterations`: multigrid cycles. `residual`: estimated largest error of a node over
///         the largest prescribed displacement (loads alone: of any node), with active limits the
///         multipliers' if that is more; its goal is scene.relaxation.tolerance. `reaction` with limits,
///         empty where cut short
/// Cost, memory  docs/relax.md: 3 to 4 cycles a component without active limits; 49 to 89 bytes a node
/// Repeatable  same bits for any number of threads. Another kind of vector gives other rounding
/// Source      docs/theory.md, sections 2 and 7b; Gibson 1995 (the model)
/// Checked by  tests/deform/elastic/relaxed_test.cpp and its neighbours
Answer solve_relaxed(const Scene& scene, const Control& control = {});

} // namespace maille::deform
