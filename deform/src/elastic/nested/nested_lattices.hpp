#pragma once
/// `coupled` on nested lattices, and from them towards finer ones.

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

/// Adds to `u`, the answer with spacing h, what is missing of the limit, as far as lattices of spacing 2h and
/// 4h show it. If an error falls by the ratio q from one lattice to the next, u_h - u_2h = q (u_2h - u_4h),
/// then u_h lacks q / (1 - q) (u_h - u_2h). At the edge of a patch that is held or pushed q is 1/2, elsewhere
/// 1/4 and between. So q is observed node by node of the coarsest lattice, as (u_h - u_2h).(u_2h - u_4h) /
/// |u_2h - u_4h|^2, and what is missing is interpolated from the nodes of 2h.
///
/// Guarded: nothing changes where the two differences point apart (q <= 0); no q counts as more than 1/2;
/// where the coarser difference just vanishes (q > 3/4) the q of the whole body counts. Nothing changes at
/// all if the q of the whole body is no ratio of a sequence that settles, 0 < q <= 3/4, or if u_h and u_2h
/// differ by more than a quarter (a push at a single node has no limit but 0).
///
/// Prescribed components stay what they are. Same bits for any number of threads.
///
/// Source  Aitken 1926, applied node by node; docs/theory.md, section 3 (Nested-lattice extrapolation)
/// Gains   docs/relax.md
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
