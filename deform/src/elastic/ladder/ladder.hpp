#pragma once
/// The one elastic solver for all bodies: rungs of rising cost and resolution.
///
/// Rungs, in the order in which they are tried:
///   1. mixed precision: rounds in float32 around the body's multigrid (MixedSolver). Very slender bodies
///      skip it (needs_float64);
///   2. a sparse Cholesky factor in float64, if it is small. Rung 1 hands over to it if it stalls, or if the
///      factor has become cheaper (`should_fall_back`);
///   3. float64 around the multigrid of rung 1;
///   4. float64 around the componentwise multigrid. Bodies in 1D and 2D begin here.
///
/// Every rung ends by energy and reactions; limits follow (solve_within_limits). The functions below are
/// where a kind of body is chosen.

#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/mixed_solver.hpp"

#include <memory>

namespace maille::deform {

/// Operator of the task's body with its quickest preconditioner. @param task must outlive it
std::shared_ptr<ElasticOperator> make_operator(const CoupledTask& task);
/// The same with the preconditioner that knows penalties best: a factor for slender bodies, else the
/// componentwise multigrid, whose coarse links carry penalties exactly. A body's own multigrid carries them
/// inaccurately and takes up to eight times the iterations.
std::shared_ptr<PenalizedOperator> make_operator_within_limits(const CoupledTask& task);

/// The elastic answer of a body without ties, whatever its limits. @pre 1D, 2D or 3D
CoupledAlgorithm solve_on_ladder;

/// True if float32 cannot distinguish bending of the body from rigid motion. @pre dimension 3
bool needs_float64(const Scene& scene);

} // namespace maille::deform
