#pragma once
/// What the fuzzers share. A reader may return or throw InputError; anything else ends the fuzzer, which is a find.

#include "maille/materials/fault.hpp"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include <stdlib.h>

namespace maille::fuzzing {

/// Where files lie that inputs may name: MAILLE_FIXTURES.
inline const std::filesystem::path& fixtures() {
  static const std::filesystem::path folder = MAILLE_FIXTURES;
  return folder;
}

inline void require(bool holds, const char* what) {
  if (holds)
    return;
  std::fprintf(stderr, "broken: %s\n", what);
  std::abort();
}

/// Every fault says what was expected and what was found.
inline void check(const InputError& error) {
  require(!error.faults().empty() && *error.what() != '\0', "an InputError has faults");
  for (const Fault& fault : error.faults())
    require(!fault.file.empty() && !fault.expected.empty() && !fault.found.empty(),
            "a fault says what is wrong");
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A file of this process for readers that take no text, written anew for every input.
class ScratchFile {
public:
  explicit ScratchFile(const std::string& name) {
    std::string folder = (std::filesystem::temp_directory_path() / "maille_fuzz_XXXXXX").string();
    require(mkdtemp(folder.data()) != nullptr, "a folder for files");
    folder_ = folder;
    path_ = folder_ / name;
  }
  ~ScratchFile() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  const std::filesystem::path& holding(std::string_view bytes) const {
    std::ofstream(path_, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path_;
  }

private:
  std::filesystem::path folder_, path_;
};

} // namespace maille::fuzzing
