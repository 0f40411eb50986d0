#pragma once
/// An empty folder of a test's own, or a fuzzer's, that goes when it ends.

#include "maille/materials/text_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

namespace maille::test {

class TemporaryFolder : public WorkFolder {
public:
  TemporaryFolder() : WorkFolder("maille") {}
  bool is_empty() const { return std::filesystem::is_empty(path()); }
  /// Writes a file into it. @return the file's path
  std::filesystem::path write(const std::string& name, std::string_view content) const {
    std::ofstream(path() / name, std::ios::binary) << content;
    return path() / name;
  }
};

/// All bytes of a file; empty if it cannot be opened.
inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace maille::test
