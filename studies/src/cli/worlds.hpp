#pragma once
/// Helpers of commands for worlds.

#include "maille/deform/world/world.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace maille::studies {

/// The initial world. @param file of the scene, for messages
/// @throws InputError if objects overlap or leave the world, which only placing them reveals
deform::World world_of(const WorldScene& scene, const std::filesystem::path& file);

inline constexpr double longest_first_frame = 2; ///< [s]

/// Data for `check` and `explain` about a world with placed objects.
struct PlacedWorld {
  std::int64_t map = 0, objects = 0; ///< [bytes]
  /// Measured times: set-up, and the first frame without a hand, at most `longest_first_frame`.
  double set_up_seconds = 0, frame_seconds = 0;
  /// Per object: fraction thinner than a world cell, where contact is only accurate to one cell [%].
  std::vector<double> thin;
};

PlacedWorld placed(const WorldScene& scene, const std::filesystem::path& file);

} // namespace maille::studies
