#pragma once
/// Random worlds of several objects, and what hands do in them, frame by frame.

#include "checks/random_scene.hpp"
#include "maille/deform/world/world.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maille::lab {

/// What is asked of a world in one frame.
struct PlayFrame {
  /// Of rigid objects `about` counts from the object's lattice as the frame finds it. A hand that leads by a
  /// spring begins where the object then is, in place of `lead->hand`.
  std::vector<deform::Drive> drives;
  std::vector<int> released;          ///< objects, before the drives
  std::optional<std::int64_t> rounds; ///< that the frame may take
};

/// A world and what is played in it.
struct WorldPlay {
  WorldScene scene;
  std::vector<PlayFrame> frames;
  double frame_seconds = 1.0 / 30; ///< where the world has dynamics [s]
};

/// A world of up to six objects in one, two or three dimensions, and one to four frames: fixed, rigid and
/// deformable objects, boxes or with holes, turned or straight, their spacing 1/4 to 4 of the world's; by
/// every law of contact and every method that knows it, friction 0 to 10, at times with dynamics; hands that
/// push, turn, slide, lead by a spring and let go, from a hundredth of a cell to through everything. No two
/// objects overlap at first, and World takes all of it.
WorldPlay random_world(Choices& choices);

/// The play as people can read it, a line an object and a drive.
std::string in_words(const WorldPlay& play);

} // namespace maille::lab
