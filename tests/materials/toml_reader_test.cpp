#include "maille/materials/toml_reader.hpp"
#include "materials/read_helpers.hpp"

#include <gtest/gtest.h>

#include <limits>

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

} // namespace

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
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(found[i].starts_with("scene.toml:" + std::to_string(i + 1) + ":")) << found[i];
  }
}

TEST(TomlReaderContract, NumbersThatAreNotFiniteAreFaults) {
  for (const char* text : {"spacing = inf", "spacing = -inf", "spacing = nan", "spacing = \"nan mm\""}) {
    EXPECT_EQ(faults_of(text, read_strip).size(), 1U) << text;
  }
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
  EXPECT_NE(vector[0].find("one quantity or a list of three"), std::string::npos) << vector[0];
  EXPECT_NE(vector[0].find("found [1, 2]"), std::string::npos) << vector[0];
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
  try {
    faults.throw_if_any();
    FAIL() << "a missing key is a fault";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "scene.toml:3: specimen.spacing: expected a length > 0, found nothing");
  }
}

TEST(TomlReaderContract, TextThatIsNoTomlHasItsLine) {
  const Messages faults = faults_of("title = \"t\"\nspacing = = 3\n", read_strip);
  ASSERT_EQ(faults.size(), 1U);
  EXPECT_EQ(faults[0].rfind("scene.toml:2: expected valid TOML, found ", 0), 0U) << faults[0];
}

TEST(TomlReaderContract, ALongTextIsCutBetweenCharacters) {
  std::string text = "title = 1\nspacing = \"";
  for (int i = 0; i < 50; ++i) {
    text += "\u00e9\u00e9\u00e9";
  }
  const Messages faults = faults_of(text + "\"", read_strip);
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_TRUE(faults[1].ends_with("\u00e9...\"")) << faults[1];
}

TEST(ReadLimitsContract, OneNumberMeansAllTheSame) {
  const toml::table document = parse_toml("stretch = 1.3\ncompress = [0.8, 0.9, \"95 %\"]\nshear = 0.2", "s");
  FaultList faults("s");
  TableReader table(document, "", faults);
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
  TableReader table(document, "", faults);
  const auto limits = read_neighbour_limits(table);
  ASSERT_TRUE(limits);
  EXPECT_EQ(*limits,
            (NeighbourLimits{{1, 1, 1}, {1, 1, 1}, {{{0, 0.12, 0.13}, {0.21, 0, 0.23}, {0.31, 0.32, 0}}}}));
}

TEST(ReadLimitsContract, NoneOfTheKeysMeansNoLimits) {
  const toml::table document = parse_toml("density = 1000", "s");
  FaultList faults("s");
  TableReader table(document, "", faults);
  EXPECT_EQ(read_neighbour_limits(table), std::nullopt);
  EXPECT_TRUE(faults.empty());
}

TEST(ReadLimitsContract, LimitsThatForbidTheRestStateAreFaults) {
  const auto read = [](TableReader& table) { EXPECT_EQ(read_neighbour_limits(table), std::nullopt); };
  EXPECT_EQ(
      faults_of("stretch = 0.9\ncompress = [0.8, 1.1, -1]\nshear = -0.1", read),
      (Messages{"scene.toml:1: stretch: expected a ratio >= 1 (largest distance / rest), found 0.9",
                "scene.toml:2: compress: expected a ratio from 0 to 1 (smallest distance / rest), found 1.1",
                "scene.toml:2: compress: expected a ratio from 0 to 1 (smallest distance / rest), found -1",
                "scene.toml:3: shear: expected a ratio >= 0 (largest shear / rest), found -0.1"}));
  EXPECT_EQ(faults_of("shear = [[0, 1, 1],\n [1, 0, -2],\n [1, 1, 0]]", read),
            (Messages{"scene.toml:2: shear[1][2]: expected a ratio >= 0 (largest shear / rest), found -2"}));
  EXPECT_EQ(faults_of("shear = [1, 2, 3]", read).size(), 1U);
}

} // namespace maille
