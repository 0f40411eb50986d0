#pragma once
/// A node in contact.

#include "maille/scene/grid.hpp"

#include <cstdint>
#include <optional>

namespace maille::deform {

/// One component of a node, kept on its side of a face of the map; of a turned object all of its components.
struct Pin {
  std::int32_t voxel = 0;
  int axis = 0;      ///< of the face, in the world
  int direction = 1; ///< from the node to the wall: -1 or 1
  /// Displacement in the object's frame [m]. Of an object that is not turned `axis` counts; the others where
  /// friction holds the node.
  Vec3 at{};
  double rest = 0; ///< of the movement that it could not make along the axis, signed [cells]
  double pressure =
      0; ///< with which it presses on the wall, by the last answer [N]; less than 0: it is pulled
  /// Where friction aside it would be, and where it would be if friction held anything: displacements in the
  /// object's frame [m].
  Vec3 free{}, stuck{};
  double hold = 1;       ///< the part of the way from one to the other at which it is held
  Vec3 grip{};           ///< of the wall on the node across the axis, by the last answer, object's frame [N]
  bool is_asked = false; ///< a movement that another object asks for: there is no wall yet
  /// What a point of the surface beside the node presses on; else it is the cell beside the node's own.
  std::optional<Index3> wall{};
  bool stays = false; ///< for the rest of the frame, whether or not its wall is still there: see Settling
};

} // namespace maille::deform
