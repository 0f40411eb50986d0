// Where names in a scene may lead, and where not.
#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/mistake.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace maille {
namespace {

namespace fs = std::filesystem;

const std::string soft = "youngs_modulus = \"10 kPa\"\npoisson_ratio = 0.3\n";

std::string scene_of(const std::string& material) {
  return "[specimen]\nshape = \"box\"\ncells = [4]\nspacing = \"1 mm\"\nmaterial = \"" + material +
         "\"\n[[hold]]\nwhere = \"x-\"\n";
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
    const auto faults = faults_of(scene_of(name), scene);
    ASSERT_EQ(faults.size(), 1u) << name;
    EXPECT_EQ(faults[0].line, 5);
    EXPECT_EQ(faults[0].key, "specimen.material");
    EXPECT_NE(faults[0].expected.find("with --sandbox a scene reads nothing else"), std::string::npos)
        << "says why: " << faults[0].expected;
    EXPECT_NE(faults[0].found.find(name), std::string::npos);
  }
}

TEST_F(NamedFilesContract, ImagesAndTensorsTooStayInTheFolder) {
  const std::string end = "\"\nmaterial = \"beside.toml\"\n[[hold]]\nwhere = \"x-\"\n";
  for (const std::string name : {"../image.nii", "/image.nii", "$MAILLE_TEST_FOLDER/../image.nii"}) {
    const auto faults = faults_of("[specimen]\nshape = \"image\"\nimage = \"" + name + end, scene);
    ASSERT_EQ(faults.size(), 1u) << name;
    EXPECT_EQ(faults[0].key, "specimen.image");
    EXPECT_EQ(faults[0].expected.substr(0, 30), "a file in the folder of what n");
  }
}

// Outside of the folder on purpose: the user has set the variable. Not outside of that.
TEST_F(NamedFilesContract, VariablesLeadWhereTheirUserSaid) {
  EXPECT_TRUE(faults_of(scene_of("$MAILLE_TEST_FOLDER/outside.toml"), scene).empty());
  EXPECT_TRUE(faults_of(scene_of("$MAILLE_TEST_FOLDER/scenes/beside.toml"), scene).empty());
  for (const std::string name : {"$MAILLE_TEST_FOLDER/scenes/../outside.toml",
                                 "$MAILLE_TEST_FOLDER//outside.toml", "$MAILLE_NONE/a.toml", "$/a.toml"}) {
    const auto faults = faults_of(scene_of(name), scene);
    ASSERT_EQ(faults.size(), 1u) << name;
    EXPECT_NE(faults[0].found.find(name), std::string::npos);
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
  const auto faults = faults_of(scene_of("zero.toml"), scene);
  ASSERT_EQ(faults.size(), 1u) << "a device has no end";
  EXPECT_NE(faults[0].found.find("something else"), std::string::npos);
}

} // namespace
} // namespace maille
