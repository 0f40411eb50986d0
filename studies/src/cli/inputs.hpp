#pragma once
/// What a command reads, so that no option can put a result in its place.

#include <filesystem>
#include <string>
#include <vector>

namespace maille::studies {

/// Keeps (keep_input) the files that a command line names and, of scenes, worlds, studies and trajectories
/// (TOML), every file that they name in turn: images, their data, materials, scenes. What cannot be read is
/// left to its reader to report.
void keep_inputs(const std::vector<std::filesystem::path>& files);

/// The text of a scene file; nothing where it can no longer be read: part of it would be another scene.
std::string scene_text_of(const std::filesystem::path& file);

} // namespace maille::studies
