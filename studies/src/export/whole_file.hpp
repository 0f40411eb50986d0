#pragma once
/// Atomic writing of files, and protection of input files from being replaced.

#include <exception>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::studies {

/// @brief Lets `write` fill a temporary file next to `file` and renames it once it is complete.
///
/// The temporary file is in the same folder (renaming across file systems would be a copy) and keeps the
/// ending, which some writers check. It is deleted on failure; `file` is then unchanged. If `file` is a
/// symbolic link, its target is replaced, not the link.
///
/// Mode and group of a replaced file are kept.
///
/// @param write  fills the given path, an empty file, and throws on failure
/// @throws exceptions of `write`; std::filesystem::filesystem_error if the folder is missing, `write` has
///         left no file, or renaming fails; UsageError if the file is an input of the run (keep_input)
void write_whole(const std::filesystem::path& file,
                 const std::function<void(const std::filesystem::path&)>& write);

/// Deletes temporary files of write_whole in a folder, from ended processes of this machine.
void remove_unfinished_files(const std::filesystem::path& folder);

/// The same for a text. A device or a pipe is written to directly.
void write_whole(const std::filesystem::path& file, std::string_view text);

/// An exception's message in one line; file errors of the standard library become `FILE: cannot write: why`.
std::string message_of(const std::exception& error);

/// Results exist already, a link has their name, or another process is writing them.
class FolderTaken : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Locks a folder of results for one process; the system releases the lock when the process ends.
class FolderLock {
public:
  enum class Sharing { none, parts };
  /// @param stem     prefix of the names of results; empty: names of warp
  /// @param sharing  parts: other processes may write under other stems at the same time
  /// @param sure     suffixes of files that will be written: existing ones must be Maille's
  /// @throws FolderTaken
  FolderLock(const std::filesystem::path& folder, const std::string& stem, Sharing sharing,
             const std::vector<std::string>& sure = {});
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

private:
  FolderLock() = default;
  void take(const std::filesystem::path& folder, const std::string& name, short kind);

  std::vector<std::pair<int, std::filesystem::path>> locks_; ///< descriptors
};

/// True for a plain file name in the form of Maille's results: STEM_... or STEM.ENDING, with a known ending;
/// without a stem, for names of warp's files.
bool is_name_of_result(std::string_view name, std::string_view stem);
/// True if a result may replace the file: it is empty, or a regular file with Maille's mark for that ending.
/// @param head_of_table for CSV, which has no place for a mark: the beginning of the new table; without one,
/// no CSV is Maille's
bool is_own_result(const std::filesystem::path& file, std::string_view head_of_table = "");
/// @throws FolderTaken if the name of a result, in a folder locked by FolderLock, belongs to a link or to
/// another program's file. @param head first line of the new file
void check_replaced(const std::filesystem::path& file, std::string_view head);
/// Marks a PNG, SVG or MP4 from another library as Maille's. @throws std::filesystem::filesystem_error if it
/// cannot be written or is incomplete
void add_mark(const std::filesystem::path& file);
/// True for a regular file (no link) with Maille's provenance: data sets for viewers and their lists.
bool has_provenance(const std::filesystem::path& file);
/// First comment in lists of data sets (.pvd, .vtm, .pvtu).
inline constexpr std::string_view provenance_of_list = " Provenance: Maille ";
/// Digest of a file's content, for files without provenance: a list of results stores it. Empty for links and
/// unreadable files.
std::string digest_of(const std::filesystem::path& file);
/// Deletes a result and, for a .pvtu, its pieces with provenance (has_provenance()). @pre it is a result
void remove_result(const std::filesystem::path& file);
/// Creates the folder of a .pvtu's pieces and deletes earlier pieces. @throws
/// std::filesystem::filesystem_error if it is or contains a link
void make_folder_of_pieces(const std::filesystem::path& folder);

/// Registers a file under construction for its lifetime, so that a signal that ends the process can delete
/// it. Not more than 16 files at a time, and no paths of more than 4095 bytes.
class UnfinishedFile {
public:
  explicit UnfinishedFile(const std::filesystem::path& file);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

private:
  int place_ = -1;
};

/// Deletes all registered files (UnfinishedFile). Safe in a signal handler.
void remove_unfinished_files() noexcept;

} // namespace maille::studies
