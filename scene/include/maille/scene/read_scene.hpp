#pragma once
/// From a scene file to a Scene, or to every fault in it at once.

#include "maille/scene/scene.hpp"

#include <filesystem>
#include <string_view>

namespace maille {

/// Reads a scene file; paths of images are relative to it.
/// @throws InputError with every fault (file, line, key, expected, found)
Scene read_scene(const std::filesystem::path& file);

/// The same from text; `file` gives the name for messages and the folder for images.
Scene parse_scene(std::string_view text, const std::filesystem::path& file = "scene.toml");

} // namespace maille
