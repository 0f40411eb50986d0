/// The [[measure]] tables of a scene file and their faults.
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/read_scene.hpp"

#include "support/label_scene.hpp"
#include "support/mistake.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using test::Mistake;

const std::string good = R"(units = "mm"
[specimen]
shape = "box"
cells = [4, 2, 2]
spacing = 1
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3, name = "soft" }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = [1, 0, 0]
[[measure]]
name = "pull"
force = "move[1]"
component = "x"
[[measure]]
name = "cut"
force = { section = { point = [2, 0, 0], normal = [1, 0, 0] } }
[[measure]]
name = "end"
force = { where = "x-" }
[[measure]]
name = "tip"
displacement = { at = [3, 1, 1] }
[[measure]]
name = "line"
strain = { along = [[0, 1, 1], [4, 1, 1]], points = 5 }
kind = "xx"
[[measure]]
name = "ball"
stress = { mean = { sphere = { centre = [2, 1, 1], radius = 1 } } }
[[measure]]
name = "tendon"
length = [[0, 0, 0], [4, 2, 2]]
[[measure]]
name = "bend"
angle = [[0, 0, 0], [2, 1, 1], [4, 0, 0]]
[[measure]]
name = "bulk"
volume = { material = "soft" }
[[measure]]
name = "stored"
energy = "body"
)";

TEST(MeasuresReadContract, TheGoodFileReads) {
  const SceneAndMeasures read = parse_scene_and_measures(good);
  ASSERT_EQ(read.measures.size(), 10u);
  EXPECT_EQ(in_words(read.measures[0]), "force on move[1], along (1, 0, 0)");
  EXPECT_EQ(read.measures[1].columns(), (std::vector<std::string>{"cut", "cut_x", "cut_y", "cut_z"}));
  EXPECT_EQ(read.measures[4].columns(), std::vector<std::string>{}) << "a line has a file";
  EXPECT_EQ(in_words(read.measures[5]), "von Mises stress, mean of a sphere") << "no fibres";
  EXPECT_EQ(read.measures[8].cells.size(), 16u);
  EXPECT_EQ(parse_scene(good).prescribed.size(), read.scene.prescribed.size());
}

class ReadMeasuresContract : public testing::TestWithParam<Mistake> {};

TEST_P(ReadMeasuresContract, NamesTheFault) {
  const std::string text = test::with_mistake(good, GetParam());
  test::expect_only(GetParam(), test::faults_found_by([&] { parse_scene_and_measures(text); }));
  test::expect_only(GetParam(), test::faults_found_by([&] { parse_scene(text); }));
}

INSTANTIATE_TEST_SUITE_P(
    Faults, ReadMeasuresContract,
    testing::Values(
        Mistake{"NoName", "name = \"pull\"\n", "", 12, "measure[1].name", "letters, digits and _"},
        Mistake{"NoIdentifier", "\"pull\"", "\"2 pulls\"", 13, "measure[1].name", "begins with no digit"},
        Mistake{"Twice", "\"cut\"", "\"pull\"", 17, "measure[2].name", "again"},
        Mistake{"ColumnOfAnother", "\"pull\"", "\"cut_x\"", 17, "measure[2].name", "cut_x"},
        Mistake{"ErrorOfAnother", "\"tip\"", "\"cut_error\"", 23, "measure[4].name", "cut_error"},
        Mistake{"ColumnOfResults", "\"pull\"", "\"bytes\"", 13, "measure[1].name", "\"bytes\""},
        Mistake{"FileOfResults", "\"line\"", "\"force\"", 26, "measure[5].name", "\"force\""},
        Mistake{"ErrorOfResults", "\"pull\"", "\"strain\"", 13, "measure[1].name", "strain_error"},
        Mistake{"Nothing", "force = \"move[1]\"\ncomponent = \"x\"\n", "", 12, "measure[1]", "none of them"},
        Mistake{"TwoQuantities", "force = \"move[1]\"", "force = \"move[1]\"\nenergy = \"body\"", 15,
                "measure[1].energy", "energy beside force"},
        Mistake{"UnknownMove", "\"move[1]\"", "\"move[2]\"", 14, "measure[1].force", "1 holds and 1 moves"},
        Mistake{"UnknownCondition", "\"move[1]\"", "\"x+\"", 14, "measure[1].force", "\"hold[N]\""},
        Mistake{"BadComponent", "component = \"x\"", "component = \"xy\"", 15, "measure[1].component",
                "magnitude"},
        Mistake{"NormalOfNothing", "component = \"x\"", "component = \"normal\"", 15, "measure[1].component",
                "section alone"},
        Mistake{"ZeroDirection", "component = \"x\"", "component = [0, 0, 0]", 15, "measure[1].component",
                "not all 0"},
        Mistake{"KindOfForce", "component = \"x\"", "kind = \"xx\"", 15, "measure[1].kind", "of a force"},
        Mistake{"PlaneOutside", "point = [2, 0, 0]", "point = [5, 0, 0]", 18, "measure[2].force.section",
                "both sides"},
        Mistake{"PlaneOnAFace", "point = [2, 0, 0]", "point = [4, 0, 0]", 18, "measure[2].force.section",
                "both sides"},
        Mistake{"NoNormal", ", normal = [1, 0, 0] }", " }", 18, "measure[2].force.section.normal",
                "a direction"},
        Mistake{"RegionWithoutForces", "force = { where = \"x-\" }",
                "force = { where = { box = [[1, 0, 0], [3, 2, 2]] } }", 21, "measure[3].force.where",
                "held or moved nodes"},
        Mistake{"Outside", "at = [3, 1, 1]", "at = [3, 1, 2.1]", 24, "measure[4].displacement.at",
                "from (0, 0, 0) m to (0.004, 0.002, 0.002) m"},
        Mistake{"UnknownUnit", "at = [3, 1, 1]", "at = [3, 1, \"1 furlong\"]", 24,
                "measure[4].displacement.at", "furlong"},
        Mistake{"TwoNumbers", "at = [3, 1, 1]", "at = [3, 1]", 24, "measure[4].displacement.at", "3 lengths"},
        Mistake{"TwoTargets", "at = [3, 1, 1]", "at = [3, 1, 1], mean = \"body\"", 24,
                "measure[4].displacement", "several"},
        Mistake{"NoTarget", "{ at = [3, 1, 1] }", "{}", 24, "measure[4].displacement", "none of them"},
        Mistake{"PointsOfAPoint", "at = [3, 1, 1]", "at = [3, 1, 1], points = 3", 24,
                "measure[4].displacement.points", "without along"},
        Mistake{"LineOutside", "[[0, 1, 1], [4, 1, 1]]", "[[0, 9, 1], [4, 9, 1]]", 27,
                "measure[5].strain.along", "a line through the matter"},
        Mistake{"OnePoint", "points = 5", "points = 1", 27, "measure[5].strain.points", "2"},
        Mistake{"OneEnd", "[[0, 1, 1], [4, 1, 1]]", "[[0, 1, 1]]", 27, "measure[5].strain.along", "2 points"},
        Mistake{"UnknownKind", "kind = \"xx\"", "kind = \"yx\"", 28, "measure[5].kind", "fibre"},
        Mistake{"FibreOfNone", "kind = \"xx\"", "kind = \"fibre\"", 28, "measure[5].kind", "isotropic"},
        Mistake{"PressureOfStrain", "kind = \"xx\"", "kind = \"pressure\"", 28, "measure[5].kind", "fibre"},
        Mistake{"EmptySphere", "centre = [2, 1, 1], radius = 1", "centre = [2, 1, 1], radius = 0.1", 31,
                "measure[6].stress.mean.sphere", "middle of at least one cell"},
        Mistake{"NegativeRadius", "radius = 1", "radius = -1", 31, "measure[6].stress.mean.sphere.radius",
                "> 0"},
        Mistake{"NoLabels", "{ sphere = { centre = [2, 1, 1], radius = 1 } }", "{ label = 17 }", 31,
                "measure[6].stress.mean.label", "without labels"},
        Mistake{"NoCells", "{ sphere = { centre = [2, 1, 1], radius = 1 } }", "{ where = \"x+\" }", 31,
                "measure[6].stress.mean.where", "whole cell"},
        Mistake{"UnknownPart", "{ sphere = { centre = [2, 1, 1], radius = 1 } }", "\"head\"", 31,
                "measure[6].stress.mean", "\"body\""},
        Mistake{"NoLength", "[[0, 0, 0], [4, 2, 2]]", "[[0, 0, 0], [0, 0, 0]]", 34, "measure[7].length",
                "points that differ"},
        Mistake{"LengthOutside", "[[0, 0, 0], [4, 2, 2]]", "[[0, 0, 0], [5, 2, 2]]", 34, "measure[7].length",
                "(0.005, 0.002, 0.002) m"},
        Mistake{"TwoPointsOfAnAngle", "[[0, 0, 0], [2, 1, 1], [4, 0, 0]]", "[[0, 0, 0], [2, 1, 1]]", 37,
                "measure[8].angle", "3 to 4 points"},
        Mistake{"NoAngle", "[[0, 0, 0], [2, 1, 1], [4, 0, 0]]", "[[2, 1, 1], [2, 1, 1], [4, 0, 0]]", 37,
                "measure[8].angle", "two that are one"},
        Mistake{"UnknownMaterial", "{ material = \"soft\" }", "{ material = \"hard\" }", 40,
                "measure[9].volume.material", "soft"},
        Mistake{"UnknownKey", "energy = \"body\"", "energy = \"body\"\nof = 3", 44, "measure[10].of", "of"},
        Mistake{"Lattice", "shape = \"box\"", "shape = \"box\"\nlattice = \"fibre\"", 4, "specimen.lattice",
                "[[measure]]"}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(MeasuresOfLabelsContract, ALabelWithoutVoxels) {
  const image_tests::TemporaryFolder folder;
  folder.write("labels.nii", test::nifti_of(test::bent_body()));
  const std::string text = std::string(test::label_scene_text) +
                           "[[measure]]\nname = \"calf\"\nvolume = { label = 99 }\n[[measure]]\nname = "
                           "\"calf_2\"\nstrain = { mean = { label = 99 } }\n";
  const auto faults =
      test::faults_found_by([&] { read_scene_and_measures(folder.write("scene.toml", text)); });
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0].key, "measure[1].volume.label");
  EXPECT_EQ(faults[1].key, "measure[2].strain.mean.label");
  EXPECT_NE(faults[0].expected.find("5, 17"), std::string::npos) << faults[0].expected;
}

// Faults of measures come together with those of the rest, and none comes of a hold that is at fault itself.
TEST(MeasuresAndOthersContract, AllFaultsAtOnce) {
  const auto faults = test::faults_found_by([] {
    parse_scene_and_measures(R"(
[specimen]
shape = "box"
cells = [4, 2]
spacing = "1 parsec"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "w-"
[[measure]]
name = "a"
force = "hold[1]"
[[measure]]
name = "b"
displacement = { at = ["1 mm", "1 stone"] }
[[measure]]
name = "b"
volume = { label = "x" }
)");
  });
  std::vector<std::string> keys;
  for (const Fault& fault : faults)
    keys.push_back(fault.key);
  EXPECT_EQ(keys, (std::vector<std::string>{"specimen.spacing", "hold[1].where", "measure[2].displacement.at",
                                            "measure[3].name", "measure[3].volume.label"}))
      << InputError(faults).what();
}

TEST(ReadMeasuresContract, WhatLeavesThePlaneOf2DIsAFault) {
  const auto faults = test::faults_found_by([] {
    parse_scene_and_measures(R"(
[specimen]
shape = "box"
cells = [4, 2]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[measure]]
name = "a"
displacement = { at = ["1 mm", "1 mm", "1 mm"] }
[[measure]]
name = "b"
force = { section = { point = ["2 mm", "1 mm"], normal = [1, 0, 1] } }
)");
  });
  std::vector<std::string> keys;
  for (const Fault& fault : faults)
    keys.push_back(fault.key);
  EXPECT_EQ(keys, (std::vector<std::string>{"measure[1].displacement.at", "measure[2].force.section.normal"}))
      << InputError(faults).what();
}

/// Truth: half the spacing has the same surface, on which a point written to seven digits lies too.
TEST(ReadMeasuresContract, APointOfTheSurfaceStaysOnItOnFinerLattices) {
  Specimen coarse, fine;
  coarse.grid = Grid(3, {3, 2, 2}, {0.1, 0.1, 0.1});
  fine.grid = Grid(3, {6, 4, 4}, {0.05, 0.05, 0.05});
  const MaterialPoint point = located(coarse, {0.3 + 0.8e-7, 0.1, 0.1});
  EXPECT_FALSE(point.cells.empty());
  EXPECT_FALSE(located(fine, point.place).cells.empty());
}

} // namespace
} // namespace maille
