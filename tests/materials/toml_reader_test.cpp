#include "maille/materials/json.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/materials/toml_reader.hpp"
#include "materials/constants_and_faults.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

using test::faults_of;
using Messages = std::vector<std::string>;

void read_strip(TableReader& table) {
  table.text("title");
  table.quantity("spacing", Dimension::length);
  table.choice("shape", {"box", "ellipsoid", "muscle"});
  table.integer("cells", 1, 1000);
  table.quantities("by", Dimension::length, true);
}

// Truth of every message below: the format in fault.hpp and the words of docs/scene.md; they are what users
// read.

TEST(FaultContract, OneLineForPeople) {
  EXPECT_EQ(to_string({"scene.toml", 12, "specimen.spacing", "a length > 0", "\"-1 mm\""}),
            "scene.toml:12: specimen.spacing: expected a length > 0, found \"-1 mm\"");
  EXPECT_EQ(to_string({"a.toml", 0, "", "a file", "a folder"}), "a.toml: expected a file, found a folder");
  EXPECT_EQ(to_string({"", 3, "key", "", "nothing"}), "line 3: key: found nothing");
}

TEST(FaultContract, WhatHoldsAllFaultsOneALine) {
  const InputError error({{"a", 1, "k", "x", "y"}, {"a", 2, "l", "x", "z"}});
  EXPECT_STREQ(error.what(), "a:1: k: expected x, found y\na:2: l: expected x, found z");
  EXPECT_EQ(error.faults().size(), 2U);
}

TEST(TomlReaderContract, BytesThatAreNoTextAreQuotedInPart) {
  // Each would go on a character of UTF-8 that never began, as cells of tables may: where to cut is not
  // looked for before the text.
  EXPECT_EQ(describe(toml::value<std::string>(std::string(100, '\x97'))),
            "\"" + std::string(57, '\x97') + "...\"");
}

TEST(TomlReaderContract, GoodValuesAreReadAndNoFaultIsFound) {
  const toml::table document = parse_toml(R"(
title = "a strip"
spacing = "2 mm"
length = "3 m"
height = "50 cm"
shape = "box"
cells = 8
by = ["1 mm", 0, "0.5 m"]
limit = 0.25
inner = { a = 1 })",
                                          "scene.toml");
  FaultList faults("scene.toml");
  TableReader table(document, "", faults);
  EXPECT_EQ(table.text("title"), "a strip");
  EXPECT_EQ(table.quantity("spacing", Dimension::length), 0.002);
  EXPECT_EQ(table.quantity("length", Dimension::length), 3.0);
  EXPECT_EQ(table.quantity("height", Dimension::length), 0.5);
  EXPECT_EQ(table.choice("shape", {"box", "muscle"}), "box");
  EXPECT_EQ(table.integer("cells", 1, 8), 8);
  EXPECT_EQ(table.quantities("by", Dimension::length, false), (std::array{0.001, 0.0, 0.5}));
  EXPECT_EQ(table.quantities("limit", Dimension::dimensionless, true), (std::array{0.25, 0.25, 0.25}));
  EXPECT_NE(table.subtable("inner"), nullptr);
  EXPECT_EQ(table.text("absent"), std::nullopt);
  EXPECT_EQ(table.subtable("absent"), nullptr);
  EXPECT_FALSE(table.has("absent"));
  table.finish();
  EXPECT_TRUE(faults.empty());
  EXPECT_NO_THROW(faults.throw_if_any());
}

TEST(TomlReaderContract, EveryFaultAtOnceWithItsLine) {
  EXPECT_EQ(
      faults_of(
          "title = 5\n\nspacing = \"2 kPa\"\nshape = \"bx\"\ncells = 0\nby = [\"1 mm\",\n  true,\n  nan]\n",
          read_strip),
      (Messages{
          "scene.toml:1: title: expected a text in quotes, found 5",
          "scene.toml:3: spacing: expected a length such as \"2 mm\" (units: m, cm, mm, um, nm), found "
          "\"2 kPa\"",
          "scene.toml:4: shape: expected one of: \"box\", \"ellipsoid\", \"muscle\", found \"bx\" (did you "
          "mean \"box\"?)",
          "scene.toml:5: cells: expected a whole number from 1 to 1000, found 0",
          "scene.toml:7: by[1]: expected a length such as \"2 mm\" (units: m, cm, mm, um, nm), found true",
          "scene.toml:8: by[2]: expected a length such as \"2 mm\" (units: m, cm, mm, um, nm), found nan"}));
}

TEST(TomlReaderContract, FaultsComeInTheOrderOfTheFile) {
  // Read in another order than written: cells is asked for last, the unknown key at the very end.
  const Messages found = faults_of("colour = 1\ncells = 0\nshape = 2\ntitle = 3\n", read_strip);
  ASSERT_EQ(found.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_TRUE(found[i].starts_with("scene.toml:" + std::to_string(i + 1) + ":")) << found[i];
}

TEST(TomlReaderContract, NumbersThatAreNotFiniteAreFaults) {
  for (const char* text : {"spacing = inf", "spacing = -inf", "spacing = nan", "spacing = \"nan mm\""})
    EXPECT_EQ(faults_of(text, read_strip).size(), 1U) << text;
}

TEST(TomlReaderContract, AnUnknownKeyIsMetWithTheKnownOnes) {
  EXPECT_EQ(
      faults_of("title = \"t\"\nspacng = \"1 mm\"\n", read_strip),
      (Messages{
          "scene.toml:2: spacng: expected one of: by, cells, shape, spacing, title, found an unknown key "
          "(did you mean \"spacing\"?)"}));
  EXPECT_EQ(
      faults_of("colour = \"red\"", read_strip),
      (Messages{
          "scene.toml:1: colour: expected one of: by, cells, shape, spacing, title, found an unknown key"}));
  EXPECT_EQ(
      faults_of("yb = 1", read_strip), // two letters swapped are one slip
      (Messages{
          "scene.toml:1: yb: expected one of: by, cells, shape, spacing, title, found an unknown key (did "
          "you mean \"by\"?)"}));
}

TEST(TomlReaderContract, TheWrongKindOfValueIsDescribed) {
  EXPECT_EQ(
      faults_of("spacing = [1, \"2 mm\"]\n", read_strip),
      (Messages{"scene.toml:1: spacing: expected a length such as \"2 mm\" (units: m, cm, mm, um, nm), found "
                "[1, \"2 mm\"]"}));
  const Messages vector = faults_of("by = [1, 2]", read_strip);
  ASSERT_EQ(vector.size(), 1U);
  EXPECT_TRUE(test::has(vector[0], "one quantity or a list of three"));
  EXPECT_TRUE(test::has(vector[0], "found [1, 2]"));
  const auto read = [](TableReader& table) {
    table.subtable("inner");
    table.integer("count", 0, std::numeric_limits<std::int64_t>::max());
  };
  EXPECT_EQ(faults_of("inner = 3\ncount = 1.5", read),
            (Messages{"scene.toml:1: inner: expected a table, found 3",
                      "scene.toml:2: count: expected a whole number >= 0, found 1.5"}));
}

TEST(TomlReaderContract, AMissingKeyIsReportedAtItsTable) {
  const toml::table document = parse_toml("\n\n[specimen]\nshape = \"box\"\n", "scene.toml");
  FaultList faults("scene.toml");
  TableReader table(*document["specimen"].as_table(), "specimen", faults);
  EXPECT_EQ(table.require("spacing", "a length > 0"), nullptr);
  EXPECT_NE(table.require("shape", "a shape"), nullptr);
  EXPECT_TRUE(test::says_only(
      test::faults_found_by([&] { faults.throw_if_any(); }),
      {.line = 3, .key = "specimen.spacing", .expected = "a length > 0", .found = "nothing"}));
}

TEST(TomlReaderContract, TextThatIsNoTomlHasItsLine) {
  const Messages faults = faults_of("title = \"t\"\nspacing = = 3\n", read_strip);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].rfind("scene.toml:2: expected valid TOML, found ", 0), 0U) << faults[0];
}

TEST(TomlReaderContract, ALongTextIsCutBetweenCharacters) {
  std::string text = "title = 1\nspacing = \"";
  for (int i = 0; i < 50; ++i)
    text += "\u00e9\u00e9\u00e9";
  const Messages faults = faults_of(text + "\"", read_strip);
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_TRUE(faults[1].ends_with("\u00e9...\"")) << faults[1];
}

TEST(ReadLimitsContract, OneNumberMeansAllTheSame) {
  const toml::table document = parse_toml("stretch = 1.3\ncompress = [0.8, 0.9, \"95 %\"]\nshear = 0.2", "s");
  FaultList faults("s");
  TableReader table(document, "", faults, "material");
  const auto limits = read_neighbour_limits(table);
  table.finish();
  ASSERT_TRUE(limits);
  EXPECT_TRUE(faults.empty());
  EXPECT_EQ(
      *limits,
      (NeighbourLimits{{1.3, 1.3, 1.3}, {0.8, 0.9, 0.95}, {{{0, 0.2, 0.2}, {0.2, 0, 0.2}, {0.2, 0.2, 0}}}}));
}

TEST(ReadLimitsContract, ShearMayBeATableOfLinkAxisAndComponent) {
  const toml::table document = parse_toml("shear = [[9, 0.12, 0.13], [0.21, 9, 0.23], [0.31, 0.32, 9]]", "s");
  FaultList faults("s");
  TableReader table(document, "", faults, "material");
  const auto limits = read_neighbour_limits(table);
  ASSERT_TRUE(limits);
  EXPECT_EQ(*limits,
            (NeighbourLimits{{1, 1, 1}, {1, 1, 1}, {{{0, 0.12, 0.13}, {0.21, 0, 0.23}, {0.31, 0.32, 0}}}}));
}

TEST(ReadLimitsContract, NoneOfTheKeysMeansNoLimits) {
  const toml::table document = parse_toml("density = 1000", "s");
  FaultList faults("s");
  TableReader table(document, "", faults, "material");
  EXPECT_EQ(read_neighbour_limits(table), std::nullopt);
  EXPECT_TRUE(faults.empty());
}

TEST(ReadLimitsContract, LimitsThatForbidTheRestStateAreFaults) {
  const auto read = [](TableReader& table) { EXPECT_EQ(read_neighbour_limits(table), std::nullopt); };
  EXPECT_EQ(
      faults_of("stretch = 0.9\ncompress = [0.8, 1.1, -1]\nshear = -0.1", read, "material"),
      (Messages{"scene.toml:1: stretch: expected a ratio >= 1 (largest distance / rest), found 0.9",
                "scene.toml:2: compress: expected a ratio from 0 to 1 (smallest distance / rest), found 1.1",
                "scene.toml:2: compress: expected a ratio from 0 to 1 (smallest distance / rest), found -1",
                "scene.toml:3: shear: expected a ratio >= 0 (largest shear / rest), found -0.1"}));
  EXPECT_EQ(faults_of("shear = [[0, 1, 1],\n [1, 0, -2],\n [1, 1, 0]]", read, "material"),
            (Messages{"scene.toml:2: shear[1][2]: expected a ratio >= 0 (largest shear / rest), found -2"}));
  EXPECT_EQ(faults_of("shear = [1, 2, 3]", read, "material").size(), 1U);
}

TEST(QuantityAnalytic, UnitsAreConvertedToTheNearestDouble) {
  // Truth: the definitions of the SI prefixes; each literal is the double nearest to the decimal.
  EXPECT_EQ(parse_quantity("2 mm", Dimension::length), 0.002);
  EXPECT_EQ(parse_quantity("0.3 mm", Dimension::length), 0.0003);
  EXPECT_EQ(parse_quantity("7 um", Dimension::length), 7e-6);
  EXPECT_EQ(parse_quantity("7 \u00b5m", Dimension::length), 7e-6);
  EXPECT_EQ(parse_quantity("12 nm", Dimension::length), 12e-9);
  EXPECT_EQ(parse_quantity("-3 cm", Dimension::length), -0.03);
  EXPECT_EQ(parse_quantity("41.8kPa", Dimension::pressure), 41800.0);
  EXPECT_EQ(parse_quantity("12 GPa", Dimension::pressure), 12e9);
  EXPECT_EQ(parse_quantity("0.31 MPa", Dimension::pressure), 310e3);
  EXPECT_EQ(parse_quantity("2 N/mm^2", Dimension::pressure), 2e6);
  EXPECT_EQ(parse_quantity("2 N/cm^2", Dimension::pressure), 2e4);
  EXPECT_EQ(parse_quantity("760 mmHg", Dimension::pressure), 760 * 133.322387415);
  EXPECT_EQ(parse_quantity("2 kN", Dimension::force), 2000);
  EXPECT_EQ(parse_quantity("250 mN", Dimension::force), 0.25);
  EXPECT_EQ(parse_quantity("1.05 g/cm^3", Dimension::density), 1050.0);
  EXPECT_EQ(parse_quantity("1050 kg/m3", Dimension::density), 1050.0);
  EXPECT_EQ(parse_quantity("180 deg", Dimension::angle), std::numbers::pi);
  EXPECT_EQ(parse_quantity("-20 deg", Dimension::angle), -std::numbers::pi / 9);
  EXPECT_EQ(parse_quantity("-9.81 m/s^2", Dimension::acceleration), -9.81);
  EXPECT_EQ(parse_quantity("5 %", Dimension::dimensionless), 0.05);
}

TEST(QuantityContract, ANumberWithoutUnitIsInSi) {
  EXPECT_EQ(parse_quantity("0.25", Dimension::length), 0.25);
  EXPECT_EQ(parse_quantity(" +1e3 ", Dimension::pressure), 1000.0);
  EXPECT_EQ(parse_quantity("0.3", Dimension::dimensionless), 0.3);
}

TEST(QuantityContract, WhatIsNoQuantityIsRefused) {
  for (const char* text : {"", " ", "mm", "two mm", "2 kPa", "2 mm extra", "2 MM", "2,5 mm", "1e999 mm",
                           "nan mm", "inf", "-inf", "--2 mm", "+-2 mm", "0x10 m", "2 mm 3"}) {
    EXPECT_EQ(parse_quantity(text, Dimension::length), std::nullopt) << text;
  }
  EXPECT_EQ(parse_quantity("1e308 GPa", Dimension::pressure), std::nullopt); // finite only before the unit
  EXPECT_EQ(parse_quantity("2 mm", Dimension::pressure), std::nullopt);
  EXPECT_EQ(parse_quantity("2 %", Dimension::length), std::nullopt);
}

TEST(QuantityContract, MessagesNameTheUnits) {
  // Truth: the header's example.
  EXPECT_EQ(describe(Dimension::length), "a length such as \"2 mm\" (units: m, cm, mm, um, nm)");
  EXPECT_EQ(describe(Dimension::pressure),
            "a pressure such as \"10 kPa\" (units: Pa, kPa, MPa, GPa, N/m^2, N/cm^2, N/mm^2, mmHg)");
  EXPECT_EQ(describe(Dimension::dimensionless), "a number such as 0.3 (units: none, %)");
}

// Text files, and TOML that would overrun the stack.

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
  const std::string whole = R"({"a": [1, -2.5e-3, "b\u00e9 c"], "d": {"e": true}})";
  for (std::size_t n = 0; n < whole.size(); ++n) // a file that was cut short
    EXPECT_EQ(only_fault_of([&] { parse_json(whole.substr(0, n), "a.json"); }).found,
              fmt::format("its end at character {}", n + 1));
  EXPECT_EQ(only_fault_of([] { parse_json("{\"a\": 1, \"a\": 2}", "a.json"); }).found, "\"a\" again");
  EXPECT_EQ(only_fault_of([] { parse_json("[", "a.jsonl", 7); }).line, 7);
}

std::optional<ElasticConstants> read(std::string_view text) {
  const toml::table document = parse_toml(text, "scene.toml");
  FaultList faults("scene.toml");
  TableReader table(document, "", faults, "material");
  const auto constants = read_elastic_constants(table);
  table.finish();
  EXPECT_TRUE(faults.empty()) << text;
  return constants;
}

Messages faults(std::string_view text) {
  return faults_of(
      text, [](TableReader& table) { EXPECT_EQ(read_elastic_constants(table), std::nullopt); }, "material");
}

using test::has;

TEST(ReadConstantsContract, ThreeForms) {
  for (const char* text : {"youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3", "E = \"10 kPa\"\nnu = 0.3"}) {
    const auto isotropic = read(text);
    ASSERT_TRUE(isotropic);
    EXPECT_TRUE(isotropic->is_isotropic());
    EXPECT_EQ(isotropic->youngs_modulus[2], 10e3);
  }

  const auto fibrous =
      read("E_fibre = \"40 kPa\"\nE_cross = 8000\nG_fibre = \"5 kPa\"\nnu_fibre = 0.4\nnu_cross = 0.5");
  ASSERT_TRUE(fibrous);
  EXPECT_EQ(fibrous->youngs_modulus, (std::array{40e3, 8e3, 8e3}));
  EXPECT_EQ(fibrous->nu13, 0.4);
  EXPECT_EQ(fibrous->G12, 5e3);
  EXPECT_EQ(fibrous->G23, 8e3 / 3); // truth: E_cross / (2 (1 + nu_cross))

  const auto orthotropic =
      read("E = [\"20 kPa\", \"9 kPa\", 5000]\nnu = [0.3, 0.2, 0.25]\nG = [4e3, 3e3, 2e3]");
  ASSERT_TRUE(orthotropic);
  EXPECT_EQ(orthotropic->youngs_modulus, (std::array{20e3, 9e3, 5e3}));
  EXPECT_EQ(orthotropic->nu12, 0.3); // truth: the order nu12, nu13, nu23 and G12, G13, G23 of docs/scene.md
  EXPECT_EQ(orthotropic->nu13, 0.2);
  EXPECT_EQ(orthotropic->nu23, 0.25);
  EXPECT_EQ(orthotropic->G12, 4e3);
  EXPECT_EQ(orthotropic->G13, 3e3);
  EXPECT_EQ(orthotropic->G23, 2e3);
}

TEST(ReadConstantsContract, OtherKeysAreLeftToTheCaller) {
  const auto read = [](TableReader& table) { EXPECT_TRUE(read_elastic_constants(table)); };
  EXPECT_EQ(
      faults_of("youngs_modulus = 1\npoisson_ratio = 0\ndensity = 5", read, "material"),
      Messages{
          "scene.toml:3: density: expected one of: poisson_ratio, youngs_modulus, found an unknown key"});
}

TEST(ReadConstantsContract, TwoFaultsAtOnceWithTheirLines) {
  EXPECT_EQ(faults("youngs_modulus = \"-1 kPa\"\n\npoisson_ratio = 0.6\n"),
            (Messages{"scene.toml:1: youngs_modulus: expected youngs_modulus > 0, found \"-1 kPa\"",
                      "scene.toml:3: poisson_ratio: expected -1 < poisson_ratio < 0.5, found 0.6"}));
}

TEST(ReadConstantsContract, AWrongUnitNamesTheRightOnes) {
  EXPECT_EQ(
      faults("youngs_modulus = \"3 mm\"\npoisson_ratio = 0.3"),
      (Messages{
          "scene.toml:1: youngs_modulus: expected a pressure such as \"10 kPa\" (units: Pa, kPa, MPa, GPa, "
          "N/m^2, N/cm^2, N/mm^2, mmHg), found \"3 mm\""}));
}

TEST(ReadConstantsContract, FormsAreNotMixedAndAreWhole) {
  const auto nth = [](const std::string& text, std::size_t size, std::size_t i = 0) {
    const Messages found = faults(text);
    EXPECT_EQ(found.size(), size) << text;
    return i < found.size() ? found[i] : "";
  };
  const std::string mixed = nth("youngs_modulus = 1\npoisson_ratio = 0.3\nE_fibre = 2", 1);
  EXPECT_TRUE(has(mixed, "{ youngs_modulus, poisson_ratio } or { E, nu } (isotropic)"));
  EXPECT_TRUE(has(mixed, "2 forms: youngs_modulus, poisson_ratio, E_fibre"));
  // As many keys as the orthotropic form has, but of two forms.
  EXPECT_TRUE(has(nth("youngs_modulus = 1\npoisson_ratio = 0.3\nE = [1, 1, 1]", 1),
                  "2 forms: youngs_modulus, poisson_ratio, E"));
  const std::string lacking = "E_fibre = 4\nE_cross = 2\nG_fibre = -1\nnu_fibre = 0.3";
  EXPECT_TRUE(has(nth(lacking, 2), "found only E_fibre, E_cross, G_fibre, nu_fibre"));
  EXPECT_TRUE(has(nth(lacking, 2, 1), "scene.toml:3: G_fibre: expected G_fibre > 0, found -1"));
  // The missing form, and the key that this test does not ask for.
  EXPECT_TRUE(has(nth("density = 3", 2), "none of these keys"));
  EXPECT_TRUE(has(nth("youngs_modulus = 1\npoisson_ration = 0.3", 2, 1), "\"poisson_ratio\""));
  EXPECT_TRUE(has(nth("material = \"muscle/soleus\"\nfibre = [0, 0, 1]", 1), "`fibre`"));
}

TEST(ReadConstantsContract, EveryViolatedInequalityIsOneFault) {
  const Messages found = faults("E = [1e3, 4e3, -1]\nnu = [0.9, 0, 0]\nG = [0, 1e3, 1e3]");
  EXPECT_EQ(found, (Messages{"scene.toml:1: E: expected E3 > 0, found -1 > 0, which is false",
                             "scene.toml:3: G: expected G12 > 0, found 0 > 0, which is false"}));
  EXPECT_EQ(faults("E = [1e3, 4e3, 4e3]\nnu = [0.9, 0.8, 0]\nG = [1, 1, 1]"),
            (Messages{"scene.toml:2: nu: expected |nu12| < sqrt(E1/E2), found 0.9 < 0.5, which is false",
                      "scene.toml:2: nu: expected |nu13| < sqrt(E1/E3), found 0.8 < 0.5, which is false"}));
  // Truth: 1 - 3 * 0.9^2 - 2 * 0.9^3 = -2.888.
  EXPECT_EQ(
      faults("E = [1, 1, 1]\nnu = [0.9, 0.9, 0.9]\nG = [1, 1, 1]"),
      (Messages{
          "scene.toml:2: nu: expected 1 - nu12 nu21 - nu23 nu32 - nu31 nu13 - 2 nu21 nu32 nu13 > 1e-09 (at 0 "
          "the stiffness is infinite: take slightly smaller Poisson ratios), found -2.888 > 1e-09, which is "
          "false"}));
}

TEST(ReadConstantsContract, TheIncompressibleLimitIsRefusedWithAdvice) {
  const Messages isotropic = faults("youngs_modulus = 1\npoisson_ratio = 0.5");
  ASSERT_EQ(isotropic.size(), 1U);
  EXPECT_TRUE(has(isotropic[0], "take a slightly smaller poisson_ratio, such as 0.49")) << isotropic[0];

  // Truth: the set 447 / 22.4 / 3.87 kPa, nu_fibre 0.5, nu_cross 1 - E_cross / (2 E_fibre) = 0.97494 is
  // singular.
  for (const char* nu_cross : {"0.974944071588367", "0.975"}) {
    const Messages fibrous =
        faults(std::string("E_fibre = \"447 kPa\"\nE_cross = \"22.4 kPa\"\nG_fibre = \"3.87 kPa\"\n"
                           "nu_fibre = 0.5\nnu_cross = ") +
               nu_cross);
    ASSERT_EQ(fibrous.size(), 1U);
    EXPECT_TRUE(has(fibrous[0],
                    "scene.toml:4: nu_fibre: expected 1 - nu_cross - 2 nu_fibre^2 E_cross / E_fibre > 0"));
    EXPECT_TRUE(has(fibrous[0], "take a slightly smaller nu_fibre or nu_cross")) << fibrous[0];
    EXPECT_TRUE(has(fibrous[0], "E_cross / E_fibre = 0.0501119")) << fibrous[0];
  }
  EXPECT_TRUE(read("youngs_modulus = 1\npoisson_ratio = 0.4999"));
}

TEST(ReadConstantsContract, AnInvalidCrossRatioIsOneFault) {
  EXPECT_EQ(faults("E_fibre = 4\nE_cross = 2\nG_fibre = 1\nnu_fibre = 0.3\nnu_cross = 1.5"),
            (Messages{"scene.toml:5: nu_cross: expected |nu_cross| < 1, found 1.5"}));
}

} // namespace
} // namespace maille
