#pragma once
/// The last step of every way of `coupled`: the limits of the links.

#include "elastic/krylov/coupled_system.hpp"
#include "elastic/krylov/coupled_task.hpp"

namespace maille::deform {

/// Where the elastic answer breaks the limits, changes it to the least energy within them (see
/// CoupledOptimum), and then to the nearest legal state, of which strain energy, residual, reactions and
/// message of the answer speak thereafter. Otherwise changes nothing.
/// @param is_converged the answer is the elastic one; if false the state only becomes legal
/// @return    whether the answer is what was asked for
bool obey_limits(const CoupledTask& task, CoupledSystem& system, bool is_converged, Displacement& u,
                 Answer& answer);

} // namespace maille::deform
