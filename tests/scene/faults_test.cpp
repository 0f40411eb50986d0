#include "maille/scene/read_scene.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

using test::Mistake;
using test::says_only;

std::vector<Fault> faults_of(const std::string& text) {
  return test::faults_found_by([&] { parse_scene(text, "scene.toml"); });
}

const std::string good = test::pulled_box_text("[4, 2, 2]", "[\"1 mm\", 0, 0]");

/// Another move after the good one. @param x  where it moves [m]
std::string second_move(const std::string& x, const std::string& by) {
  return "[[move]]\nwhere = { box = [[" + x + ", 0, 0], [" + x + ", 0, 0]] }\nby = " + by + "\n";
}

const Mistake mistakes[] = {
    {"wrong_unit", "\"1 mm\"", "\"1 kPa\"", 4, "specimen.spacing", "length"},
    {"negative_spacing", "\"1 mm\"", "\"-1 mm\"", 4, "specimen.spacing", "> 0"},
    {"no_spacing", "spacing = \"1 mm\"\n", "", 1, "specimen.spacing", "length"},
    {"zero_cells", "[4, 2, 2]", "[4, 0, 2]", 3, "specimen.cells", "> 0"},
    {"too_many_axes", "[4, 2, 2]", "[4, 2, 2, 2]", 3, "specimen.cells", "three"},
    {"grid_beyond_memory", "[4, 2, 2]", "[90000, 90000, 90000]", 3, "specimen.cells", "MiB"},
    {"unknown_shape", "\"box\"", "\"ball\"", 2, "specimen.shape", "ellipsoid"},
    {"unknown_key", "cells =", "colour = 3\ncells =", 3, "specimen.colour", "cells"},
    {"unknown_section", "[[hold]]", "[solver]\nfast = true\n[[hold]]", 6, "solver", "limits"},
    {"unknown_material", "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }", "\"muscle/soleuss\"", 5,
     "specimen.material", "muscle/soleus"},
    {"negative_modulus", "10 kPa", "-10 kPa", 5, "specimen.material.youngs_modulus", "> 0"},
    {"not_positive_definite", "0.3 }", "0.6 }", 5, "specimen.material.poisson_ratio", "0.5"},
    {"nearly_incompressible", "0.3 }", "0.4999999999 }", 5, "specimen.material.poisson_ratio", "1e-09"},
    {"unknown_face", "where = \"x-\"", "where = \"w-\"", 7, "hold[1].where", "x-"},
    {"no_node_in_it", "where = \"x+\"",
     "where = { box = [[\"1 m\", \"1 m\", \"1 m\"], [\"2 m\", \"2 m\", \"2 m\"]] }", 9, "move[1].where",
     "node"},
    {"turn_of_any_size", "by = [\"1 mm\", 0, 0]", "turn = { angle = \"1e300 deg\", axis = [1, 0, 0] }", 10,
     "move[1].turn.angle", "a hundred full turns"},
    {"held_and_moved", "where = \"x+\"", "where = \"x-\"", 8, "move[1]", "held or moved, not both"},
    {"by_beyond_the_dimension", "[\"1 mm\", 0, 0]", "[\"1 mm\", 0]", 10, "move[1].by", "3"},
    {"turn_without_angle", "by = [\"1 mm\", 0, 0]", "turn = { axis = [0, 0, 1] }", 10, "move[1].turn.angle",
     "an angle"},
    {"turn_by_a_length", "by = [\"1 mm\", 0, 0]", "turn = { angle = \"1 mm\", axis = [0, 0, 1] }", 10,
     "move[1].turn.angle", "angle"},
    {"turn_about_nothing", "by = [\"1 mm\", 0, 0]", "turn = { angle = \"9 deg\", axis = [0, 0, 0] }", 10,
     "move[1].turn.axis", "not zero"},
    {"turn_without_axis", "by = [\"1 mm\", 0, 0]", "turn = { angle = \"9 deg\" }", 10, "move[1].turn.axis",
     "[0, 0, 1]"},
    {"turn_of_a_hold", "where = \"x-\"", "where = \"x-\"\nturn = { angle = \"1 rad\", axis = [0, 0, 1] }", 8,
     "hold[1].turn", "axes"},
    {"bad_axes", "where = \"x-\"", "where = \"x-\"\naxes = \"xw\"", 8, "hold[1].axes", "xyz"},
    {"plane_in_3d", "shape =", "plane = \"stress\"\nshape =", 2, "specimen.plane", "two-dimensional"},
    {"limits_without_values", "[[hold]]", "[limits]\nfrom = \"material\"\n[[hold]]", 7, "limits.from",
     "taut"},
    {"not_toml", "[4, 2, 2]", "[4, 2, 2", 4, "", "TOML"},
    {"load_of_nothing", "[[move]]", "[[load]]\nwhere = \"x+\"\n[[move]]", 8, "load[1]", "traction"},
    {"nothing_in_place", "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n", "", 0,
     "hold", ""},
};

TEST(MistakeContract, IsReportedWithItsLineAndKey) {
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.name);
    const std::vector<Fault> faults = faults_of(with_mistake(good, mistake));
    test::expect_only(mistake, faults);
    EXPECT_TRUE(faults.empty() || faults[0].file == "scene.toml");
  }
}

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
    EXPECT_TRUE(test::has(all, key));
}

TEST(SceneFaultsContract, MovesThatOverlapHaveToAgree) {
  EXPECT_TRUE(faults_of(good + second_move("\"4 mm\"", "[\"1 mm\", 0, 0]")).empty());
  EXPECT_TRUE(says_only(faults_of(good + second_move("\"4 mm\"", "[\"2 mm\", 0, 0]")),
                        {.line = 11, .found = "(0.004, 0, 0)"}));
  // Contradictions show beside an empty handle.
  EXPECT_EQ(
      test::keys_of(faults_of(good + second_move("\"9 m\"", "0") + test::move_text("[\"2 mm\", 0, 0]"))),
      (std::vector<std::string>{"move[2].where", "move[3]"}));
}

TEST(SceneFaultsContract, MissingFilesAreNamed) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(read_scene(folder.path() / "none.toml"), InputError);
  EXPECT_THROW(read_scene(folder.path()), InputError); // a folder is no scene
  const auto file = folder.write(
      "scene.toml",
      "[specimen]\nshape = \"image\"\nimage = \"none.nii.gz\"\nmaterial = \"fat/subcutaneous\"\n");
  EXPECT_TRUE(says_only(test::faults_found_by([&] { read_scene(file); }),
                        {.line = 3, .key = "specimen.image", .found = "none.nii.gz"}));
}

// Where names in a scene may lead, and where not.

namespace fs = std::filesystem;

const std::string soft = "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n";

/// A scene whose material stands in its own file.
std::string scene_of(const std::string& material) {
  return test::box_text("[4]", "\"" + material + "\"") + test::hold_text();
}

std::vector<Fault> faults_of(const std::string& text, const fs::path& file) {
  return test::faults_found_by([&] { parse_scene(text, file); });
}

class NamedFilesContract : public testing::Test {
protected:
  NamedFilesContract() {
    set_file_scope(FileScope::sandbox);
    fs::create_directories(folder / "scenes/below");
    folder.write("outside.toml", soft);
    folder.write("scenes/beside.toml", soft);
    folder.write("scenes/below/soft.toml", soft);
    setenv("MAILLE_TEST_FOLDER", folder.path().c_str(), 1);
  }
  ~NamedFilesContract() override {
    set_file_scope(FileScope::anywhere);
    unsetenv("MAILLE_TEST_FOLDER");
  }
  const test::TemporaryFolder folder;
  const fs::path scene = folder / "scenes/scene.toml";
};

TEST_F(NamedFilesContract, FilesBesideAndBelowAreRead) {
  for (const std::string name : {"beside.toml", "./beside.toml", "below/soft.toml", "below//soft.toml"})
    EXPECT_TRUE(faults_of(scene_of(name), scene).empty()) << name;
}

TEST_F(NamedFilesContract, WhatClimbsOutIsRefusedBeforeItIsLookedAt) {
  const std::vector<std::string> names{"../outside.toml",      "below/../../outside.toml",
                                       "below/../beside.toml", (folder / "outside.toml").string(),
                                       "/dev/zero/x.toml",     "./../none.toml"};
  for (const std::string& name : names) {
    EXPECT_TRUE(
        says_only(faults_of(scene_of(name), scene),
                  {.line = 5, .key = "specimen.material", .expected = "with --sandbox", .found = name}));
  }
}

TEST_F(NamedFilesContract, ImagesAndTensorsTooStayInTheFolder) {
  const std::string end = "\"\nmaterial = \"beside.toml\"\n[[hold]]\nwhere = \"x-\"\n";
  for (const std::string name : {"../image.nii", "/image.nii", "$MAILLE_TEST_FOLDER/../image.nii"})
    EXPECT_TRUE(says_only(faults_of("[specimen]\nshape = \"image\"\nimage = \"" + name + end, scene),
                          {.key = "specimen.image", .expected = "--sandbox"}));
}

// Outside of the folder on purpose: the user has set the variable. Not outside of that.
TEST_F(NamedFilesContract, VariablesLeadWhereTheirUserSaid) {
  EXPECT_TRUE(faults_of(scene_of("$MAILLE_TEST_FOLDER/outside.toml"), scene).empty());
  EXPECT_TRUE(faults_of(scene_of("$MAILLE_TEST_FOLDER/scenes/beside.toml"), scene).empty());
  for (const std::string name : {"$MAILLE_TEST_FOLDER/scenes/../outside.toml",
                                 "$MAILLE_TEST_FOLDER//outside.toml", "$MAILLE_NONE/a.toml", "$/a.toml"}) {
    EXPECT_TRUE(says_only(faults_of(scene_of(name), scene), {.found = name}));
  }
  EXPECT_EQ(named_file("$MAILLE_TEST_FOLDER", "x").file, folder.path() / "");
}

// A user's own files lie anywhere.
TEST_F(NamedFilesContract, OutsideOfASandboxNamesLeadAnywhere) {
  set_file_scope(FileScope::anywhere);
  const char* const home = std::getenv("HOME");
  const std::string before = home ? home : "";
  setenv("HOME", folder.path().c_str(), 1);
  for (const std::string& name : std::vector<std::string>{
           "../outside.toml", "below/../../outside.toml", (folder / "outside.toml").string(),
           "~/outside.toml", "$MAILLE_TEST_FOLDER/scenes/../outside.toml"})
    EXPECT_TRUE(faults_of(scene_of(name), scene).empty()) << name;
  EXPECT_EQ(faults_of(scene_of("~/none.toml"), scene).size(), 1u) << "there is none";
  setenv("HOME", before.c_str(), 1);
}

// The owner of the folder put the link there.
TEST_F(NamedFilesContract, SymbolicLinksAreFollowed) {
  fs::create_symlink("../outside.toml", folder / "scenes/link.toml");
  fs::create_directory_symlink("..", folder / "scenes/up");
  EXPECT_TRUE(faults_of(scene_of("link.toml"), scene).empty());
  EXPECT_TRUE(faults_of(scene_of("up/outside.toml"), scene).empty());
  fs::create_symlink("/dev/zero", folder / "scenes/zero.toml");
  EXPECT_TRUE(says_only(faults_of(scene_of("zero.toml"), scene), {.found = "something else"}))
      << "a device has no end";
}

// Materials that stand in files of their own.

TEST(MaterialFileContract, HoldsWhatATableInTheSceneHolds) {
  const test::TemporaryFolder folder;
  folder.write("soft.toml",
               "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\nstretch = 1.2\ncompress = 0.9\nshear = "
               "0.1\nrelaxed_weights = [0.5, 1, 2]\n");
  const Scene scene = parse_scene(scene_of("soft.toml"), folder / "scene.toml");
  const Scene same =
      parse_scene(test::box_text("[4]", "{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, stretch = 1.2, "
                                        "compress = 0.9, shear = 0.1, relaxed_weights = [0.5, 1, 2] }") +
                  test::hold_text());
  EXPECT_EQ(scene.materials[0].name, "soft");
  EXPECT_EQ(scene.limit_source(), LimitSource::material);
  EXPECT_EQ(scene.materials[0].limits, same.materials[0].limits);
  EXPECT_EQ(scene.materials[0].elasticity.youngs_modulus, same.materials[0].elasticity.youngs_modulus);
  EXPECT_EQ(scene.materials[0].relaxed_weights, (std::array<double, 3>{0.5, 1, 2}));
  EXPECT_EQ(same.materials[0].relaxed_weights, scene.materials[0].relaxed_weights);
}

TEST(MaterialFileContract, OfSeveralOneIsNamedBehindTheFile) {
  const test::TemporaryFolder folder;
  folder.write("two.toml",
               "[soft]\nyoungs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n[soft.damage]\n"
               "stretch = 1.4\n[\"muscle/stiff\"]\nyoungs_modulus = \"20 kPa\"\npoisson_ratio = 0.3\n");
  const Scene scene = parse_scene(
      "[specimen]\nshape = \"muscle\"\ncells = [12, 6, 6]\nspacing = \"1 mm\"\nmaterial = \"two.toml#soft\"\n"
      "tendon = { material = \"two.toml#muscle/stiff\", fraction = 0.2 }\n[[hold]]\nwhere = \"x-\"\n",
      folder / "scene.toml");
  ASSERT_EQ(scene.materials.size(), 2u);
  EXPECT_EQ(scene.materials[0].name, "soft");
  EXPECT_EQ(scene.materials[0].damage->stretch[0], 1.4);
  EXPECT_EQ(scene.materials[1].name, "muscle/stiff");
  EXPECT_EQ(scene.materials[1].elasticity.youngs_modulus[0], 20e3);
  folder.write("one.toml", "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n");
  for (const auto& [name, says] : {std::pair{"two.toml", "two.toml#soft"},
                                   {"two.toml#hard", "two.toml#soft"},
                                   {"one.toml#soft", "several materials"},
                                   {"none.toml#soft", "none.toml"}}) {
    const auto faults = faults_of(scene_of(name), folder / "scene.toml");
    ASSERT_EQ(faults.size(), 1u) << name;
    EXPECT_TRUE(test::has(to_string(faults[0]), says));
  }
}

TEST(MaterialFileContract, ItsFaultsAreFaultsOfTheScene) {
  const test::TemporaryFolder folder;
  folder.write("bad.toml",
               "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\nrelaxed_weights = 0\ncolour = 3\n");
  folder.write("worse.toml", "youngs_modulus = = 3\n");
  const auto bad = faults_of(scene_of("bad.toml"), folder / "scene.toml");
  ASSERT_EQ(bad.size(), 2u);
  for (const Fault& fault : bad)
    EXPECT_TRUE(test::says(fault, {.line = 5, .key = "specimen.material"}));
  EXPECT_TRUE(test::has(to_string(bad[0]), "bad.toml:3: relaxed_weights"));
  for (const char* name : {"worse.toml", "none.toml", "$MAILLE_NO_SUCH_FOLDER/soft.toml"})
    EXPECT_EQ(faults_of(scene_of(name), folder / "scene.toml").size(), 1u) << name;
}

} // namespace
} // namespace maille
