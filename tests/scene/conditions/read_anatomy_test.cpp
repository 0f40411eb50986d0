/// Scenes as anatomy has them: surfaces through cells, maps, laws, springs, drives and borders that slide,
/// and the faults of all.

#include "maille/materials/density_law.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/sliding.hpp"
#include "maille/scene/warp/displacement_field.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

constexpr int n = 12;

const std::string hold_below = "[[hold]]\nwhere = \"z-\"\n";
const std::string two_blocks = R"([specimen]
shape = "image"
image = "blocks.mha"
labels = { 1 = { youngs_modulus = "100 kPa", poisson_ratio = 0.3 }, 2 = { youngs_modulus = "50 kPa", poisson_ratio = 0.4 } }
)";

class Anatomy {
public:
  Anatomy() {
    folder_.write("blocks.mha",
                  test::float_image(n, 0, 1, [](const Index3& at, int) { return at[2] < 6 ? 1.0F : 2.0F; }));
    folder_.write("ramp.mha", test::float_image(
                                  n, 0, 1, [](const Index3& at, int) { return 100.0F + 5 * float(at[0]); }));
    folder_.write("gap.mha",
                  test::float_image(n, 0, 1, [](const Index3& at, int) { return at[0] == 3 ? NAN : 1.0F; }));
    folder_.write("gap3.mha",
                  test::float_image(n, 0, 3, [](const Index3& at, int) { return at[0] == 3 ? NAN : 0.01F; }));
    folder_.write("u.mha", test::float_image(n, 0, 3, [](const Index3& at, int c) {
                    return 0.01F * float(at[std::size_t(c)]);
                  }));
  }
  Scene read(const std::string& text) const { return read_scene(folder_.write("scene.toml", text)); }
  /// All faults, a line each: `key: found`.
  std::string faults(const std::string& text) const {
    std::string all;
    for (const Fault& fault : test::faults_found_by([&] { read(text); }))
      all += fault.key + ": " + fault.expected + ", " + fault.found + "\n";
    return all;
  }
  /// The two blocks, held at z-, and what is said of them and more.
  testing::AssertionResult say(const std::string& of_blocks, const std::string& more,
                               std::string_view part) const {
    return test::has(faults(two_blocks + of_blocks + hold_below + more), part);
  }
  const test::TemporaryFolder& folder() const { return folder_; }

private:
  test::TemporaryFolder folder_;
};

TEST(ReadAnatomyContract, EveryFaultIsNamed) {
  const Anatomy files;
  const std::string of_keys =
      files.faults(two_blocks + R"(stiffness = { image = "ramp.mha", law = "nobody", density = ["1 g/cm^3"] }
[[hold]]
where = "z-"
[[load]]
where = "z+"
foundation = "-10 kPa/mm"
along = "sideways"
[[load]]
contraction = "5 kPa"
course = [[0, 0], [0.5, 1], [0.4, 0.25]]
)");
  for (const char* key : {"specimen.stiffness.law", "specimen.stiffness.density", "load[1].foundation",
                          "load[1].along", "load[2].course"})
    EXPECT_TRUE(test::has(of_keys, key)) << key << " in\n";
  EXPECT_TRUE(files.say("", "[[drive]]\nlabel = 7\nby = [0, 0, \"1 mm\"]\n", "drive[1].label"));
  EXPECT_TRUE(files.say("", "[[sliding]]\nbetween = [1, 5]\n", "[1, 2]"));
  EXPECT_TRUE(files.say("", "[[sliding]]\nbetween = \"all\"\n",
                        "label 2 (864 cells) can still move along x, y and turn about z"));
  EXPECT_TRUE(files.say("stiffness = { image = \"gap.mha\", unit = \"kPa\" }\n", "",
                        "144 cells that are not a number"));
  EXPECT_TRUE(files.say("partial_volume = true\n", "", "partial_volume"));
}

// Truth: faults of a map, of regions in all their kinds and of measures come together, each with its key: the
// body is there, whatever its stiffness.
TEST(ReadAnatomyContract, AFaultyMapHidesNoOtherFault) {
  const Anatomy files;
  files.folder().write("far.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 100 0 0\nvertex 105 0 "
                                  "0\nvertex 100 5 0\nendloop\nendfacet\nendsolid\n");
  files.folder().write("tip.fcsv", "1,0,0,0,0,0,0,1,1,1,0,tip\n");
  const std::string found = files.faults("units = \"mm\"\n" + std::string(two_blocks) +
                                         R"(stiffness = { image = "gap.mha", unit = "kPa" }
[[hold]]
where = { sphere = { centre = [50, 50, 50], radius = 2 }, frame = "world" }
[[hold]]
where = { points = "tip.fcsv", within = 2 }
[[load]]
where = { surface = "far.stl", within = 1 }
pressure = "1 kPa"
[[move]]
where = "z+"
field = { image = "gap3.mha" }
[[sliding]]
between = [1, 7]
[[measure]]
name = "tip"
displacement = { at = [50, 0, 0] }
frame = "world"
)");
  for (const char* key :
       {"specimen.stiffness: ", "hold[1].where: ", "hold[2].where.points: ", "load[1].where: ",
        "move[1].field: ", "sliding[1].between: ", "measure[1].displacement.at: "})
    EXPECT_TRUE(test::has(found, key)) << key << " in\n";
  EXPECT_TRUE(test::has(found, "reaches from x 0 to 12"));
}

TEST(ReadAnatomyContract, GreyValuesThatAreNoNumbersAreNamed) {
  const Anatomy files;
  EXPECT_TRUE(files.say("partial_volume = { none = 0, full = 1, image = \"gap.mha\" }\n", "",
                        "specimen.partial_volume: a number in every voxel of the body, none in 144 of them"));
  EXPECT_TRUE(test::has(files.faults("[specimen]\nshape = \"image\"\nimage = \"gap.mha\"\nmaterial = " +
                                     test::soft + "\npartial_volume = { none = 0, full = 1 }\n" + hold_below),
                        "none in 144 of them"));
}

TEST(ReadAnatomyContract, AnOpenSurfaceIsNoBody) {
  const Anatomy files;
  files.folder().write("flat.stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 5 0 "
                                   "0\nvertex 0 5 0\nendloop\nendfacet\nendsolid\n");
  const std::string found = files.faults("units = \"mm\"\n[specimen]\nshape = \"surface\"\nsurface = "
                                         "\"flat.stl\"\nspacing = 1\nmaterial = \"fat/subcutaneous\"\n");
  EXPECT_TRUE(test::has(found, "specimen.surface: a closed surface"));
  EXPECT_EQ(std::ranges::count(found, '\n'), 1) << found; // and its material is no fault
}

TEST(ReadAnatomyAnalytic, AMapGivesEveryCellItsStiffness) {
  const Anatomy files;
  const Scene scene = files.read(
      std::string(two_blocks) +
      "stiffness = { image = \"ramp.mha\", unit = \"kPa\", labels = 1 }\n[[hold]]\nwhere = \"z-\"\n");
  EXPECT_FLOAT_EQ(scene.specimen.stiffness_ratio[4], 1.2F);
  EXPECT_FLOAT_EQ(scene.specimen.stiffness_ratio.back(), 1);
  EXPECT_NEAR(scene.object_stiffness(4)(3, 3), 1.2 * 100e3 / 2.6, 1e-2);
}

TEST(ReadAnatomyAnalytic, LawsAreThoseOfTheirAuthors) {
  const DensityLaw* law = find_density_law("morgan_2003_femoral_neck");
  ASSERT_NE(law, nullptr);
  EXPECT_NEAR(law->youngs_modulus(1000), 6850e6, 1);
  EXPECT_NEAR(law->youngs_modulus(500), 6850e6 * std::pow(0.5, 1.49), 1);
  for (const DensityLaw& each : density_laws())
    EXPECT_FALSE(each.source.empty()) << each.name;
}

TEST(ReadAnatomyAnalytic, AMoveTakesWhatAnImageHas) {
  const Anatomy files;
  const Scene scene =
      files.read(std::string(two_blocks) +
                 "[[hold]]\nwhere = \"z-\"\n[[move]]\nwhere = \"z+\"\nfield = { image = \"u.mha\" }\n");
  for (const Prescribed& p : scene.prescribed)
    if (!p.held) {
      const Index3 at = scene.specimen.grid.node_at(p.node);
      const double voxel = std::clamp(at[std::size_t(p.component)] - 0.5, 0.0, 11.0);
      ASSERT_NEAR(p.value, 1e-5 * voxel, 1e-9);
    }
  EXPECT_TRUE(files.say("", "[[move]]\nwhere = \"z+\"\nfield = { image = \"gap.mha\" }\n", "values a voxel"));
}

TEST(ReadAnatomyAnalytic, ADriveFollowsItsCourse) {
  const Anatomy files;
  const Scene scene = files.read(std::string(two_blocks) + R"([[hold]]
where = "z-"
[[drive]]
label = 2
turn = { angle = "90 deg", axis = [0, 0, 1], about = [0, 0, 0] }
course = [[0, 0], [0.5, 1], [1, 0]]
)");
  ASSERT_EQ(scene.drives.size(), 1U);
  const std::int64_t node = scene.specimen.grid.node({12, 0, 12});
  const auto value_at = [&](double time, int component) {
    const Scene step = scaled(scene, time);
    for (const Prescribed& p : step.prescribed)
      if (p.node == node && p.component == component)
        return p.value;
    return std::numeric_limits<double>::quiet_NaN();
  };
  EXPECT_NEAR(value_at(0.5, 0), -12e-3, 1e-12);
  EXPECT_NEAR(value_at(0.5, 1), 12e-3, 1e-12);
  EXPECT_NEAR(value_at(0.25, 1), 12e-3 * std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(value_at(1, 1), 0, 1e-12);
  // A step that is taken in steps again: half of the first half is a quarter.
  const Scene quarter = scaled(scene, 0.25), again = scaled(scaled(scene, 0.5), 0.5);
  for (std::size_t i = 0; i < quarter.prescribed.size(); ++i)
    ASSERT_NEAR(again.prescribed[i].value, quarter.prescribed[i].value, 1e-12);
}

// Truth: rows of a table of poses are what a tracker would write of a turn about an axis with a shift, here
// by hand: x -> about + R (x - about) + d.
TEST(ReadAnatomyAnalytic, ADriveFollowsRecordedPoses) {
  const Anatomy files;
  files.folder().write("poses.csv", "time [s],dx [mm],dy [mm],dz [mm],angle [deg],axis_x,axis_y,axis_z\n"
                                    "2,0,0,0,0,0,0,1\n"
                                    "3,0,0,1,90,0,0,1\n"
                                    "6,4,0,2,90,0,0,1\n");
  const std::string text = std::string(two_blocks) + "[[hold]]\nwhere = \"z-\"\n[[drive]]\nlabel = 2\n"
                                                     "poses = \"poses.csv\"\nabout = [0, 0, 0]\n";
  const Scene scene = files.read(text);
  ASSERT_EQ(scene.drives.size(), 1U);
  const std::int64_t node = scene.specimen.grid.node({12, 0, 12}); // at (12, 0, 12) mm
  const auto expect_at = [&](double time, const Vec3& expected) {
    const Scene step = scaled(scene, time);
    for (const Prescribed& p : step.prescribed)
      if (p.node == node && !p.held) {
        EXPECT_NEAR(p.value, 1e-3 * expected[std::size_t(p.component)], 1e-9)
            << "time " << time << ", axis " << p.component;
      }
  };
  expect_at(0.25, {-12, 12, 1}); // the second row, a quarter of the way
  expect_at(0.125,
            {12 * (std::sqrt(0.5) - 1), 12 * std::sqrt(0.5), 0.5}); // half of the turn, half of the shift
  expect_at(0.625, {-10, 12, 1.5});
  expect_at(1, {-8, 12, 2});
  files.folder().write("poses.csv", "time [s],dx [mm],dy [mm],dz [mm],angle [deg],axis_x,axis_y,axis_z\n"
                                    "0,1,0,0,0,0,0,1\n0,0,0,nan,90,0,0,0\n");
  const std::string found = files.faults(text);
  EXPECT_TRUE(test::has(found, "drive[1].poses"));
  files.folder().write("poses.csv", "time [s],dx,dy\n0,0,0\n1,1,0\n");
  EXPECT_TRUE(test::has(files.faults("units = \"mm\"\n" + text), "a unit, such as dx [mm]"));
}

// Truth: by hand. The border has 13 x 13 nodes, a box to x = 7 has 8 x 13 of them, one to x = 4 has 5 x 13.
TEST(ReadAnatomyContract, AConditionThatKeepsABorderTogetherIsNamed) {
  const Anatomy files;
  const auto warnings = [&](const std::string& to) {
    return plausibility(files.read(two_blocks + hold_below +
                                   "[[sliding]]\nbetween = [1, 2]\nfriction = 0.3\n[[move]]\nwhere = { box = "
                                   "[[\"0 mm\", \"0 mm\", \"6 mm\"], [\"" +
                                   to + "\", \"12 mm\", \"6 mm\"]] }\nby = [\"0.1 mm\", 0, 0]\n"))
        .warnings;
  };
  const std::string words = "move[1] has 104 of 169 nodes of the border of labels 1 and 2";
  EXPECT_TRUE(
      std::ranges::any_of(warnings("7 mm"), [&](const auto& text) { return test::has(text, words); }));
  for (const std::string& text : warnings("4 mm"))
    EXPECT_FALSE(test::has(text, "of the border")) << text;
}

// Truth: by hand. A border that rubs holds what would be free without.
TEST(ReadAnatomyContract, FrictionOfABorderIsANumberAndHoldsWhatItPresses) {
  const Anatomy files;
  const std::string blocks = std::string(two_blocks) + "[[hold]]\nwhere = \"z-\"\n";
  const Scene scene = files.read(blocks + "[[sliding]]\nbetween = [2, 1]\nfriction = 0.3\n");
  ASSERT_EQ(scene.sliding.size(), 1U);
  EXPECT_EQ(scene.sliding[0].friction, 0.3);
  EXPECT_EQ(
      files.read(blocks + "[[sliding]]\nbetween = [1, 2]\nfriction = 0.3\n[[sliding]]\nbetween = \"all\"\n")
          .sliding,
      (std::vector<SlidingBorder>{{1, 2, 0.3}}));
  const std::string found = files.faults(blocks + "[[sliding]]\nbetween = [1, 2]\nfriction = 0.3\n"
                                                  "[[sliding]]\nbetween = [2, 1]\nfriction = 0.2\n"
                                                  "[[sliding]]\nbetween = \"all\"\nfriction = -1\n"
                                                  "[[sliding]]\nbetween = \"all\"\nfriction = \"much\"\n");
  for (const char* fault :
       {"sliding[2].friction: 0.3, as an earlier table has it, 0.2",
        "sliding[3].friction: Coulomb's coefficient", "sliding[4].friction: Coulomb's coefficient"})
    EXPECT_TRUE(test::has(found, fault)) << fault << " in\n";
  for (const NodeTie& tie : split_borders(scene).scene.tied.ties) {
    EXPECT_EQ(tie.friction, 0.3);
    EXPECT_EQ(tie.label, (std::array<std::int32_t, 2>{1, 2}));
    EXPECT_GT(tie.spring, 0);
  }
}

TEST(SplitBordersAnalytic, NodesOfABorderAreThereTwice) {
  const Anatomy files;
  Scene scene = files.read(std::string(two_blocks) + "[[hold]]\nwhere = \"z-\"\n");
  scene.sliding = {{1, 2}};
  const SplitScene split = split_borders(scene);
  EXPECT_EQ(split.n_copies, 2);
  EXPECT_EQ(split.scene.specimen.n_matter_cells(), scene.specimen.n_matter_cells());
  EXPECT_EQ(split.scene.specimen.n_matter_nodes(), scene.specimen.n_matter_nodes() + 169);
  ASSERT_EQ(split.scene.tied.ties.size(), 169U);
  for (const NodeTie& tie : split.scene.tied.ties)
    EXPECT_EQ(tie.normal, (Vec3{0, 0, 1}));
}

} // namespace
} // namespace maille
