#pragma once
/// Richardson extrapolation of `coupled` from nested lattices towards zero spacing.
///
/// Adds to `u`, the answer at spacing h, its estimated distance from the limit, from answers at spacings 2h
/// and 4h. If the error falls by the ratio q from one lattice to the next, u_h - u_2h = q (u_2h - u_4h), then
/// u_h lacks q / (1 - q) (u_h - u_2h). At the edge of a held or pushed patch q is 1/2, elsewhere 1/4 to 1/2.
/// So q is estimated at each node of the coarsest lattice, as (u_h - u_2h).(u_2h - u_4h) / |u_2h - u_4h|^2,
/// and the correction is interpolated from the nodes of 2h.
///
/// Guards: no change where the two differences point apart (q <= 0); q is at most 1/2; where the coarser
/// difference almost vanishes (q > 3/4) the q of the whole body is used. No change at all if the q of the
/// whole body is outside 0 < q <= 3/4, or if u_h and u_2h differ by more than a quarter (a push at a single
/// node has the limit 0).
///
/// Prescribed components do not change. Same bits for any number of threads.
///
/// Source  Aitken 1926, applied node by node; docs/theory.md, section 3 (Nested-lattice extrapolation)
/// Gains   docs/relax.md

#include "elastic/krylov/coupled_task.hpp"

#include <string>

namespace maille::deform {

/// The answer to one question on one lattice.
struct LatticeAnswer {
  const Specimen& body;
  const Displacement& u;
};

struct Extrapolated {
  double share = 0;   ///< of the coarsest lattice's nodes that are free to move: those that showed a ratio
  std::string reason; ///< why no node was extrapolated; empty otherwise
};

/// Adds to `u` its estimated distance from the limit of zero spacing. See the top of the file.
Extrapolated extrapolate(const LatticeAnswer& twice, const LatticeAnswer& four_times, const CoupledTask& task,
                         Displacement& u);

/// Answers the task by `way`, as scene.relaxation.extrapolation asks.
///
/// Extrapolation takes the answers on every second and every fourth node (see extrapolate), provided that the
/// body, what is prescribed and what pulls are exactly the same there; they are the start too. Where that is
/// not so, or limits are active, the message says so, and the answer is that of its lattice. Limits that only
/// the extrapolated answer breaks are projected. Strain energy and reactions stay those of the lattice.
///
/// @return as CoupledAlgorithm
bool solve_on_nested_lattices(const CoupledTask& task, CoupledAlgorithm& way, Answer& answer);

} // namespace maille::deform
