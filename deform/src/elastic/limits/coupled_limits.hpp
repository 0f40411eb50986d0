#pragma once
/// The last step of every algorithm of `coupled`: the limits of the links, from the optimum of the body on
/// every second node on.

#include "elastic/krylov/coupled_system.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/limits/constrained_minimum.hpp"

namespace maille::deform {

/// Changes `u` to the interpolated optimum of the coarser body, itself begun like this, and gives `minimum`
/// its multipliers. Which links bind, and how much, is found there at an eighth of the price. It is a start
/// only: that moves, materials and holes are known to half as many nodes costs iterations, not accuracy.
/// @param u holds the prescribed values, and keeps them
/// @return  false, and nothing is changed, if the body has an odd number of cells along an axis, or too few,
///          or if what is held of the coarser one lets it move rigidly, or if it was stopped
bool start_from_coarser(const CoupledTask& task, ConstrainedMinimum& minimum, Displacement& u);

/// Where the elastic answer breaks the limits, changes it to the least energy within them (see
/// ConstrainedMinimum), and then to the nearest feasible state, of which strain energy, residual, reactions
/// and message of the answer speak thereafter. Otherwise changes nothing.
/// @param is_converged the answer is the elastic one; if false the state only becomes feasible
/// @return    whether the answer is what was asked for
bool obey_limits(const CoupledTask& task, CoupledSystem& system, bool is_converged, Displacement& u,
                 Answer& answer);

} // namespace maille::deform
