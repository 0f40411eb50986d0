#pragma once
/// Output of commands about warped images.

#include "export/warp_files.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace maille::studies {

/// One row per label, counts of mapped voxels, and warnings.
std::string in_words(const WarpedFiles& made);
/// The same as JSON; `files` are names without their folder.
nlohmann::ordered_json json(const WarpedFiles& made);

} // namespace maille::studies
