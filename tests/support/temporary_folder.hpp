#pragma once
/// An empty folder that goes when the test ends.

#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <stdlib.h>
#include <string>

namespace maille::test {

class TemporaryFolder {
public:
  TemporaryFolder() {
    std::string name = (std::filesystem::path(testing::TempDir()) / "maille_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw std::runtime_error("cannot make a temporary folder " + name);
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }
  bool is_empty() const { return std::filesystem::is_empty(path_); }

private:
  std::filesystem::path path_;
};

} // namespace maille::test
