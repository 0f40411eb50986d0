#pragma once
/// `coupled` on nested lattices, and from them towards finer ones.

#include "elastic/krylov/coupled_task.hpp"

namespace maille::deform {

/// Answers the task by `way`, as scene.relaxation.extrapolation asks.
///
/// Extrapolation takes the answers on every second and every fourth node (see extrapolate), provided that the
/// body, what is prescribed and what pulls are exactly the same there; they are the start too. Where that is
/// not so, or limits are active, the message says so, and the answer is that of its lattice. Limits that only
/// the extrapolated answer breaks are repaired. Strain energy and reactions stay those of the lattice.
///
/// @return as CoupledWay
bool solve_on_nested_lattices(const CoupledTask& task, CoupledWay& way, Answer& answer);

} // namespace maille::deform
