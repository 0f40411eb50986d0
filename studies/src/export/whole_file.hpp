#pragma once
/// Files that appear whole or not at all, and that do not take the place of what a run reads.

#include <exception>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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
///         file, or the file cannot be put in place; UsageError if the run reads that file (keep_input)
void write_whole(const std::filesystem::path& file,
                 const std::function<void(const std::filesystem::path&)>& write);

/// Removes what processes of this machine that are no more left of write_whole in a folder.
void remove_unfinished_files(const std::filesystem::path& folder);

/// The same for a text. A device or a pipe in the file's place is written to as it is.
void write_whole(const std::filesystem::path& file, std::string_view text);

/// A message in one line; those of the standard library about files in our words: `FILE: cannot write: why`.
std::string message_of(const std::exception& error);

/// Results are there already, a link is in their place, or another process is writing them.
class FolderTaken : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Holds a folder of results for one process as long as it lives; the system drops it when the process dies.
class FolderLock {
public:
  enum class Sharing { none, parts };
  /// @param stem     begins the names of the results; empty: those of warp
  /// @param sharing  parts: others may write under other stems at the same time
  /// @param sure     ends of names that will be written: what stands there has to be Maille's
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

/// True of one plain name of the form of Maille's results: STEM_... or STEM.ENDING, with an ending of theirs;
/// without a stem, of warp's files.
bool is_name_of_result(std::string_view name, std::string_view stem);
/// True if a result may take the file's place: it is empty, or a regular file with the mark of Maille's files
/// of that ending. @param head_of_table of CSV, which has no place for a mark: a table begins with it
bool is_own_result(const std::filesystem::path& file, std::string_view head_of_table = "");
/// @throws FolderTaken where a name of a result, in a folder that a FolderLock holds, is a link's or another
/// program's file. @param head first line of what takes the place
void check_replaced(const std::filesystem::path& file, std::string_view head);
/// Marks a PNG, SVG or MP4, which other libraries write, as Maille's. @throws
/// std::filesystem::filesystem_error where it cannot be written or is not whole
void add_mark(const std::filesystem::path& file);
/// True if a regular file, no link, holds Maille's provenance: data sets for viewers and lists of them do.
bool has_provenance(const std::filesystem::path& file);
/// The comment that lists of data sets (.pvd, .vtm, .pvtu) begin with.
inline constexpr std::string_view provenance_of_list = " Provenance: Maille ";
/// Digest of a file's content, for files that cannot hold provenance: a list of results has it. Empty
/// where the file is a link or cannot be read.
std::string digest_of(const std::filesystem::path& file);
/// Removes one result and, of a .pvtu, the pieces that has_provenance() is true of. @pre it is a result
void remove_result(const std::filesystem::path& file);
/// Makes the folder of a .pvtu's pieces, without earlier pieces. @throws std::filesystem::filesystem_error
/// where it is a link, or holds links
void make_folder_of_pieces(const std::filesystem::path& folder);

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
