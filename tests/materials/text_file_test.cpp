// Text files, and TOML that would overrun the stack.
#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"
#include "support/mistake.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using test::only_fault_of;

TEST(TextFileContract, IsReadWholeOrNotAtAll) {
  const test::TemporaryFolder folder;
  const std::string text(100'000, 'x');
  const auto file = folder.write("a.txt", text);
  EXPECT_EQ(read_text_file(file, "a text"), text);
  EXPECT_EQ(read_text_file(file, "a text", 100'000), text);
  EXPECT_EQ(read_text_file(folder.write("empty.txt", ""), "a text"), "");
  EXPECT_EQ(only_fault_of([&] { read_text_file(file, "a text", 99'999); }).expected,
            "a text of at most 99999 bytes");
  EXPECT_EQ(only_fault_of([&] { read_text_file(folder / "none", "a text"); }).expected,
            "a text that can be read");
  EXPECT_EQ(only_fault_of([&] { read_text_file(folder.path(), "a text"); }).found,
            "nothing that can be read there");
}

TEST(TextFileContract, ADeviceWithoutEndIsRefused) {
  EXPECT_EQ(only_fault_of([] { read_text_file("/dev/zero", "a text"); }).found, "more");
}

std::string dotted(int parts) {
  std::string key = "a";
  for (int i = 1; i < parts; ++i)
    key += ".a";
  return key;
}

// Each would be tables within tables some ten thousand deep, which ends the process where they are destroyed.
TEST(DeepTomlContract, KeysOfManyPartsAreRefusedWithTheirLine) {
  std::string within_brackets = "x = ";
  for (int i = 0; i < 200; ++i)
    within_brackets += "{ y = 1, " + dotted(200) + " = ";
  const std::vector<std::string> hostile{"b = 1\n" + dotted(100'000) + " = 1\n",
                                         "b = 1\n[" + dotted(100'000) + "]\n",
                                         "b = 1\n" + dotted(100'000) + " = = 1\n",
                                         "b = \"=\"\n\"a=b\"." + dotted(100'000) + " = 1\n",
                                         "b = 'it''s'\n" + dotted(300) + " = 1\n",
                                         "# don't \"\n" + within_brackets,
                                         "b = \"\"\"\\\"\"\"\" # \"\"\"\n" + dotted(300) + " = 1\n",
                                         "b = '''a'''''\n" + dotted(300) + " = 1\n"};
  for (const std::string& text : hostile) {
    const Fault fault = only_fault_of([&] { parse_toml(text, "deep.toml"); });
    EXPECT_EQ(fault.line, 2) << text.substr(0, 60);
    EXPECT_EQ(fault.expected, "keys of at most 256 dots") << text.substr(0, 60);
  }
}

TEST(DeepTomlContract, DotsOfNumbersAndTextsDoNotCount) {
  std::string numbers = "0.5", texts = "\"0.5 mm\"", prose;
  for (int i = 0; i < 1000; ++i) {
    numbers += ", 0.5";
    texts += ", \"0.5 mm\"";
    prose += "One. ";
  }
  const toml::table table =
      parse_toml("n = [" + numbers + "]\nb = [" + texts + "]\nc = \"" + prose + "\"\nd = \"\"\"\n" + prose +
                     "\"\"\"\n# " + prose + "\n" + dotted(200) + " = 1\n[" + dotted(200).replace(0, 1, "e") +
                     "]\nf.g = 1\n",
                 "flat.toml");
  EXPECT_EQ(table["n"].as_array()->size(), 1001u);
  EXPECT_TRUE(table.at_path("e.a.a").is_table());
}

} // namespace
} // namespace maille
