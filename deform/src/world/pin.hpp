#pragma once
/// A node in contact.

#include "maille/scene/grid.hpp"

#include <cstdint>

namespace maille::deform {

/// One component of a node, kept on its side of a face of the map; of a turned object all of its components.
struct Pin {
  std::int32_t voxel = 0;
  int axis = 0;      ///< of the face, in the world
  int direction = 1; ///< from the node to the wall: -1 or 1
  Vec3 at{}; ///< displacement in the object's frame [m]; of an object that is not turned `axis` alone counts
  double rest = 0; ///< of the movement that it could not make along the axis, signed [cells]
  double pressure =
      0; ///< with which it presses on the wall, by the last answer [N]; less than 0: it is pulled
  bool is_asked = false; ///< a movement that another object asks for: there is no wall yet
};

} // namespace maille::deform
