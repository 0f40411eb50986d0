#pragma once
/// Files that appear whole or not at all.

#include <filesystem>
#include <functional>
#include <string_view>

namespace maille::studies {

/// @brief Lets `write` fill a new file beside `file` and puts it in place once it is whole.
///
/// The temporary file is in the same folder (a rename across file systems is a copy) and keeps the ending,
/// which some writers look at. It is removed when anything fails; `file` is then as it was before. Where
/// `file` is a symbolic link, the file that it leads to is replaced, not the link.
///
/// Mode and group are those of the file that is replaced.
///
/// @param write  fills the path that it is given, an empty file, and throws if it cannot
/// @throws what `write` throws; std::filesystem::filesystem_error if the folder is missing, `write` left no
///         file, the file cannot be put in place, or is one that the run reads (keep_input)
void write_whole(const std::filesystem::path& file,
                 const std::function<void(const std::filesystem::path&)>& write);

/// Removes what processes of this machine that are no more left of write_whole in a folder.
void remove_unfinished_files(const std::filesystem::path& folder);

/// The same for a text. A device or a pipe in the file's place is written to as it is.
void write_whole(const std::filesystem::path& file, std::string_view text);

} // namespace maille::studies
