#pragma once
/// Text files, read and written whole or not at all, and a folder for files that are needed only for a while.

#include <stdlib.h>

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace maille {

/// What a scene, a material or a study that somebody wrote stays far below [bytes]. As TOML it takes some
/// sixty times its size.
inline constexpr std::int64_t largest_written_text = std::int64_t{16} << 20;

/// The content of a file or a pipe.
/// @param what    it is to be, for the message: "a scene file"
/// @param largest that is read [bytes]: a device has no end
/// @throws InputError  nothing there that can be read; an error of the device on the way (the part that was
///                     read is not the file); more bytes than `largest`
std::string read_text_file(const std::filesystem::path& file, std::string_view what,
                           std::int64_t largest = largest_written_text);

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
