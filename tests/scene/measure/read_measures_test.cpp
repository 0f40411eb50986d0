/// The [[measure]] tables of a scene file and their faults.

#include "maille/deform/solve.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/read_scene.hpp"
#include "measure/section.hpp"
#include "support/dice.hpp"
#include "support/kit.hpp"
#include "support/label_scene.hpp"

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

const Mistake mistakes[] = {
    {"NoName", "name = \"pull\"\n", "", 12, "measure[1].name", "letters, digits and _"},
    {"NoIdentifier", "\"pull\"", "\"2 pulls\"", 13, "measure[1].name", "begins with no digit"},
    {"Twice", "\"cut\"", "\"pull\"", 17, "measure[2].name", "again"},
    {"ColumnOfAnother", "\"pull\"", "\"cut_x\"", 17, "measure[2].name", "cut_x"},
    {"ErrorOfAnother", "\"tip\"", "\"cut_error\"", 23, "measure[4].name", "cut_error"},
    {"ColumnOfResults", "\"pull\"", "\"bytes\"", 13, "measure[1].name", "\"bytes\""},
    {"FileOfResults", "\"line\"", "\"force\"", 26, "measure[5].name", "\"force\""},
    {"ErrorOfResults", "\"pull\"", "\"strain\"", 13, "measure[1].name", "strain_error"},
    {"Nothing", "force = \"move[1]\"\ncomponent = \"x\"\n", "", 12, "measure[1]", "none of them"},
    {"TwoQuantities", "force = \"move[1]\"", "force = \"move[1]\"\nenergy = \"body\"", 15,
     "measure[1].energy", "energy beside force"},
    {"UnknownMove", "\"move[1]\"", "\"move[2]\"", 14, "measure[1].force", "1 holds and 1 moves"},
    {"UnknownCondition", "\"move[1]\"", "\"x+\"", 14, "measure[1].force", "\"hold[N]\""},
    {"BadComponent", "component = \"x\"", "component = \"xy\"", 15, "measure[1].component", "magnitude"},
    {"NormalOfNothing", "component = \"x\"", "component = \"normal\"", 15, "measure[1].component",
     "section alone"},
    {"ZeroDirection", "component = \"x\"", "component = [0, 0, 0]", 15, "measure[1].component", "not all 0"},
    {"KindOfForce", "component = \"x\"", "kind = \"xx\"", 15, "measure[1].kind", "of a force"},
    {"PlaneOutside", "point = [2, 0, 0]", "point = [5, 0, 0]", 18, "measure[2].force.section", "both sides"},
    {"PlaneOnAFace", "point = [2, 0, 0]", "point = [4, 0, 0]", 18, "measure[2].force.section", "both sides"},
    {"NoNormal", ", normal = [1, 0, 0] }", " }", 18, "measure[2].force.section.normal", "a direction"},
    {"RegionWithoutForces", "force = { where = \"x-\" }",
     "force = { where = { box = [[1, 0, 0], [3, 2, 2]] } }", 21, "measure[3].force.where",
     "held or moved nodes"},
    {"Outside", "at = [3, 1, 1]", "at = [3, 1, 2.1]", 24, "measure[4].displacement.at",
     "from (0, 0, 0) m to (0.004, 0.002, 0.002) m"},
    {"UnknownUnit", "at = [3, 1, 1]", "at = [3, 1, \"1 furlong\"]", 24, "measure[4].displacement.at",
     "furlong"},
    {"TwoNumbers", "at = [3, 1, 1]", "at = [3, 1]", 24, "measure[4].displacement.at", "3 lengths"},
    {"TwoTargets", "at = [3, 1, 1]", "at = [3, 1, 1], mean = \"body\"", 24, "measure[4].displacement",
     "several"},
    {"NoTarget", "{ at = [3, 1, 1] }", "{}", 24, "measure[4].displacement", "none of them"},
    {"PointsOfAPoint", "at = [3, 1, 1]", "at = [3, 1, 1], points = 3", 24, "measure[4].displacement.points",
     "without along"},
    {"LineOutside", "[[0, 1, 1], [4, 1, 1]]", "[[0, 9, 1], [4, 9, 1]]", 27, "measure[5].strain.along",
     "a line through the matter"},
    {"OnePoint", "points = 5", "points = 1", 27, "measure[5].strain.points", "2"},
    {"OneEnd", "[[0, 1, 1], [4, 1, 1]]", "[[0, 1, 1]]", 27, "measure[5].strain.along", "2 points"},
    {"UnknownKind", "kind = \"xx\"", "kind = \"yx\"", 28, "measure[5].kind", "fibre"},
    {"FibreOfNone", "kind = \"xx\"", "kind = \"fibre\"", 28, "measure[5].kind", "isotropic"},
    {"PressureOfStrain", "kind = \"xx\"", "kind = \"pressure\"", 28, "measure[5].kind", "fibre"},
    {"EmptySphere", "centre = [2, 1, 1], radius = 1", "centre = [2, 1, 1], radius = 0.1", 31,
     "measure[6].stress.mean.sphere", "middle of at least one cell"},
    {"NegativeRadius", "radius = 1", "radius = -1", 31, "measure[6].stress.mean.sphere.radius", "> 0"},
    {"NoLabels", "{ sphere = { centre = [2, 1, 1], radius = 1 } }", "{ label = 17 }", 31,
     "measure[6].stress.mean.label", "without labels"},
    {"NoCells", "{ sphere = { centre = [2, 1, 1], radius = 1 } }", "{ where = \"x+\" }", 31,
     "measure[6].stress.mean.where", "whole cell"},
    {"UnknownPart", "{ sphere = { centre = [2, 1, 1], radius = 1 } }", "\"head\"", 31,
     "measure[6].stress.mean", "\"body\""},
    {"NoLength", "[[0, 0, 0], [4, 2, 2]]", "[[0, 0, 0], [0, 0, 0]]", 34, "measure[7].length",
     "points that differ"},
    {"LengthOutside", "[[0, 0, 0], [4, 2, 2]]", "[[0, 0, 0], [5, 2, 2]]", 34, "measure[7].length",
     "(0.005, 0.002, 0.002) m"},
    {"TwoPointsOfAnAngle", "[[0, 0, 0], [2, 1, 1], [4, 0, 0]]", "[[0, 0, 0], [2, 1, 1]]", 37,
     "measure[8].angle", "3 to 4 points"},
    {"NoAngle", "[[0, 0, 0], [2, 1, 1], [4, 0, 0]]", "[[2, 1, 1], [2, 1, 1], [4, 0, 0]]", 37,
     "measure[8].angle", "two that are one"},
    {"UnknownMaterial", "{ material = \"soft\" }", "{ material = \"hard\" }", 40,
     "measure[9].volume.material", "soft"},
    {"UnknownKey", "energy = \"body\"", "energy = \"body\"\nof = 3", 44, "measure[10].of", "of"},
    {"Lattice", "shape = \"box\"", "shape = \"box\"\nlattice = \"fibre\"", 4, "specimen.lattice",
     "[[measure]]"},
};

TEST(ReadMeasuresContract, NamesTheFault) {
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.name);
    const std::string text = test::with_mistake(good, mistake);
    test::expect_only(mistake, test::faults_found_by([&] { parse_scene_and_measures(text); }));
    test::expect_only(mistake, test::faults_found_by([&] { parse_scene(text); }));
  }
}

TEST(MeasuresOfLabelsContract, ALabelWithoutVoxels) {
  const image_tests::TemporaryFolder folder;
  folder.write("labels.nii", test::nifti_of(test::bent_body()));
  const std::string text = std::string(test::label_scene_text) +
                           "[[measure]]\nname = \"calf\"\nvolume = { label = 99 }\n[[measure]]\nname = "
                           "\"calf_2\"\nstrain = { mean = { label = 99 } }\n";
  const auto faults =
      test::faults_found_by([&] { read_scene_and_measures(folder.write("scene.toml", text)); });
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_TRUE(test::says(faults[0], {.key = "measure[1].volume.label", .expected = "5, 17"}));
  EXPECT_EQ(faults[1].key, "measure[2].strain.mean.label");
}

// Faults of measures come together with those of the rest, and none comes of a hold that is at fault itself.
TEST(MeasuresAndOthersContract, AllFaultsAtOnce) {
  const auto faults = test::faults_found_by([] {
    std::string body = test::box_text("[4, 2]") + test::hold_text("w-");
    body.replace(body.find("1 mm"), 4, "1 parsec");
    parse_scene_and_measures(body + test::measure_text("a", "force = \"hold[1]\"") +
                             test::measure_text("b", "displacement = { at = [\"1 mm\", \"1 stone\"] }") +
                             test::measure_text("b", "volume = { label = \"x\" }"));
  });
  EXPECT_EQ(test::keys_of(faults),
            (std::vector<std::string>{"specimen.spacing", "hold[1].where", "measure[2].displacement.at",
                                      "measure[3].name", "measure[3].volume.label"}));
}

TEST(ReadMeasuresContract, WhatLeavesThePlaneOf2DIsAFault) {
  const auto faults = test::faults_found_by([] {
    parse_scene_and_measures(
        test::box_text("[4, 2]") + test::hold_text() +
        test::measure_text("a", R"(displacement = { at = ["1 mm", "1 mm", "1 mm"] })") +
        test::measure_text("b", R"(force = { section = { point = ["2 mm", "1 mm"], normal = [1, 0, 1] } })"));
  });
  EXPECT_EQ(test::keys_of(faults),
            (std::vector<std::string>{"measure[1].displacement.at", "measure[2].force.section.normal"}));
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

/// Forces across planes.

// Truth: counting points on a fine grid.
TEST(SectionOracle, ShareOfABoxBeyondAPlane) {
  std::mt19937 random(11);
  test::Dice dice{random};
  for (int round = 0; round < 60; ++round) {
    const std::array<double, 3> size{dice.between(0.5, 2), dice.between(0.5, 2), dice.between(0.5, 2)},
        normal{dice.between(-1, 1), round % 3 == 0 ? 0 : dice.between(-1, 1), dice.between(-1, 1)};
    const double offset = dice.between(-1, 1);
    constexpr int n = 60;
    int beyond = 0;
    for (const auto& [i, j, k] : test::all_below({n, n, n}))
      beyond += normal[0] * size[0] * (i + 0.5) / n + normal[1] * size[1] * (j + 0.5) / n +
                            normal[2] * size[2] * (k + 0.5) / n >
                        offset
                    ? 1
                    : 0;
    EXPECT_NEAR(share_beyond(size, normal, offset), beyond / double(n * n * n), 0.01) << round;
  }
}

// Truth: halves, quarters and corners of a cube by hand; nearly degenerate normals change little.
TEST(SectionAnalytic, SharesByHand) {
  const std::array<double, 3> cube{1, 1, 1};
  const auto share = [&](std::array<double, 3> normal, double offset) {
    return share_beyond(cube, normal, offset);
  };
  EXPECT_NEAR(share({1, 0, 0}, 0.25), 0.75, 1e-15);
  EXPECT_NEAR(share({-1, 0, 0}, -0.25), 0.25, 1e-15);
  EXPECT_NEAR(share({1, 1, 0}, 1), 0.5, 1e-15);
  EXPECT_NEAR(share({1, 1, 1}, 0.5), 1 - 0.125 / 6, 1e-15);
  EXPECT_NEAR(share({1, 1, 1}, 1.5), 0.5, 1e-15);
  EXPECT_EQ(share({1, 1, 1}, 3), 0);
  EXPECT_EQ(share({1, 1, 1}, 0), 1);
  for (const double tilt : {1e-3, 1e-4, 1.1e-5, 9e-6, 1e-6, 1e-9, 0.0})
    EXPECT_NEAR(share({1, tilt, -tilt}, 0.3), 0.7, 1e-9) << tilt;
  EXPECT_EQ(share_beyond({}, {}, -1), 1);
  EXPECT_EQ(share_beyond({}, {}, 0), 0);
}

struct Bar {
  SceneAndMeasures read;
  std::vector<MeasuredValue> values;
  Answer answer;

  Bar(const std::string& conditions, const std::vector<double>& places_mm, const std::string& component,
      const char* normal = "[1, 0, 0]", const char* shape = "box") {
    std::string text = fmt::format("[specimen]\nshape = \"{}\"\ncells = [10, 4, 4]\nspacing = \"1 "
                                   "mm\"\nmaterial = {{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, "
                                   "density = 1200 }}\n[relaxation]\ntolerance = 1e-10\n{}",
                                   shape, conditions);
    for (std::size_t i = 0; i < places_mm.size(); ++i)
      text +=
          fmt::format("[[measure]]\nname = \"s{}\"\nforce = {{ section = {{ point = [\"{} mm\", \"2 mm\", "
                      "\"2 mm\"], normal = {} }} }}\n{}",
                      i, places_mm[i], normal, component);
    read = parse_scene_and_measures(text);
    answer = deform::solve(read.scene, "coupled");
    EXPECT_EQ(answer.status, Status::done) << answer.message;
    values = measured(read.scene, read.measures, answer);
  }
};

// Truth: a bar is pulled by the same force across every plane, oblique ones too: the move's.
TEST(SectionAnalytic, APulledBarHasOneForceAtEveryPlace) {
  for (const char* normal : {"[1, 0, 0]", "[1, 0.2, -0.1]", "[3, 1, 1]"}) {
    const Bar bar("[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"0.5 mm\", \"0.2 mm\", 0]\n",
                  {2.5, 3, 4.2, 5, 7.5}, "", normal);
    Vec3 pull{};
    for (std::size_t i = 0; i < bar.answer.reaction.size(); ++i)
      if (const Prescribed& p = bar.read.scene.prescribed[i]; !p.held)
        pull[static_cast<std::size_t>(p.component)] += bar.answer.reaction[i];
    EXPECT_GT(pull[0], 1e-3);
    for (const MeasuredValue& value : bar.values)
      for (std::size_t a = 0; a < 3; ++a)
        EXPECT_NEAR((*value.vector)[a], pull[a], 1e-9 * pull[0]) << normal;
  }
}

// Truth: the weight of what hangs below the plane; a part of a cell weighs its part.
TEST(SectionAnalytic, AHangingBarCarriesTheWeightBeyond) {
  const std::vector<double> places{0.3, 1, 2.5, 4, 6.75, 9.9};
  const Bar bar("[[hold]]\nwhere = \"x-\"\n[[load]]\ngravity = [9.81, 0, 0]\n", places,
                "component = \"normal\"\n");
  const double weight = 1200 * 9.81 * 160e-9;
  for (std::size_t i = 0; i < places.size(); ++i)
    EXPECT_NEAR(*bar.values[i].value, weight * (10 - places[i]) / 10, 1e-9 * weight) << places[i];
}

// Truth: equilibrium from the other side: what lies before the plane is in balance, too, so that the normal
// turned round gives the opposite force. Both sums share no node and no cell but those that are cut.
TEST(SectionIndependent, BothSidesOfAPlaneAgree) {
  const std::string conditions =
      "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [0, 0, \"1 mm\"]\n[[load]]\ngravity = [0, "
      "-9.81, 4]\n[[load]]\nwhere = \"y+\"\ntraction = [\"10 Pa\", \"-30 Pa\", \"5 Pa\"]\n";
  const std::vector<double> places{2.4, 5.3, 7.1};
  const Bar one(conditions, places, "", "[2, 1, -1]"), other(conditions, places, "", "[-2, -1, 1]");
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR((*one.values[i].vector)[a], -(*other.values[i].vector)[a], 1e-8 * *one.values[i].value);
}

// Truth: held ends of a contracting bar carry the force of its fibres, across every plane.
TEST(SectionAnalytic, AContractingBarPullsAcrossEveryPlane) {
  const Bar bar("[[hold]]\nwhere = \"x-\"\n[[hold]]\nwhere = \"x+\"\n[[load]]\ncontraction = \"1 kPa\"\n",
                {2.5, 4, 6.1}, "component = \"x\"\n");
  double end = 0;
  for (std::size_t i = 0; i < bar.answer.reaction.size(); ++i)
    if (const Prescribed& p = bar.read.scene.prescribed[i];
        p.component == 0 && bar.read.scene.specimen.grid.node_at(p.node)[0] == 10)
      end += bar.answer.reaction[i];
  EXPECT_GT(end, 1e-3);
  for (const MeasuredValue& value : bar.values)
    EXPECT_NEAR(*value.value, end, 1e-8 * end);
}

} // namespace
} // namespace maille
