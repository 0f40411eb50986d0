/// A guard against slowing down that does not depend on how busy the machine is: instructions of small cases,
/// counted by valgrind. tests/golden/instructions.txt has the numbers; MAILLE_BLESS=1 writes it anew. A count
/// may be up to `margin` above; what is as far below is worth blessing, and is said.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>

namespace maille {
namespace {

constexpr double margin = 0.05;

/// @param is_done whether its exit code was 0
std::string text_of(const std::string& command, bool& is_done) {
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  std::array<char, 4096> buffer{};
  std::string text;
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe))
    text.append(buffer.data(), n);
  is_done = pclose(pipe) == 0;
  return text;
}

std::string output_of(const std::string& command) {
  bool is_done = false;
  std::string text = text_of(command, is_done);
  return is_done ? text : std::string{};
}

/// Whether valgrind ends programs because they, or the libraries that they load, have an instruction of this
/// processor that it does not know.
bool lacks_instructions() {
  bool is_done = false;
  const std::string text = text_of(fmt::format("valgrind --tool=none {}", MAILLE_CASES), is_done);
  return !is_done && text.find("unhandled instruction bytes") != std::string::npos;
}

/// Instructions within `counted` and all that it calls; 0 where valgrind failed.
double instructions_of(const std::string& name) {
  const std::string text = output_of(
      fmt::format("valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect=counted {} {}",
                  MAILLE_CASES, name));
  std::smatch match;
  return std::regex_search(text, match, std::regex(R"(Collected : (\d+))")) ? std::stod(match[1]) : 0;
}

std::map<std::string, double> golden() {
  std::map<std::string, double> counts;
  std::ifstream file(MAILLE_GOLDEN_INSTRUCTIONS);
  for (std::string line; std::getline(file, line);)
    if (std::istringstream words(line); !line.starts_with('#')) {
      std::string name;
      double count = 0;
      if (words >> name >> count)
        counts[name] = count;
    }
  return counts;
}

TEST(InstructionsGolden, AreNoMoreThanAtTheLastBlessing) {
  if (!MAILLE_COUNTS)
    GTEST_SKIP() << "instructions are those of a release build without sanitizers";
  if (output_of("valgrind --version").empty())
    GTEST_SKIP() << "valgrind is not installed: scripts/install-dependencies installs it";
  if (lacks_instructions())
    GTEST_SKIP() << "valgrind does not know all instructions of this processor";
  const std::map<std::string, double> expected = golden();
  std::istringstream names(output_of(MAILLE_CASES));
  std::string blessed = "# instructions within `counted` of tests/performance/instruction_cases.cpp, by "
                        "valgrind; MAILLE_BLESS=1 writes this\n";
  int n = 0;
  for (std::string name; names >> name; ++n) {
    const double count = instructions_of(name);
    ASSERT_GT(count, 1e5) << name << ": valgrind counted nothing";
    blessed += fmt::format("{} {:.0f}\n", name, count);
    if (std::getenv("MAILLE_BLESS") != nullptr)
      continue;
    ASSERT_TRUE(expected.contains(name)) << name << " has no golden number";
    const double ratio = count / expected.at(name);
    EXPECT_LE(ratio, 1 + margin) << name << ": " << count << " instructions, blessed were "
                                 << expected.at(name);
    if (ratio < 1 - margin)
      fmt::print("{} takes {:.3f} of the instructions that were blessed: MAILLE_BLESS=1 keeps that\n", name,
                 ratio);
  }
  EXPECT_GE(n, 10);
  if (std::getenv("MAILLE_BLESS") != nullptr)
    std::ofstream(MAILLE_GOLDEN_INSTRUCTIONS) << blessed;
}

} // namespace
} // namespace maille
