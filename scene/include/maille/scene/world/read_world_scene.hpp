#pragma once
/// From a scene file with a [world] to a WorldScene, or to every fault in it at once.

#include "maille/scene/world/world_scene.hpp"

#include <filesystem>
#include <string_view>

namespace maille {

/// Whether a file can be read, is TOML, and has a [world]: then it is for read_world_scene, else for
/// read_scene, which says what is wrong.
bool is_world_scene(const std::filesystem::path& file);

/// Reads a scene of objects; docs/world.md says what stands in it. Paths of images are relative to it.
/// @throws InputError with every fault (file, line, key, expected, found)
WorldScene read_world_scene(const std::filesystem::path& file);

/// The same from text; `file` gives the name for messages and the folder for images.
WorldScene parse_world_scene(std::string_view text, const std::filesystem::path& file = "scene.toml");

} // namespace maille
