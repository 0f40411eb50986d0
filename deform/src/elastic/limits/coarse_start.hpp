#pragma once
/// Where the search for the least energy within limits begins: at the optimum of the same body on every
/// second node.

#include "elastic/limits/coupled_optimum.hpp"

namespace maille::deform {

/// Changes `u` to the interpolated optimum of the coarser body, itself begun like this, and gives `optimum`
/// its multipliers. Which links bind, and how much, is found there at an eighth of the price. It is a start
/// only: that moves, materials and holes are known to half as many nodes costs iterations, not accuracy.
/// @param u holds the prescribed values, and keeps them
/// @return  false, and nothing is changed, if the body has an odd number of cells along an axis, or too few,
///          or if what is held of the coarser one lets it move rigidly, or if it was stopped
bool start_from_coarser(const CoupledTask& task, CoupledOptimum& optimum, Displacement& u);

} // namespace maille::deform
