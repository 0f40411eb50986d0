#pragma once
/// Worlds as they begin: what commands take from them, and say of them.

#include "maille/deform/world/world.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace maille::studies {

/// The world as it begins. @param file of the scene, for messages
/// @throws InputError where objects share cells or leave the world, which only shows when they are placed
deform::World world_of(const WorldScene& scene, const std::filesystem::path& file);

/// What `check` and `explain` say of a world whose objects are placed.
struct PlacedWorld {
  std::int64_t map = 0, objects = 0; ///< [bytes]
  /// Of an object each: the part that is thinner than a cell of the world, and kept apart to a cell only [%].
  std::vector<double> thin;
};

/// Weak, as the commands of which maille-studies alone has the whole (cli/commands.hpp). @throws InputError
[[gnu::weak]] PlacedWorld placed(const WorldScene& scene, const std::filesystem::path& file);

} // namespace maille::studies
