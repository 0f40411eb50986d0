#pragma once
/// `relaxed`: the relaxation of Gibson (1995) with the material's weights, by multigrid, within limits where a scene asks for some.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Relaxes a body every displacement component of which is a problem of its own. Which of its two systems
/// is scene.relaxation.mode.
///
/// **elastic**: minimises 1/2 sum over links w_ab (d_a u_b)^2 - f . u for each component b, d_a u_b the difference
/// along a link of axis a, within the limits that the scene asks for: without [limits] there are none. w_ab is summed over the cells at the link, V / 4
/// modulus_ab / h_a^2 each in 3D, with the modulus C_bb along the component's own axis and the shear modulus G_ab
/// across it, the first times the material's relaxed_weights (1 unless given): what `sweep` tends to where its equal weights are these. It knows no Poisson effect: components do
/// not feel each other (docs/theory.md, section 2: exact for pulls at nu = 0, tens of percent off elsewhere; compare).
/// Carries loads.
///
/// **deformable**: links cost nothing inside their limits (dead zone). Then every legal state is a least one;
/// of these the answer is the one that moves every single component the least: that of `limits`.
///
/// The elastic solution is found by conjugate gradients around one multigrid cycle a step (see
/// SeparableMultigrid). Where it breaks limits, the minimum within them is found by the alternating direction
/// method of multipliers on the same multigrid, and made legal: nearest legal state, prescribed nodes brought
/// back to their values. Rigid links (min = max) are like others.
///
/// @return status done, clamped (requests cut back, see admit), budget_reached or interrupted: the state is legal
///         and has the prescribed values whenever it ends; refused for moves that are not finite, for contracting
///         fibres, for loads alone within taut limits, whose scale no move gives; in deformable mode for any loads; failed where a load pulls at matter that nothing prescribed is joined to.
///         `iterations` counts multigrid cycles of all components, the start of each as one. `residual`: where no limit is
///         active, the estimated error of any node over the largest prescribed displacement (over the largest
///         displacement where loads alone move the body); else the larger of this and the relative residual of
///         the multipliers. Its goal is scene.relaxation.tolerance.
///         `reaction` of every prescribed component, from the model's links, multipliers of limits included; empty where the
///         solve was cut short. `strain_energy` of the final state
/// @post   no link is outside its limits by more than rounding (of the wavefront's quanta where it made the state
///         legal, see TiledBody)
/// Cost        elastic, 3 to 4 cycles a component: 30 ns a node and component at 65^3 nodes on one thread, 1.6 to 1.7
///             times as fast on two. Limits active: 13 more cycles a component to 1e-2, and 30 to 140 to 1e-3, more
///             the more links are at their limits; residuals fall slowly there
/// Memory      24 bytes a node for the answer, and at a time one component's 25 on a homogeneous box, else 45;
///             20 more while limits are active
/// Repeatable  same bits for any number of threads. Another kind of vector gives other rounding
/// Source      docs/theory.md, sections 2 and 7; Gibson 1995 (the model)
/// Checked by  tests/deform/relax/relaxed_test.cpp and its neighbours
Answer solve_relaxed(const Scene& scene, const Control& control = {});

} // namespace maille::deform
