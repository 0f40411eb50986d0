#pragma once
/// What commands say of warped images. Weak: in the program maille-studies alone.

#include "export/warp_files.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace maille::studies {

/// The labels, a row each, what became of the voxels, and the warnings.
[[gnu::weak]] std::string in_words(const WarpedFiles& made);
/// The same for programs; `files` are names without their folder.
[[gnu::weak]] nlohmann::ordered_json json(const WarpedFiles& made);

} // namespace maille::studies
