#pragma once
/// What the fuzzers share. A reader may return or throw InputError; anything else ends the fuzzer, which is a
/// find.

#include "maille/materials/fault.hpp"
#include "support/temporary_folder.hpp"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

/// What libFuzzer calls for every input.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

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

/// Reads what `read` reads. @return 0, as libFuzzer wants it, unless something else than faults comes out
template<class Read>
int tried(Read&& read) {
  try {
    read();
  } catch (const InputError& error) {
    check(error);
  }
  return 0;
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A file of this process for readers that take no text, written anew for every input.
class ScratchFile {
public:
  explicit ScratchFile(std::string name) : name_(std::move(name)) {}
  std::filesystem::path holding(std::string_view bytes) const { return folder_.write(name_, bytes); }

private:
  test::TemporaryFolder folder_;
  std::string name_;
};

} // namespace maille::fuzzing
