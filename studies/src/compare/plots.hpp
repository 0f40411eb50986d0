#pragma once
/// Plots by Matplotlib, in the middle of a command's work.

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <optional>
#include <string>

namespace maille::studies {

/// Runs the program `maille-curves` (python/maille/_curves.py) on a request, which gets the file as `out`.
/// @param file .svg or .png, replaced at once
/// @return why there is no picture; then the file is as it was
/// @throws std::filesystem::filesystem_error
std::optional<std::string> draw_curves(nlohmann::ordered_json request, const std::filesystem::path& file);

} // namespace maille::studies
