#pragma once
/// Files that appear whole or not at all, and that do not take the place of what a run reads.

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

/// From now on write_whole() refuses to replace the file, by whatever name or link. One that is not there is
/// nothing to keep.
void keep_input(const std::filesystem::path& file);

/// True if the name leads to a file that is kept.
bool is_kept_input(const std::filesystem::path& file);

/// Knows of a file that is being written for as long as it lives, so that a signal that ends the process can
/// take it away. Of more than 16 at a time, or of paths of more than 4095 bytes, it knows nothing.
class UnfinishedFile {
public:
  explicit UnfinishedFile(const std::filesystem::path& file);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

private:
  int place_ = -1;
};

/// Removes all UnfinishedFiles. A signal handler may call it.
void remove_unfinished_files() noexcept;

} // namespace maille::studies
