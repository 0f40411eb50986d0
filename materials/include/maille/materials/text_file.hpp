#pragma once
/// Text files, read completely or not at all; the register of opened files; temporary files and folders.
///
/// The register protects a user's inputs. Every reader registers each file that it opens, by device and
/// inode. An option that writes reserves its output. A file that is both is an error, in either order. Files
/// that Maille wrote and reads again (own files) are not inputs.

#include <stdlib.h>

#include <cstdint>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>

namespace maille {

/// Size limit for hand-written scenes, materials and studies, far above real ones [bytes]. Parsed TOML takes
/// about sixty times the size of its text.
inline constexpr std::int64_t largest_written_text = std::int64_t{16} << 20;

/// Reads a file or a pipe, which becomes an input (note_opened).
/// @param what    kind of file, for the message: "a scene file"
/// @param largest size limit [bytes], because devices are endless
/// @throws InputError  not readable; a read error (a partial file is not returned); more bytes than `largest`
std::string read_text_file(const std::filesystem::path& file, std::string_view what,
                           std::int64_t largest = largest_written_text);

/// The same for a file that Maille wrote and overwrites, such as the table of a study: it is no input.
std::string read_own_text_file(const std::filesystem::path& file, std::string_view what,
                               std::int64_t largest = largest_written_text);

/// Wrong use of a command that is detected at run time; main returns exit code 2.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Registers an opened file; every reader calls it. Files are identified by device and inode, independent of
/// name and link; devices and pipes are ignored.
/// @throws UsageError if an option names the file as its output (reserve_output)
void note_opened(const std::filesystem::path& file);
/// Starts to treat opened files as inputs, which no option can overwrite. Commands call it once.
void keep_opened_files();
/// The same for a file that is not open yet; ignored if it does not exist.
void keep_input(const std::filesystem::path& file);
/// True if the name leads to an input.
bool is_kept_input(const std::filesystem::path& file);
/// Registers a file as output of an option, so that note_opened() can refuse to read it.
/// @throws UsageError if another option names the same file
void reserve_output(const std::string& option, const std::filesystem::path& file);

/// Lists the files that are opened during its lifetime.
class OpenedFiles {
public:
  OpenedFiles();
  ~OpenedFiles();
  OpenedFiles(const OpenedFiles&) = delete;
  OpenedFiles& operator=(const OpenedFiles&) = delete;
  const std::set<std::filesystem::path>& files() const { return files_; } ///< absolute

private:
  std::set<std::filesystem::path> files_;
};

/// Makes an empty file beside `file` with an unpredictable name; it follows no link.
/// @param temporary  its name: the same ending, a dot before the rest @return its descriptor
/// @throws std::filesystem::filesystem_error
int create_beside(const std::filesystem::path& file, std::filesystem::path& temporary);
/// The host name as used in names of temporary files.
std::string name_of_machine();

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// An empty folder that the destructor deletes with its content.
class WorkFolder {
public:
  /// @param name prefix of its name @throws std::runtime_error if the system provides none
  explicit WorkFolder(const std::string& name) {
    std::string path = (std::filesystem::temp_directory_path() / (name + "_XXXXXX")).string();
    if (mkdtemp(path.data()) == nullptr)
      throw std::runtime_error("cannot make a temporary folder " + path);
    path_ = path;
  }
  ~WorkFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

private:
  std::filesystem::path path_;
};

} // namespace maille
