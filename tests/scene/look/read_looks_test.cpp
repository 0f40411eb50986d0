// Looks of scene files: what they mean, and every fault in them.

#include "maille/scene/look.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <limits>

namespace maille {
namespace {

/// A scene of an image of 4 x 4 x 4 voxels with the values 0 to 63.
class LooksContract : public testing::Test {
protected:
  LooksContract() {
    std::ofstream image(folder_.path() / "grey.mha", std::ios::binary);
    image << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
             "ElementSpacing = 1 1 2\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    for (int v = 0; v < 64; ++v)
      image.put(static_cast<char>(v));
  }
  std::filesystem::path scene(const std::string& look) {
    const auto file = folder_.path() / "scene.toml";
    std::ofstream(file)
        << "[specimen]\nshape = \"image\"\nimage = \"grey.mha\"\nthreshold = 30\nmaterial = { "
           "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
        << look << "\n[[hold]]\nwhere = \"z-\"\n";
    return file;
  }
  std::vector<Fault> faults_of(const std::string& look) {
    try {
      read_looks(scene(look));
    } catch (const InputError& error) {
      return error.faults();
    }
    return {};
  }

  test::TemporaryFolder folder_;
};

TEST_F(LooksContract, NoLookNoByte) {
  const auto looks = read_looks(scene(""));
  ASSERT_EQ(looks.size(), 1u);
  EXPECT_FALSE(looks[0]);
}

TEST_F(LooksContract, GreyValuesAreCutDownToWhatIsSeen) {
  const auto looks = read_looks(scene("look = { colours = [[0, \"#000000\"], [63, \"#ffffff\"]], opacity = "
                                      "[[40, 0], [48, 0.5]] }"));
  const Seen& seen = *looks.at(0);
  EXPECT_EQ(seen.grey.info.size, (Index3{4, 4, 3})); // values from 40 on, and a voxel more
  EXPECT_EQ(seen.grey.values.front(), 16);
  EXPECT_EQ(seen.bytes(), 48 * 4);
  EXPECT_NEAR(seen.look.opacity_at(44), 0.25, 1e-12);
  EXPECT_NEAR(seen.look.colour_at(31.5)[1], 0.5, 1e-6);
  EXPECT_EQ(seen.largest, 63);
}

TEST_F(LooksContract, AWindowStretchesAPreset) {
  const auto looks = read_looks(scene("look = { preset = \"grey\", window = [10, 50] }"));
  EXPECT_NEAR(looks.at(0)->look.colour_at(30)[0], 0.5, 1e-6);
  EXPECT_TRUE(looks.at(0)->look.shading.on);
}

TEST_F(LooksContract, ColourMapsOfParaView) {
  std::ofstream(folder_.path() / "map.json")
      << R"([{"Name": "mine", "RGBPoints": [0, 0, 0, 1, 2, 1, 0, 0], "Points": [0, 0, 0.5, 0, 2, 1, 0.5, 0]}])";
  const auto looks = read_looks(scene("look = { colours = \"map.json\", window = [20, 60] }"));
  EXPECT_NEAR(looks.at(0)->look.colour_at(40)[0], 0.5, 1e-6);
  EXPECT_NEAR(looks.at(0)->look.opacity_at(40), 0.5, 1e-12);
  // ParaView's own go from 0 to 1: on the values of an image they say nothing without a window.
  std::ofstream(folder_.path() / "own.json") << R"([{"RGBPoints": [0, 0, 0, 1, 1, 1, 0, 0]}])";
  const auto faults = faults_of("look = { colours = \"own.json\" }");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, "specimen.look.window");
  EXPECT_EQ(faults_of("look = { colours = \"own.json\", window = [0, 63] }").size(), 0u);
}

TEST_F(LooksContract, AnImageIsPutOnTheMiddleOfTheBodysOwn) {
  std::ofstream image(folder_.path() / "fine.mha", std::ios::binary);
  image << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
           "Offset = 100 200 -300\nElementSpacing = 0.5 0.5 2\nDimSize = 8 8 2\nElementType = MET_UCHAR\n"
           "ElementDataFile = LOCAL\n";
  for (int v = 0; v < 128; ++v)
    image.put(static_cast<char>(v));
  image.close();
  const std::string look = "look = { image = \"fine.mha\", preset = \"grey\", window = [0, 99], "
                           "opacity = [[0, 1], [99, 1]]";
  const Seen by_header = *read_looks(scene(look + " }")).at(0);
  EXPECT_NEAR(by_header.grey.info.origin[1], 0.2, 1e-12);
  const Seen in_the_middle = *read_looks(scene(look + ", place = \"middle\" }")).at(0);
  // Of 4 voxels 1 mm apart from 0 on the middle is at 1.5 mm; 8 voxels 0.5 mm apart reach 1.75 mm from it.
  EXPECT_NEAR(in_the_middle.grey.info.origin[0], -0.25e-3, 1e-12);
  EXPECT_NEAR(in_the_middle.grey.info.origin[2], 2e-3, 1e-12); // 4 voxels 2 mm apart: 3 mm; 2 reach 1 mm
  EXPECT_EQ(faults_of(look + ", place = \"corner\" }").size(), 1u);
  EXPECT_EQ(faults_of("look = { preset = \"grey\", window = [0, 9], place = \"middle\" }").size(), 1u);
}

TEST_F(LooksContract, TheQuestionIsTheSameWithAndWithoutALook) {
  const Scene with = read_scene(scene("look = { preset = \"grey\", window = [10, 50] }"));
  EXPECT_EQ(with.specimen.n_matter_cells(), read_scene(scene("")).specimen.n_matter_cells());
}

TEST_F(LooksContract, FaultsAreToldWithTheirKeys) {
  const auto only_fault = [&](const std::string& look) {
    const auto faults = faults_of(look);
    EXPECT_EQ(faults.size(), 1u) << look;
    return faults.empty() ? Fault{} : faults.front();
  };
  EXPECT_EQ(only_fault("look = { colours = [[5, \"#ffffff\"], [1, \"#000000\"]] }").key,
            "specimen.look.colours");
  EXPECT_EQ(only_fault("look = { colours = [[nan, \"#ffffff\"]] }").key, "specimen.look.colours");
  EXPECT_EQ(only_fault("look = { colours = [[5, \"white\"]] }").key, "specimen.look.colours");
  EXPECT_EQ(only_fault("look = { preset = \"grey\", window = [0, 9], opacity = [[1, 0], [0, 1]] }").key,
            "specimen.look.opacity");
  EXPECT_EQ(only_fault("look = { preset = \"grey\" }").key, "specimen.look.window");
  EXPECT_EQ(only_fault("look = { preset = \"grey\", window = [5, 5] }").key, "specimen.look.window");
  EXPECT_EQ(only_fault("look = { preset = \"gray\", window = [0, 9] }").key, "specimen.look.preset");
  EXPECT_EQ(only_fault("look = { preset = \"grey\", window = [0, 9], gloss = 2 }").key,
            "specimen.look.gloss");
  EXPECT_EQ(only_fault("look = { preset = \"grey\", window = [0, 9], shininess = -2 }").key,
            "specimen.look.shininess");
  // Values that the image does not have.
  const Fault absent = only_fault("look = { preset = \"ct_bone\" }");
  EXPECT_NE(absent.expected.find("0 to 63"), std::string::npos) << absent.expected;
  EXPECT_EQ(
      only_fault("look = { preset = \"grey\", window = [0, 9], mode = \"isosurface\", isovalue = 99 }").key,
      "specimen.look.isovalue");
  EXPECT_EQ(only_fault("look = { image = \"absent.mha\", preset = \"grey\", window = [0, 9] }").key,
            "specimen.look.image");
  EXPECT_EQ(only_fault("look = { picture = \"absent.png\" }").key, "specimen.look.picture");
  EXPECT_THROW(read_scene(scene("look = { colour = \"red\" }")), InputError);
}

TEST_F(LooksContract, AnImageWithVoxelsThatAreNoNumbersIsAFault) {
  std::ofstream image(folder_.path() / "odd.mha", std::ios::binary);
  image << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
           "ElementSpacing = 1 1 2\nDimSize = 4 4 4\nElementType = MET_FLOAT\nElementDataFile = LOCAL\n";
  for (int v = 0; v < 64; ++v) {
    const float value = v == 6 || v == 40 ? std::numeric_limits<float>::quiet_NaN() : static_cast<float>(v);
    image.write(reinterpret_cast<const char*>(&value), sizeof value);
  }
  image.close();
  const auto faults = faults_of("look = { image = \"odd.mha\", preset = \"grey\", window = [0, 63] }");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, "specimen.look.image");
  EXPECT_NE(faults[0].found.find("2 voxels"), std::string::npos) << faults[0].found;
  EXPECT_NE(faults[0].found.find("[2, 1, 0]"), std::string::npos) << faults[0].found;
}

} // namespace
} // namespace maille
