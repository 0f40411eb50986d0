/// Runs every reader that has a fuzzer over its corpus, without libFuzzer: finds stay mended in every build.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#define READER(name) int read_##name(std::string_view text);
namespace maille::fuzzing {
#include "fuzzed_readers.inc"
} // namespace maille::fuzzing
#undef READER

namespace maille {
namespace {

struct Reader {
  std::string name;
  int (*read)(std::string_view text);
};

const std::vector<Reader>& readers() {
#define READER(name) {#name, fuzzing::read_##name},
  static const std::vector<Reader> all = {
#include "fuzzed_readers.inc"
  };
#undef READER
  return all;
}

class CorpusContract : public testing::TestWithParam<Reader> {};

/// A reader returns or throws InputError, and keeps its promises (readers.cpp, which aborts otherwise).
TEST_P(CorpusContract, IsReadOrRefused) {
  const auto& [name, read] = GetParam();
  int n_inputs = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(MAILLE_CORPUS) / name)) {
    SCOPED_TRACE(entry.path().string());
    std::ifstream file(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(read(text), 0);
    ++n_inputs;
  }
  EXPECT_GT(n_inputs, 0);
}

INSTANTIATE_TEST_SUITE_P(Readers, CorpusContract, testing::ValuesIn(readers()),
                         [](const auto& reader) { return reader.param.name; });

} // namespace
} // namespace maille
