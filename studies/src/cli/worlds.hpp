#pragma once
/// What commands take from the rooms of worlds and of volumes.

#include "maille/deform/world/world.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace maille::studies {

/// The world as it begins. @param file of the scene, for messages
/// @throws InputError where objects share cells or leave the world, which only shows when they are placed
deform::World world_of(const WorldScene& scene, const std::filesystem::path& file);

inline constexpr double longest_first_frame = 2; ///< [s]

/// What `check` and `explain` say of a world whose objects are placed.
struct PlacedWorld {
  std::int64_t map = 0, objects = 0; ///< [bytes]
  /// Measured: the world set up, and its first frame without a hand, which ends after `longest_first_frame`.
  double set_up_seconds = 0, frame_seconds = 0;
  /// Per object: the part thinner than a cell of the world, where contact is accurate only to a cell [%].
  std::vector<double> thin;
};

PlacedWorld placed(const WorldScene& scene, const std::filesystem::path& file);

} // namespace maille::studies
