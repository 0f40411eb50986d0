#pragma once
/// `coupled`, `relaxed` and `limits` for bodies with ties between pairs of nodes, in any direction: labels
/// that slide on each other. In `relaxed` and `limits` components are coupled by ties only.

#include "elastic/krylov/coupled_task.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Minimises the energy of the componentwise model over displacements in which tied nodes move together:
/// conjugate gradients on all components around one multigrid per component, within limits by
/// keep_within_limits(). Springs to the ground may have any direction.
///
/// @pre scene in 3D with ties, no contraction
/// @return as solve_relaxed; refused where a rigid motion is left; budget_reached, feasible and with a
///         message, where borders cannot be kept together within limits
/// Memory  some 700 bytes a node, within limits some 500 more
/// Checked by  tests/deform/elastic/tied/tied_limits_test.cpp
Answer solve_relaxed_tied(const Scene& scene, const Control& control);

/// Minimises the sum of squared displacements within limits, over displacements in which tied nodes move
/// together. Without ties this is the answer of `limits`, where every node moves as little as any feasible
/// state allows; an oblique tie couples components of nodes.
///
/// @pre scene in 3D with ties and limits
/// @return as solve_relaxed_tied
Answer solve_limits_tied(const Scene& scene, const Control& control);

/// Conjugate gradients in float64 over displacements in which tied nodes move together. The preconditioner is
/// the multigrid of the single bodies, each held by weak springs at its ties, followed by averaging: a
/// Neumann-Neumann method whose coarse space is in the springs. Friction is solved in rounds; see Friction.
///
/// @pre scene in 3D, with ties, no limits bind and no blocks
/// Source  Mandel 1993 (Commun. Numer. Methods Eng. 9), balancing by weights of the diagonal
/// Checked by  tests/deform/elastic/anatomy_conditions_test.cpp
CoupledAlgorithm solve_coupled_tied;

} // namespace maille::deform
