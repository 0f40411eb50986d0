#pragma once
/// Plots by Matplotlib, from a running command.

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <optional>
#include <string>

namespace maille::studies {

/// Runs the program `maille-curves` (python/maille/_curves.py) on a request, with the file as its `out`.
/// @param file .svg or .png, replaced atomically
/// @return the reason of a failure, or nothing; after a failure the file is unchanged
/// @throws std::filesystem::filesystem_error
std::optional<std::string> draw_curves(nlohmann::ordered_json request, const std::filesystem::path& file);

} // namespace maille::studies
