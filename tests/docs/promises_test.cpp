/// docs/promises.md: every line names a test, and every test that is named is in the sources.

#include "maille/scene/mechanics/mechanics.hpp"
#include "support/kit.hpp"

#include <regex>

namespace maille {
namespace {

namespace fs = std::filesystem;

/// `Suite.Test` of every TEST, TEST_F and TEST_P below tests/.
std::set<std::string> tests_in_the_sources() {
  const std::regex declaration(R"(\n(?:TEST|TEST_F|TEST_P)\((\w+),\s*(\w+)\))");
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(MAILLE_SOURCES) / "tests"))
    if (entry.path().extension() == ".cpp") {
      const std::string text = test::text_of(entry.path());
      for (std::sregex_iterator at(text.begin(), text.end(), declaration), end; at != end; ++at)
        names.insert((*at)[1].str() + "." + (*at)[2].str());
    }
  return names;
}

std::vector<std::string> lines_of_the_page() {
  std::istringstream page(test::text_of(fs::path(MAILLE_SOURCES) / "docs" / "promises.md"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(page, line);)
    lines.push_back(line);
  return lines;
}

/// Every `Suite.Test` in back quotes.
std::vector<std::string> tests_named_in(const std::string& line) {
  const std::regex name(R"(`([A-Z]\w+\.[A-Z]\w+)`)");
  std::vector<std::string> names;
  for (std::sregex_iterator at(line.begin(), line.end(), name), end; at != end; ++at)
    names.push_back((*at)[1].str());
  return names;
}

TEST(PromisesPageContract, EveryTestThatIsNamedExists) {
  const std::set<std::string> known = tests_in_the_sources();
  int named = 0;
  for (const std::string& line : lines_of_the_page())
    for (const std::string& name : tests_named_in(line)) {
      EXPECT_TRUE(known.contains(name)) << name << " is named in docs/promises.md and is no test";
      ++named;
    }
  EXPECT_GE(named, 40) << "the page is there and names tests";
}

TEST(PromisesPageContract, EveryLineOfATableNamesATest) {
  int rows = 0;
  for (const std::string& line : lines_of_the_page()) {
    if (!line.starts_with("| ") || line.starts_with("| ---") || line.starts_with("| what"))
      continue;
    EXPECT_FALSE(tests_named_in(line).empty()) << line;
    ++rows;
  }
  EXPECT_GE(rows, 30);
}

// docs/mechanics.md has the text that `maille help mechanics` and JSON have.
TEST(MechanicsPageContract, HasTheConventionsToTheLetter) {
  const std::string page = test::text_of(fs::path(MAILLE_SOURCES) / "docs" / "mechanics.md");
  EXPECT_NE(page.find(mechanics_conventions()), std::string::npos);
}

} // namespace
} // namespace maille
