#pragma once
/// Scenes of the prototypes of Gibson 1995, played from their files.

#include "maille/scene/world/world_scene.hpp"
#include "play/play.hpp"
#include "support/kit.hpp"

namespace maille::test {

using studies::PlayedFrame;
using studies::Player;

inline constexpr double mm = 1e-3;

inline const std::filesystem::path world_folder = std::filesystem::path(MAILLE_SCENES) / "world";

/// Frames have no time budget, so that results do not depend on the machine.
inline Player player_of(const char* scene, const char* trajectory) {
  WorldScene world = read_world_scene(world_folder / scene);
  world.frame_budget.reset();
  Trajectory path = read_trajectory(world_folder / trajectory, world);
  return {deform::World(std::move(world)), std::move(path)};
}

inline int object_named(const deform::World& world, const std::string& name) {
  for (int i = 0; i < world.n_objects(); ++i)
    if (world.scene().objects[static_cast<std::size_t>(i)].name == name)
      return i;
  throw std::out_of_range(name);
}

/// Plays all that is left; nothing may ever lie in anything else.
inline std::vector<PlayedFrame> play_to_the_end(Player& player) {
  std::vector<PlayedFrame> frames;
  while (!player.is_at_end()) {
    frames.push_back(player.next());
    EXPECT_EQ(player.world().n_penetrations(), 0) << "in frame " << frames.back().number;
    EXPECT_TRUE(is_converged(frames.back().status))
        << frames.back().message << " in frame " << frames.back().number;
  }
  return frames;
}

inline double done_of(const PlayedFrame& frame) {
  return frame.drives.empty() ? 1 : frame.drives[0].fraction;
}

} // namespace maille::test
