#pragma once
/// Where the search for the least energy within limits begins: at the optimum of the same body on every second node.

#include "relax/coupled_optimum.hpp"

#include <optional>

namespace maille::deform {

/// Changes `u` to the interpolated optimum of the coarser body, itself begun like this, and gives `optimum` its multipliers. Which
/// links bind, and how much, is found there at an eighth of the price. It is a start only: that moves, materials and holes are known
/// to half as many nodes costs iterations, not accuracy.
/// @param u holds the prescribed values, and keeps them
/// @return  false, and nothing is changed, if the body has an odd number of cells along an axis, or too few, or if what is held of the
///          coarser one lets it move rigidly, or if it was stopped
bool start_from_coarser(const CoupledTask& task, CoupledOptimum& optimum, Displacement& u);

/// The same body on every second node, to a tolerance of 1e-2: a cell holds what most of its parts hold, and what is prescribed at nodes
/// that are left out is forgotten.
/// @param prescribed the scene's, or what limits have left of it
/// @return nothing where start_from_coarser has none
std::optional<Scene> coarser_scene(const Scene& fine, const std::vector<Prescribed>& prescribed);

/// Linear, from the coarse nodes that are nodes of the body; where there are none `to` stays.
/// @pre fine has twice the cells of coarse along every axis
void interpolate_from_coarser(const Specimen& coarse, const Displacement& from, const Specimen& fine,
                              Displacement& to);

} // namespace maille::deform
