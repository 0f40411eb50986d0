#pragma once
/// Text files, read whole or not at all; the register of files that are opened; temporary files and folders.
///
/// The register is what protects a user's inputs. Every reader notes each file that it opens, by device and
/// inode. An option that writes reserves its output. A file that is both is an error, whichever comes first.
/// Files that Maille wrote and reads again (own files) are not inputs.

#include <stdlib.h>

#include <cstdint>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>

namespace maille {

/// Limit for hand-written scenes, materials and studies, far above real ones [bytes]. Parsed TOML takes some
/// sixty times the size of its text.
inline constexpr std::int64_t largest_written_text = std::int64_t{16} << 20;

/// The content of a file or a pipe, which becomes an input (note_opened).
/// @param what    it is to be, for the message: "a scene file"
/// @param largest that is read [bytes]: a device has no end
/// @throws InputError  nothing there that can be read; an error of the device on the way (the part that was
///                     read is not the file); more bytes than `largest`
std::string read_text_file(const std::filesystem::path& file, std::string_view what,
                           std::int64_t largest = largest_written_text);

/// The same for a file that Maille wrote and writes again, such as the table of a study: it becomes no input.
std::string read_own_text_file(const std::filesystem::path& file, std::string_view what,
                               std::int64_t largest = largest_written_text);

/// Wrong use of a command that only shows when it runs; main turns it into exit code 2.
class UsageError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Every reader calls this for every file that it opens. Files count by device and number, so by whatever
/// name or link; devices and pipes do not count.
/// @throws UsageError where an option names the file as its output (reserve_output)
void note_opened(const std::filesystem::path& file);
/// From now on files that are opened are inputs, which no option can overwrite. Commands call it, once.
void keep_opened_files();
/// The same for a file that is not open yet. A file that is not there is nothing to keep.
void keep_input(const std::filesystem::path& file);
/// True if the name leads to an input.
bool is_kept_input(const std::filesystem::path& file);
/// Says that an option writes a file, so that note_opened() can refuse to read it.
/// @throws UsageError where another option names the same file
void reserve_output(const std::string& option, const std::filesystem::path& file);

/// Lists what is opened as long as it lives.
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

/// Makes an empty file beside `file`, of a name that could not be foreseen; it follows no link.
/// @param temporary  its name: the same ending, a dot before the rest @return its descriptor
/// @throws std::filesystem::filesystem_error
int create_beside(const std::filesystem::path& file, std::filesystem::path& temporary);
/// The host's name as temporary files have it.
std::string name_of_machine();

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text, std::string_view blanks = " \t");

/// An empty folder that goes, with all that is in it, when it is no longer needed.
class WorkFolder {
public:
  /// @param name begins its own name @throws std::runtime_error where the system gives none
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
