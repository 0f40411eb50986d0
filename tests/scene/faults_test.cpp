#include "maille/scene/read_scene.hpp"

#include "maille/materials/fault.hpp"
#include "support/mistake.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using test::expect_only;
using test::Mistake;
using test::with_mistake;

std::vector<Fault> faults_of(const std::string& text) {
  return test::faults_found_by([&] { parse_scene(text, "scene.toml"); });
}

const std::string good = R"([specimen]
shape = "box"
cells = [4, 2, 2]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["1 mm", 0, 0]
)";

class MistakeContract : public testing::TestWithParam<Mistake> {};

TEST_P(MistakeContract, IsReportedWithItsLineAndKey) {
  const std::vector<Fault> faults = faults_of(with_mistake(good, GetParam()));
  expect_only(GetParam(), faults);
  for (const Fault& fault : faults)
    EXPECT_EQ(fault.file, "scene.toml");
}

INSTANTIATE_TEST_SUITE_P(
    OneAtATime, MistakeContract,
    testing::Values(
        Mistake{"wrong_unit", "\"1 mm\"", "\"1 kPa\"", 4, "specimen.spacing", "length"},
        Mistake{"negative_spacing", "\"1 mm\"", "\"-1 mm\"", 4, "specimen.spacing", "> 0"},
        Mistake{"no_spacing", "spacing = \"1 mm\"\n", "", 1, "specimen.spacing", "length"},
        Mistake{"zero_cells", "[4, 2, 2]", "[4, 0, 2]", 3, "specimen.cells", "> 0"},
        Mistake{"too_many_axes", "[4, 2, 2]", "[4, 2, 2, 2]", 3, "specimen.cells", "three"},
        Mistake{"grid_beyond_memory", "[4, 2, 2]", "[90000, 90000, 90000]", 3, "specimen.cells", "MiB"},
        Mistake{"unknown_shape", "\"box\"", "\"ball\"", 2, "specimen.shape", "ellipsoid"},
        Mistake{"unknown_key", "cells =", "colour = 3\ncells =", 3, "specimen.colour", "cells"},
        Mistake{"unknown_section", "[[hold]]", "[solver]\nfast = true\n[[hold]]", 6, "solver", "limits"},
        Mistake{"unknown_material", "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }",
                "\"muscle/soleuss\"", 5, "specimen.material", "muscle/soleus"},
        Mistake{"negative_modulus", "10 kPa", "-10 kPa", 5, "specimen.material.youngs_modulus", "> 0"},
        Mistake{"not_positive_definite", "0.3 }", "0.6 }", 5, "specimen.material.poisson_ratio", "0.5"},
        Mistake{"unknown_face", "where = \"x-\"", "where = \"w-\"", 7, "hold[1].where", "x-"},
        Mistake{"no_node_in_it", "where = \"x+\"",
                "where = { box = [[\"1 m\", \"1 m\", \"1 m\"], [\"2 m\", \"2 m\", \"2 m\"]] }", 9,
                "move[1].where", "node"},
        Mistake{"turn_of_any_size", "by = [\"1 mm\", 0, 0]",
                "turn = { angle = \"1e300 deg\", axis = [1, 0, 0] }", 10, "move[1].turn.angle",
                "a hundred full turns"},
        Mistake{"held_and_moved", "where = \"x+\"", "where = \"x-\"", 8, "move[1]",
                "held or moved, not both"},
        Mistake{"by_beyond_the_dimension", "[\"1 mm\", 0, 0]", "[\"1 mm\", 0]", 10, "move[1].by", "3"},
        Mistake{"turn_without_angle", "by = [\"1 mm\", 0, 0]", "turn = { axis = [0, 0, 1] }", 10,
                "move[1].turn.angle", "an angle"},
        Mistake{"turn_by_a_length", "by = [\"1 mm\", 0, 0]", "turn = { angle = \"1 mm\", axis = [0, 0, 1] }",
                10, "move[1].turn.angle", "angle"},
        Mistake{"turn_about_nothing", "by = [\"1 mm\", 0, 0]",
                "turn = { angle = \"9 deg\", axis = [0, 0, 0] }", 10, "move[1].turn.axis", "not zero"},
        Mistake{"turn_without_axis", "by = [\"1 mm\", 0, 0]", "turn = { angle = \"9 deg\" }", 10,
                "move[1].turn.axis", "[0, 0, 1]"},
        Mistake{"turn_of_a_hold", "where = \"x-\"",
                "where = \"x-\"\nturn = { angle = \"1 rad\", axis = [0, 0, 1] }", 8, "hold[1].turn", "axes"},
        Mistake{"bad_axes", "where = \"x-\"", "where = \"x-\"\naxes = \"xw\"", 8, "hold[1].axes", "xyz"},
        Mistake{"plane_in_3d", "shape =", "plane = \"stress\"\nshape =", 2, "specimen.plane",
                "two-dimensional"},
        Mistake{"limits_without_values", "[[hold]]", "[limits]\nfrom = \"material\"\n[[hold]]", 7,
                "limits.from", "taut"},
        Mistake{"not_toml", "[4, 2, 2]", "[4, 2, 2", 4, "", "TOML"},
        Mistake{"load_of_nothing", "[[move]]", "[[load]]\nwhere = \"x+\"\n[[move]]", 8, "load[1]",
                "traction"}),
    [](const auto& mistake) { return mistake.param.name; });

TEST(SceneFaultsContract, AllFaultsOfAFileComeAtOnceInTheOrderOfTheirLines) {
  const auto faults = faults_of(R"([specimen]
shape = "box"
cells = [4, -2, 2]
spacing = "1 s"
material = { youngs_modulus = "-1 Pa", poisson_ratio = 2, colour = "red" }
[[hold]]
wear = "x-"
[[move]]
where = "x+"
by = "1 furlong"
)");
  ASSERT_GE(faults.size(), 8u);
  for (std::size_t i = 1; i < faults.size(); ++i)
    EXPECT_LE(faults[i - 1].line, faults[i].line);
  const std::string all = InputError(faults).what();
  for (const char* key : {"specimen.cells", "specimen.spacing", "youngs_modulus", "colour", "hold[1].wear",
                          "hold[1].where", "move[1].by"})
    EXPECT_NE(all.find(key), std::string::npos) << all;
}

TEST(SceneFaultsContract, MovesThatDisagreeAreNamedWithTheirPlace) {
  const auto faults = faults_of(
      good + "[[move]]\nwhere = { box = [[\"4 mm\", 0, 0], [\"4 mm\", 0, 0]] }\nby = [\"2 mm\", 0, 0]\n");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].line, 11);
  EXPECT_NE(faults[0].found.find("(0.004, 0, 0)"), std::string::npos) << faults[0].found;
}

TEST(SceneFaultsContract, ContradictionsShowBesideAnEmptyHandle) {
  const auto faults =
      faults_of(good + "[[move]]\nwhere = { box = [[\"9 m\", 0, 0], [\"9 m\", 0, 0]] }\nby = 0\n"
                       "[[move]]\nwhere = \"x+\"\nby = [\"2 mm\", 0, 0]\n");
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0].key, "move[2].where");
  EXPECT_EQ(faults[1].key, "move[3]");
}

TEST(SceneFaultsContract, MovesThatAgreeMayOverlap) {
  EXPECT_TRUE(
      faults_of(good +
                "[[move]]\nwhere = { box = [[\"4 mm\", 0, 0], [\"4 mm\", 0, 0]] }\nby = [\"1 mm\", 0, 0]\n")
          .empty());
}

TEST(SceneFaultsContract, NothingThatKeepsTheBodyInPlaceIsAFault) {
  const auto faults = faults_of(good.substr(0, good.find("[[hold]]")));
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, "hold");
}

TEST(SceneFaultsContract, MissingFilesAreNamed) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(read_scene(folder.path() / "none.toml"), InputError);
  EXPECT_THROW(read_scene(folder.path()), InputError); // a folder is no scene
  const auto file = folder.write(
      "scene.toml",
      "[specimen]\nshape = \"image\"\nimage = \"none.nii.gz\"\nmaterial = \"fat/subcutaneous\"\n");
  try {
    read_scene(file);
    FAIL() << "read";
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().at(0).line, 3);
    EXPECT_NE(std::string(error.what()).find("none.nii.gz"), std::string::npos);
  }
}

} // namespace
} // namespace maille
