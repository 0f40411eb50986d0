// Materials that stand in files of their own.
#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"
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
  EXPECT_EQ(scene.limits.from, LimitSource::material);
  EXPECT_EQ(scene.materials[0].limits, same.materials[0].limits);
  EXPECT_EQ(scene.materials[0].elasticity.youngs_modulus, same.materials[0].elasticity.youngs_modulus);
  EXPECT_EQ(scene.materials[0].relaxed_weights, (std::array<double, 3>{0.5, 1, 2}));
  EXPECT_EQ(same.materials[0].relaxed_weights, scene.materials[0].relaxed_weights);
}

TEST(MaterialFileContract, ItsFaultsAreFaultsOfTheScene) {
  const test::TemporaryFolder folder;
  folder.write("bad.toml",
               "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\nrelaxed_weights = 0\ncolour = 3\n");
  folder.write("worse.toml", "youngs_modulus = = 3\n");
  const auto faults_of = [&](const std::string& material) {
    try {
      parse_scene(scene_of(material), folder / "scene.toml");
    } catch (const InputError& error) {
      return error.faults();
    }
    return std::vector<Fault>{};
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
