#pragma once
/// Full elasticity on bodies whose nodes are tied in pairs: labels that slide on each other.

#include "elastic/krylov/coupled_task.hpp"

namespace maille::deform {

/// Conjugate gradients in float64 among displacements in which tied nodes move together, around the multigrid
/// of the bodies by themselves, each held softly where it is tied, and their answers brought together: what a
/// Neumann-Neumann method does with its coarse space in the springs. With friction in rounds, see Friction.
///
/// @pre scene in 3D, with ties, no limits bind and no blocks
/// Source  Mandel 1993 (Commun. Numer. Methods Eng. 9), balancing by weights of the diagonal
/// Checked by  tests/deform/elastic/anatomy_conditions_test.cpp
CoupledAlgorithm solve_coupled_tied;

} // namespace maille::deform
