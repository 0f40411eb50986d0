#pragma once
/// What commands say of warped images.

#include "export/warp_files.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace maille::studies {

/// The labels, a row each, what became of the voxels, and the warnings.
std::string in_words(const WarpedFiles& made);
/// The same for programs; `files` are names without their folder.
nlohmann::ordered_json json(const WarpedFiles& made);

} // namespace maille::studies
