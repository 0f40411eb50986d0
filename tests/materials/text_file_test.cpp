// Text files, and TOML that would overrun the stack.
#include "maille/materials/fault.hpp"
#include "maille/materials/json.hpp"
#include "maille/materials/toml_reader.hpp"
#include "support/mistake.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

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
  EXPECT_EQ(only_fault_of([&] { read_text_file(folder.path(), "a text"); }).found, "a folder");
  EXPECT_EQ(only_fault_of([&] { read_text_file(folder / "none", "a text"); }).found, "no file of that name");
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

// Truth: nlohmann's own parser, of values made at random.
TEST(JsonOracle, ReadsWhatNlohmannReads) {
  std::mt19937 random(1);
  const std::function<nlohmann::ordered_json(int)> any = [&](int depth) -> nlohmann::ordered_json {
    nlohmann::ordered_json value;
    switch (random() % (depth > 5 ? 5 : 7)) {
    case 0:
      return random() % 2 == 0;
    case 1:
      return std::ldexp(static_cast<double>(random()), static_cast<int>(random() % 80) - 60);
    case 2:
      return -static_cast<std::int64_t>(random());
    case 3:
      return "quotes \" \\ [ { \u00e9 " + std::to_string(random());
    case 4:
      return nullptr;
    case 5:
      for (std::uint64_t n = random() % 5; n > 0; --n)
        value.push_back(any(depth + 1));
      return value;
    default:
      for (std::uint64_t n = random() % 5; n > 0; --n)
        value["key" + std::to_string(random())] = any(depth + 1);
      return value;
    }
  };
  for (int i = 0; i < 300; ++i) {
    const std::string text = any(0).dump(i % 2 == 0 ? -1 : 1);
    EXPECT_EQ(parse_json(text, "a.json"), nlohmann::ordered_json::parse(text));
  }
}

TEST(JsonContract, DeepTextIsAFaultWithItsPlace) {
  const auto nested = [](int depth, char open, char close) {
    std::string text = "{ \"a\": \"[[[\",\n \"b\": ";
    text.append(static_cast<std::size_t>(depth), open);
    return text.append(static_cast<std::size_t>(depth), close) + "}";
  };
  EXPECT_NO_THROW(parse_json(nested(63, '[', ']'), "a.json"));
  for (const int depth : {64, 65, 200'000, 1'000'000}) {
    const Fault fault = only_fault_of([&] { parse_json(nested(depth, '[', ']'), "a.json"); });
    EXPECT_EQ(to_string(fault),
              "a.json:2: expected JSON of at most 64 brackets inside each other, found more at "
              "character 70");
  }
  EXPECT_EQ(only_fault_of([&] { parse_json(nested(200'000, '{', '}'), "a.json"); }).line, 2);
}

TEST(JsonContract, FaultsSayWhere) {
  EXPECT_EQ(to_string(only_fault_of([] { parse_json("[1,\n 2 3]", "a.json"); })),
            "a.json:2: expected JSON, found \"3\" at character 4");
  EXPECT_EQ(only_fault_of([] { parse_json("", "a.json"); }).expected, "JSON");
  EXPECT_EQ(only_fault_of([] { parse_json("{\"a\": 1, \"a\": 2}", "a.json"); }).found, "\"a\" again");
  EXPECT_EQ(only_fault_of([] { parse_json("[", "a.jsonl", 7); }).line, 7);
}

} // namespace
} // namespace maille
