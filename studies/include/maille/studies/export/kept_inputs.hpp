#pragma once
/// Files that a run reads, so that its results do not take their place.

#include <filesystem>

namespace maille::studies {

/// From now on write_whole() refuses to replace the file, by whatever name or link. One that is not there is
/// nothing to keep.
void keep_input(const std::filesystem::path& file);

/// True if the name leads to a file that is kept.
bool is_kept_input(const std::filesystem::path& file);

} // namespace maille::studies
