// Materials that stand in files of their own.
#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/mistake.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

std::string scene_of(const std::string& material) {
  return "[specimen]\nshape = \"box\"\ncells = [4]\nspacing = \"1 mm\"\nmaterial = " + material +
         "\n[[hold]]\nwhere = \"x-\"\n";
}

TEST(MaterialFileContract, HoldsWhatATableInTheSceneHolds) {
  const test::TemporaryFolder folder;
  folder.write("soft.toml",
               "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\nstretch = 1.2\ncompress = 0.9\nshear = "
               "0.1\nrelaxed_weights = [0.5, 1, 2]\n");
  const Scene scene = parse_scene(scene_of("\"soft.toml\""), folder / "scene.toml");
  const Scene same =
      parse_scene(scene_of("{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, stretch = 1.2, "
                           "compress = 0.9, shear = 0.1, relaxed_weights = [0.5, 1, 2] }"));
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
                                   {"none.toml#soft", "none.toml"}})
    try {
      parse_scene(scene_of("\"" + std::string(name) + "\""), folder / "scene.toml");
      ADD_FAILURE() << name;
    } catch (const InputError& error) {
      EXPECT_EQ(error.faults().size(), 1u) << error.what();
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
}

TEST(MaterialFileContract, ItsFaultsAreFaultsOfTheScene) {
  const test::TemporaryFolder folder;
  folder.write("bad.toml",
               "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\nrelaxed_weights = 0\ncolour = 3\n");
  folder.write("worse.toml", "youngs_modulus = = 3\n");
  const auto faults_of = [&](const std::string& material) {
    return test::faults_found_by([&] { parse_scene(scene_of(material), folder / "scene.toml"); });
  };
  const auto bad = faults_of("\"bad.toml\"");
  ASSERT_EQ(bad.size(), 2u);
  for (const Fault& fault : bad) {
    EXPECT_EQ(fault.line, 5);
    EXPECT_EQ(fault.key, "specimen.material");
  }
  EXPECT_NE(to_string(bad[0]).find("bad.toml:3: relaxed_weights"), std::string::npos) << to_string(bad[0]);
  EXPECT_EQ(faults_of("\"worse.toml\"").size(), 1u);
  EXPECT_EQ(faults_of("\"none.toml\"").size(), 1u);
  EXPECT_EQ(faults_of("\"$MAILLE_NO_SUCH_FOLDER/soft.toml\"").size(), 1u);
}

} // namespace
} // namespace maille
