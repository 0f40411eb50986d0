/// `maille render` and `maille play --render volume` as outside scripts see them.

#include "studies/commands/command_scenes.hpp"
#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;
using test::shell;

const std::string world = test::world_text("[24, 16, 16]") +
                          test::object_text("a", "rigid", "[8, 8, 8]", R"(position = ["2 mm", "4 mm", "4 mm"]
)",
                                            "ellipsoid") +
                          test::object_text("b", "deformable", "[6, 8, 8]", "material = " + test::soft + R"(
position = ["14 mm", "4 mm", "4 mm"]
look = { colour = "#aa4433" }
)");

const char* const pushed = R"(frame_time = "100 ms"
[[drive]]
object = "a"
by = ["5 mm", 0, 0]
frames = 2
)";

struct RenderCommandContract : testing::Test {
  test::TemporaryFolder folder;
  std::string scene = folder.write("world.toml", world).string();
  std::string path(const std::string& name) const { return (folder.path() / name).string(); }
  std::string bytes(const std::string& name) const { return test::text_of(path(name)); }
};

TEST_F(RenderCommandContract, SameBytesBySeveralProcesses) {
  const std::string options = " --width 60 --height 60 --json ";
  const auto alone = test::done("render " + scene + " --out " + path("alone.png") + options);
  const auto together =
      shell("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 mpirun --oversubscribe -n 3 " +
            std::string(MAILLE_COMMAND) + " render " + scene + " --out " + path("together.png") + options);
  ASSERT_EQ(together.code, 0) << together.err;
  EXPECT_EQ(bytes("together.png"), bytes("alone.png"));
  EXPECT_EQ(json::parse(together.out).at("rays"), json::parse(alone.out).at("rays"));
  EXPECT_EQ(json::parse(alone.out).at("bytes_sent"), 0);
  EXPECT_GT(json::parse(together.out).at("bytes_sent"), 60 * 60);
}

TEST_F(RenderCommandContract, StereoPairsAndARingOfViews) {
  const std::string size = " --width 40 --height 30 ";
  test::done("render " + scene + size + "--out " + path("pair.png") + " --stereo side_by_side");
  test::done("render " + scene + size + "--out " + path("glasses.png") + " --stereo anaglyph");
  const std::string pair = bytes("pair.png"), glasses = bytes("glasses.png");
  const auto width_of = [](const std::string& png) { return int(static_cast<unsigned char>(png.at(19))); };
  EXPECT_EQ(width_of(pair), 80);
  EXPECT_EQ(width_of(glasses), 40);
  const auto ring = test::done("render " + scene + size + "--out " + path("ring.png") + " --ring 3 --json");
  EXPECT_EQ(json::parse(ring.out).at("files").size(), 3u);
  EXPECT_NE(bytes("ring_000.png"), bytes("ring_001.png"));
  const auto pairs =
      test::done("render " + scene + size + "--out " + path("pairs.png") + " --ring 2 --stereo side_by_side");
  EXPECT_EQ(bytes("pairs_000.png"), pair); // the ring begins with the view itself
}

TEST_F(RenderCommandContract, FramesOfADeformingBodyAndTheirCamera) {
  const std::string play = "play " + scene + " " + folder.write("pushed.toml", pushed).string() +
                           " --render volume --width 40 --height 30 ";
  const auto plain = test::done(play + "--out " + path("plain"));
  const auto stereo = test::done(play + "--stereo anaglyph --direction 0,1,0 --out " + path("stereo"));
  EXPECT_NE(bytes("plain/world_0000.png"), bytes("plain/world_0002.png"));
  EXPECT_NE(bytes("plain/world_0000.png"), bytes("stereo/world_0000.png"));
  const auto wrong = test::refused("play " + scene + " " + path("pushed.toml") + " --zoom 2");
  EXPECT_TRUE(test::has(wrong.err, "--render"));
}

// Truth: 5 % (1 + nu) 2 / 3, by the definition of the equivalent strain.
TEST_F(RenderCommandContract, AFieldHasATitleAndAScale) {
  const auto drawn =
      test::done("render " + folder.write("bar.toml", test::pulled_bar).string() +
                 " --method coupled --field strain --width 120 --height 100 --out " + path("a.png"));
  EXPECT_TRUE(test::has(drawn.out, "equivalent strain: colours from 0 to 4.33")) << drawn.out;
  const int height = static_cast<unsigned char>(bytes("a.png").at(23));
  EXPECT_EQ(height, drawn.err.empty() ? 100 + 7 * 9 : 100) << "else a line says the reason";
}

TEST_F(RenderCommandContract, BadInputIsToldWithExitCode2) {
  const auto err_of = [&](const std::string& options) {
    const auto outcome = test::refused("render " + scene + " --out " + path("x.png") + " " + options);
    return outcome.err;
  };
  EXPECT_TRUE(test::has(err_of("--width 0"), "--width"));
  EXPECT_TRUE(test::has(err_of("--camera 0,0,nan,0,0,0,0,0,1,30"), "finite"));
  EXPECT_TRUE(test::has(err_of("--camera 0,0,1,0,0,0,0,0,1,30"), "line of sight"));
  EXPECT_TRUE(test::has(err_of("--camera 0.006,0.008,0.008,1,0,0,0,0,1,30"), "inside of object 1"));
  EXPECT_TRUE(test::has(err_of("--camera 0.017,0.008,0.008,1,0,0,0,0,1,30"), "inside of object 2"));
  for (const char* option : {"--zoom", "--samples", "--depth-cue"})
    EXPECT_TRUE(test::has(err_of(option + std::string(" nan")), option));
  EXPECT_TRUE(test::has(err_of("--field strain"), "--field"));
  EXPECT_TRUE(test::has(err_of("--clip 0,0,0,0,0,0"), "normal"));
}

// The header of a file of 54 GB whose bytes are not there: what has to be read is refused with its size.
TEST_F(RenderCommandContract, ImagesLargerThanMemoryAreRefusedWithTheNumber) {
  const std::string head =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      "DimSize = 3000 3000 3000\nElementSpacing = 0.1 0.1 0.1\nOffset = 0 0 0\n"
      "ElementType = MET_SHORT\nElementDataFile = large.raw\n";
  folder.write("large.mhd", head);
  std::filesystem::resize_file(folder.write("large.raw", ""), std::uintmax_t{54'000'000'000}); // sparse
  folder.write("large.toml", std::string(world) + "[[object]]\nname = \"c\"\nkind = \"fixed\"\n"
                                                  "shape = \"box\"\ncells = [2, 2, 2]\n"
                                                  "look = { image = \"large.mhd\", preset = \"ct_bone\" }\n");
  const auto outcome = shell("ulimit -v 4000000; " + std::string(MAILLE_COMMAND) + " render " +
                             path("large.toml") + " --out " + path("x.png"));
  EXPECT_EQ(outcome.code, 2) << outcome.err;
  EXPECT_TRUE(test::has(outcome.err, "3000 x 3000 x 3000"));
  EXPECT_TRUE(test::has(outcome.err, "108000000000 bytes"));
  EXPECT_FALSE(std::filesystem::exists(path("x.png")));
}

// One half of a bar has values that are drawn red, the other blue.
TEST_F(RenderCommandContract, ComparisonsAndReportsShowGreyValues) {
  std::string values;
  for (int voxel = 0; voxel < 6 * 4 * 4; ++voxel)
    values += char(voxel % 6 < 3 ? 50 : 100);
  folder.write("grey.mha", test::meta_image({6, 4, 4}, values));
  const std::string bar = R"(title = "a bar"
[specimen]
shape = "image"
image = "grey.mha"
threshold = 20
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
LOOK
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["0.3 mm", 0, 0]
)";
  const auto draw_with = [&](const std::string& name, const std::string& look) {
    std::string text = bar;
    text.replace(text.find("LOOK"), 4, look);
    const std::string file = folder.write(name + ".toml", text).string();
    const auto compared = test::done("compare " + file + " --methods relaxed --reference relaxed --out " +
                                     path(name) + " --picture " + path(name + ".png"));
  };
  draw_with("plain", "");
  draw_with("grey", R"(look = { image = "grey.mha", colours = [[50, "#ff0000"], [100, "#0000ff"]], )"
                    R"(opacity = [[0, 1], [255, 1]], shading = false })");
  const auto reported = test::done("report " + path("grey"));
  EXPECT_TRUE(test::has(bytes("grey/report.html"), "by its grey values"));
  EXPECT_FALSE(bytes("grey.png").empty());
  EXPECT_NE(bytes("grey.png"), bytes("plain.png"));
}

} // namespace
} // namespace maille
