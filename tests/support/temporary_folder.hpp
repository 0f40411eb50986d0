#pragma once
/// A temporary folder of a test or fuzzer, deleted at its end; a full disk.

#include "maille/materials/text_file.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <sys/resource.h>

namespace maille::test {

class TemporaryFolder : public WorkFolder {
public:
  TemporaryFolder() : WorkFolder("maille") {}
  bool is_empty() const { return std::filesystem::is_empty(path()); }
  /// Writes a file to it and creates subfolders. @return the path of the file
  std::filesystem::path write(const std::string& name, std::string_view content) const {
    const std::filesystem::path file = path() / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
};

/// All bytes of a file; empty if it cannot be opened.
inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Simulates a full disk: while it lives, no file of this process grows beyond this number of bytes.
class FullDisk {
public:
  explicit FullDisk(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limited{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limited);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }

private:
  rlimit before_{};
};

} // namespace maille::test
