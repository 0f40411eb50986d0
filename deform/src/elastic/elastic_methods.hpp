#pragma once
/// `relaxed`: the relaxation of Gibson (1995) with the material's weights, by multigrid. `coupled`: full
/// anisotropic elasticity on the lattice. Both within limits where a scene asks for some.
///
/// A method refuses what it cannot carry, cuts prescribed values back to what limits permit, solves in an
/// arena that counts its memory, and ends with a state that is feasible however it ended. The forecasts of
/// memory below refuse a scene that is far too large before it starts.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <cstdint>

namespace maille::deform {

class KeptBody;

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

/// Minimises linear elastic energy under holds, moves, loads and contracting fibres: any stiffness and fibre
/// direction per cell, 1D, 2D (plane strain or stress) and 3D, bodies of any shape; finite
/// strain by the laws of materials. Within limits that the scene asks for, taut ones excepted.
///
/// @return status done, clamped (requests clipped, see clip; at finite strain also where no feasible state
///         was found), refused (rigid motion left, moves not finite), budget_reached, interrupted, failed;
///         feasible however it ends. `residual`: estimated relative error in the energy norm, with active
///         limits also of displacements; its goal is scene.relaxation.tolerance. `iterations`: of conjugate
///         gradients, without coarser bodies. `strain_energy` without the work of contracting fibres;
///         `reaction` with what limits pull, none where cut short. `algorithm` says the way; `extrapolated`
///         the share of nodes where nested lattices were used
/// Cost, memory  docs/relax.md: 20 to 80 ns a node and iteration and 60 to 100 bytes a node on boxes
/// Repeatable  same bits for any number of threads; another kind of vector may round otherwise
/// Source      docs/theory.md, sections 3 (LAT, Solving LAT, Nested-lattice extrapolation), 4 and 7
/// Checked by  tests/deform/elastic/ (docs/theory.md, section 8), tests/cross_check
///
/// @param kept cache of the scene's body and threads; null: none
Answer solve_coupled(const Scene& scene, const Control& control = {}, KeptBody* kept = nullptr);
/// The same for a question that solve_coupled() supports. @pre small strain
Answer solve_carried(const Scene& scene, const Control& control, KeptBody* kept);

/// True if `n_ranks` ranks answer a scene together, each with a slab of a body of any shape; see Slabs.
bool is_shared_by_ranks(const Scene& scene, int n_ranks);

/// Forecasts of the peak, with headroom [bytes].
std::int64_t bytes_for_relaxed(const Scene& scene);
std::int64_t bytes_for_coupled(const Scene& scene);
/// Peak on the first of `n_ranks` ranks, which holds the coarser grids.
std::int64_t bytes_for_coupled(const Scene& scene, int n_ranks);

} // namespace maille::deform
