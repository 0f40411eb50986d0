#pragma once
/// The same question on a lattice that is turned to the body's mean fibre direction, for methods whose links
/// know only the lattice's axes.

#include "maille/scene/scene.hpp"

#include <string>
#include <variant>

namespace maille {

/// Why a scene cannot be put on a turned lattice.
struct LatticeRefusal {
  std::string expected, found;
};

/// The direction that the fibres of the body's matter have in common, signs aside: the first principal axis
/// of the mean of f f^T, turned to the side of +x. @param agreement how much of the fibres it holds: 1 where
/// all are alike, 1 / dimension where none stands out
Vec3 mean_fibre(const Specimen& specimen, double& agreement);

/// A copy of `scene` on a lattice whose x axis is mean_fibre(): the smallest turn of the axis that is nearest
/// to it, which then is called x. A scene whose fibres run along x already comes back as it is.
///
/// Shape    same spacings, centred on the body's box; a cell holds what the scene has at its middle, so an
///          oblique face is a stair, off by up to 0.87 spacings, and right in the mean
/// Holds    and moves: a node takes what is prescribed for the scene's nearest node, turned; moves that turn
///          are placed anew
/// Frame    everything in the result is in the turned lattice's frame; given limits are along the axes of
///          either. specimen.placement takes it to the world
/// Refused  in 1D; where fibres leave the plane of a 2D scene or have no common direction (agreement below
///          0.6); tractions; conditions on some axes of a node that the turn mixes with others, or too small
///          for any node
/// Cost     O(cells of both lattices)
std::variant<Scene, LatticeRefusal> on_fibre_lattice(const Scene& scene);

} // namespace maille
