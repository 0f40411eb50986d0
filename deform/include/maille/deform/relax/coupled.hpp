#pragma once
/// `coupled`: full anisotropic elasticity on the lattice.

#include "maille/scene/answer.hpp"

namespace maille::deform {

/// Minimises the elastic energy of the lattice operator (see LatticeElasticity) under holds, moves, tractions, gravity and contracting fibres: linear
/// elasticity of any stiffness and fibre direction per cell, in 1D, 2D (plane strain or stress) and 3D, on bodies of any shape. On the
/// same mesh as Q1 it is at least as accurate, and does not lock near incompressibility or in bending.
///
/// **In 3D**: conjugate gradients in float32 around a multigrid of the operator itself, with residuals found anew in float64 every five
/// digits. Coarser grids have exact (Galerkin) operators, and on them pieces of the body that touch only at edges or corners stay apart:
/// several materials, fibres that turn from cell to cell, holes, hinges and bridges of one cell cost little more than a box. Iterations
/// to 1e-3: a muscle from an image 10, two legs of seven muscles each 23; a stiff cord in matter a thousand times as soft 6, 7
/// and 8 with 16, 32 and 64 cells an axis, at Poisson's ratio 0.49 12; cells a thousandfold apart in no order 9 to 11, as
/// stiff columns one cell thick that touch at edges 30 to 35; a ball with a slot 8 to 11, at 0.49 18. Fibres a thousand times as stiff along
/// as across and turned out of the axes, as in tendons, 25. Chains and sheets one cell thick bend more softly than the coarser grids can:
/// 15 to 75, more with their length.
///
/// **Boxes.** A 3D box all of whose cells hold the same matter, its fibres turned the same way, is solved likewise on coarser grids
/// of its own kind, in a third of the time and of the memory. It begins at the answer that those grids have (full multigrid), which spares one
/// or two iterations for the price of half of one.
///
/// **In 1D and 2D**: conjugate gradients in float64 around one multigrid cycle per displacement component of the separable model
/// (see `relaxed`), which knows every modulus but not how components couple. Components that nothing prescribes anywhere are
/// preconditioned by their diagonal alone, which is slow. Iterations grow with incompressibility, about as (1 - 2 nu)^(-1/2).
///
/// `algorithm` names the way that was taken.
///
/// **Extrapolation** (scene.relaxation.extrapolation = nested). The same question is solved on every second and every fourth node too, each
/// to a quarter of the tolerance, and where the three answers show a ratio, what it says is missing of ever finer lattices is added,
/// node by node (see extrapolate). Errors on 32^3 cells against the limit: pokes 3.8 to 4.5 % -> 1.3 to 1.6 %; pulls and bends, below 0.3 %,
/// by a tenth to a half. It needs axes whose cells can be halved twice, to 4 or more, and body, moves and tractions that are exactly the
/// same on the coarser lattices; limits must not bind. `extrapolated` is the share of nodes where it was used, `message` says why it was
/// nowhere. Reactions and strain energy stay those of the lattice. The error of the algebra may be twice what `residual` says.
///
/// **Limits.** Without limits that the scene asks for there are none. Where they are given, the materials' own or those of failure and
/// the elastic answer breaks them, the answer is the least
/// energy within them, by the method of multipliers on the links that were ever outside: on boxes truncated Newton steps around the
/// multigrid of the box, elsewhere conjugate gradients around the separable model's, both with the penalties of those links beside
/// their own stiffness. Rigid links (both limits one number) are like any other. It begins at the optimum of the same body on every second node, where the numbers of cells can be halved. The state is
/// then brought to the nearest legal one, so it obeys the limits to rounding however it ended. Taut limits do not bind, asked for or not:
/// they stand in for the elasticity that is solved here.
///
/// **Blocks.** Where the scene asks for frames cell by cell (`frame = "blocks"`, 2D and 3D), strains are Biot's, each cell's in a frame
/// that turns with it, and the answer is a least energy of that, not linear in the moves: see docs/large_rotation.md. Moves and loads are
/// put on in increments, each by quasi-Newton descent around one multigrid cycle of the body at rest, turned node by node; energy never
/// rises while handles stay. Reactions and energy are those of the bent body. Limits that the scene asks for are met by a repair at the
/// end, each link in the mean frame of the cells around; where no repair is found, moves and loads are cut back (clamped). `residual`: twice the quasi-Newton estimate of the error in the energy norm;
/// 1e-7 is the least that can be told. Cut short, handles stand where the message says, on their way. Cost of an iteration: that of the
/// cycle and 0.3 to 0.6 us a cell; 250 bytes a node more on 3D boxes.
///
/// @return status done, clamped (requests cut back by binding limits, see admit), refused (the body can still move rigidly; moves that
///         are not finite), budget_reached or interrupted with the state that it had come to. `iterations` of conjugate gradients,
///         those on coarser bodies not counted.
///         `residual`: estimated error in the energy norm over the norm of the answer (Strakos and Tichy 2002, equation 4.4, from
///         the last three steps; in 3D that of the last state, if energies go on falling at the slower of their last two rates, twice
///         for safety); its goal is scene.relaxation.tolerance. Where limits are active, the like estimate at the optimum (on boxes
///         of displacements, relative and Euclidean), or by how much the last step to the nearest legal state changed it, relative
///         and Euclidean, if that is more. `strain_energy` of the state, without the work of
///         contracting fibres; `reaction` with what the limits' multipliers pull; none where the solve was cut short. `message` says when limits
///         are active, `algorithm` how they were met
/// Cost        Boxes: 3 to 4 iterations to 1e-3 at nu = 0.3, 7 at 0.49, of 20 to 80 ns a node on one thread. Other bodies in 3D: 2 to 2.7
///             times as much a node and iteration, and 1.5 to 4 us a node before the first. In 1D and 2D some 12 applications of the
///             operator and cycles to 1e-4 at nu = 0.3; 150 ns a cell and application. Active
///             limits, to 1e-2: on boxes of 65^3 nodes 4 to 7 elastic solves, on smaller ones up to 10; elsewhere 2 to 5 of the general
///             way, the more the more links bind, which is up to 40 of those of its own multigrid
/// Memory      beside the answer 60 to 100 bytes a node on boxes; 350 to 550 a node of matter on other bodies in 3D and 800 at the peak of
///             the preparation, 450 a cell more where fibres turn; 200 bytes a grid point in 1D and 2D. Where limits are active
///             some 350 more, up to 420 on boxes, 550 where they differ from cell to cell
/// Repeatable  same bits for any number of threads; another kind of vector gives other rounding (in 3D: only one that does not fuse
///             products with sums)
/// Source      docs/theory.md, section 3; coarser grids of bodies of any shape: section 7; preconditioning by the separable model: section 3,
///             "Solving LAT"
/// Checked by  tests/deform/relax/coupled_test.cpp, coupled_limits_test.cpp, nested_lattices_test.cpp, box_kernel_test.cpp, box_solver_test.cpp,
///             box_stiffening_test.cpp, matter_level_test.cpp, matter_solver_test.cpp, corotated_elasticity_test.cpp,
///             coupled_blocks_test.cpp, tests/cross_check
Answer solve_coupled(const Scene& scene, const Control& control = {});

} // namespace maille::deform
