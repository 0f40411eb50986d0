#pragma once
/// `coupled`: full anisotropic elasticity on the lattice.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Minimises linear elastic energy under holds, moves, loads and contracting fibres: any stiffness and fibre
/// direction per cell, 1D, 2D (plane strain or stress) and 3D, bodies of any shape; in blocks
/// (docs/large_rotation.md) Biot's strain. Within limits that the scene asks for, taut ones excepted.
///
/// @return status done, clamped (requests clipped, see clip; in blocks also where no feasible state was
///         found), refused (rigid motion left, moves not finite), budget_reached, interrupted, failed;
///         feasible however it ends. `residual`: estimated relative error in the energy norm, with active
///         limits also of displacements; its goal is scene.relaxation.tolerance. `iterations`: of conjugate
///         gradients, without coarser bodies. `strain_energy` without the work of contracting fibres;
///         `reaction` with what limits pull, none where cut short. `algorithm` says the way; `extrapolated`
///         the share of nodes where nested lattices were used
/// Cost, memory  docs/relax.md: 20 to 80 ns a node and iteration and 60 to 100 bytes a node on boxes
/// Repeatable  same bits for any number of threads; another kind of vector may round otherwise
/// Source      docs/theory.md, sections 3 (LAT, Solving LAT, Nested-lattice extrapolation), 4 and 7
/// Checked by  tests/deform/elastic/ (docs/theory.md, section 8), tests/cross_check
Answer solve_coupled(const Scene& scene, const Control& control = {});

} // namespace maille::deform
