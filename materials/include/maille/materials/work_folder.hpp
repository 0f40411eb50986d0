#pragma once
/// A folder for files that are needed only for a while.

#include <filesystem>
#include <stdexcept>
#include <string>

#include <stdlib.h>

namespace maille {

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
