#pragma once
/// `coupled`, `relaxed` and `limits` of bodies whose nodes are tied in pairs, along any direction: labels
/// that slide on each other. In `relaxed` and `limits` components feel each other by the ties alone.

#include "elastic/krylov/coupled_task.hpp"
#include "maille/scene/answer.hpp"

namespace maille::deform {

/// The least energy of the componentwise model among states in which tied nodes move together, by conjugate
/// gradients on all components around one multigrid a component; within limits as keep_within_limits() has
/// it. Springs to the ground may have any direction.
///
/// @pre scene in 3D with ties, no contraction
/// @return as solve_relaxed; refused where a rigid motion is left; budget_reached, feasible and with a
///         message, where borders cannot be kept together within limits
/// Memory  some 700 bytes a node, within limits some 500 more
/// Checked by  tests/deform/elastic/tied/tied_limits_test.cpp
Answer solve_relaxed_tied(const Scene& scene, const Control& control);

/// The least movement from rest within limits: the least sum of squares over all nodes of bodies among states
/// in which tied nodes move together. Without ties that is what `limits` always gives, where every node moves
/// as little as any state lets it; an oblique tie weighs components of nodes against each other.
///
/// @pre scene in 3D with ties and limits
/// @return as solve_relaxed_tied
Answer solve_limits_tied(const Scene& scene, const Control& control);

/// Conjugate gradients in float64 among displacements in which tied nodes move together, around the multigrid
/// of the bodies by themselves, each held softly where it is tied, and their answers brought together: what a
/// Neumann-Neumann method does with its coarse space in the springs. With friction in rounds, see Friction.
///
/// @pre scene in 3D, with ties, no limits bind and no blocks
/// Source  Mandel 1993 (Commun. Numer. Methods Eng. 9), balancing by weights of the diagonal
/// Checked by  tests/deform/elastic/anatomy_conditions_test.cpp
CoupledAlgorithm solve_coupled_tied;

} // namespace maille::deform
