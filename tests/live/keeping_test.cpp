/// What a hand keeps of what it sees: screenshots, films, the distance from finite elements.

#include "live/by_hand.hpp"
#include "maille/deform/solve.hpp"
#include "maille/images/write_image.hpp"
#include "maille/materials/text_file.hpp"
#include "support/kit.hpp"

#include <atomic>
#include <sys/stat.h>

namespace maille::live {
namespace {

using test::key;
using test::played;
using test::pointer;
using test::world_folder;

/// A picture under a name, in the folder of shots.
ScriptedEvent shot(const std::string& name) {
  ScriptedEvent shot = test::event(EventKind::shot);
  shot.event.text = name;
  return shot;
}

/// Width and height that a PNG says it has.
std::array<int, 2> size_of_png(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::array<unsigned char, 24> head{};
  in.read(reinterpret_cast<char*>(head.data()), head.size());
  if (!in || head[1] != 'P' || head[2] != 'N')
    return {0, 0};
  return {head[18] * 256 + head[19], head[22] * 256 + head[23]};
}

TEST(LiveKeepingContract, ScreenshotsAndFilmsAreFilesOfTheWindowsSize) {
  const maille::test::TemporaryFolder folder;
  HeadlessWindow window(200, 150);
  LiveSettings settings;
  settings.shots = folder.path();
  const ScriptedEvent film = test::event(EventKind::widget, "film");
  LiveTools tools = test::tools();
  std::int64_t n_of_film = 0;
  tools.make_film = [&](const std::filesystem::path& stem, std::int64_t n, double seconds) {
    for (std::int64_t i = 0; i < n; ++i)
      EXPECT_EQ(size_of_png(fmt::format("{}_{:04}.png", stem.string(), i)), (std::array{200, 150}));
    EXPECT_GT(seconds, 0);
    n_of_film = n;
    return std::optional<std::string>{};
  };
  const LiveReport report =
      played(world_folder / "maze.toml",
             {key("F12"), shot("asked.png"), film, key("Home"), key("Home"), film}, window, settings, tools);
  EXPECT_TRUE(report.messages.empty());
  EXPECT_EQ(size_of_png(folder.path() / "asked.png"), (std::array{200, 150}));
  EXPECT_EQ(size_of_png(folder.path() / "maille_001.png"), (std::array{200, 150}));
  EXPECT_GT(n_of_film, 0);
}

TEST(LiveKeepingContract, AFolderThatIsNotThereIsSaid) {
  HeadlessWindow window(200, 150);
  LiveSettings settings;
  settings.shots = "/nobody/made/this";
  const LiveReport report = played(world_folder / "maze.toml", {key("F12")}, window, settings);
  ASSERT_EQ(report.messages.size(), 1u);
  EXPECT_TRUE(test::has(report.messages[0], "/nobody/made/this"));
  EXPECT_TRUE(report.has_lost);
}

TEST(LiveKeepingContract, ScreenshotsStayInTheirFolderAndFollowNoLink) {
  const maille::test::TemporaryFolder folder;
  const auto precious = folder.write("precious.png", "precious"), shots = folder / "shots";
  std::filesystem::create_directory(shots);
  std::filesystem::create_symlink(precious, shots / "link.png");
  std::filesystem::create_directory(shots / "folder.png");
  ASSERT_EQ(mkfifo((shots / "pipe.png").c_str(), 0600), 0);
  for (const std::string name : {"../precious.png", "link.png", "folder.png", "pipe.png", "notes.txt"}) {
    HeadlessWindow window(200, 150);
    LiveSettings settings;
    settings.shots = shots;
    const LiveReport report = played(world_folder / "maze.toml", {shot(name)}, window, settings);
    EXPECT_TRUE(report.has_lost) << name;
    EXPECT_EQ(report.messages.size(), 1U) << name;
  }
  EXPECT_EQ(maille::test::text_of(precious), "precious");
  EXPECT_TRUE(std::filesystem::is_symlink(shots / "link.png") &&
              std::filesystem::is_fifo(shots / "pipe.png"));
  EXPECT_THROW(parse_script("time [s],event,x,y,button,name,value\n0,shot,,,,,../w.png\n", "e.csv"),
               InputError);
}

/// A node of the block is pulled by limits and pinned; F asks for the truth, here `coupled` without limits.
LiveReport asked_for_truth(HeadlessWindow& window, std::vector<ScriptedEvent> then,
                           std::atomic<int>& n_asked) {
  std::vector<ScriptedEvent> script{pointer(EventKind::pointer_down, 80, 60),
                                    pointer(EventKind::pointer_move, 84, 40),
                                    pointer(EventKind::pointer_up, 84, 40, true), key("F")};
  script.insert(script.end(), then.begin(), then.end());
  LiveTools tools = test::tools();
  tools.finite_elements = [&](const Scene& question, const Control& control) {
    ++n_asked;
    Scene asked = question;
    asked.limits = {};
    return deform::solve(asked, "coupled", control);
  };
  return played(std::filesystem::path(MAILLE_SCENES) / "poke_given_limits.toml", script, window, {}, tools);
}

bool says(const HeadlessWindow& window, const std::string& what) {
  return std::ranges::any_of(window.shown().texts, [&](const OverlayText& text) {
    return text.text.find(what) != std::string::npos;
  });
}

TEST(LiveKeepingContract, FiniteElementsAreAskedOnAKeyAndTheDifferenceIsSeen) {
  std::atomic<int> n_asked{0};
  HeadlessWindow window(160, 120);
  const LiveReport report = asked_for_truth(window, {}, n_asked);
  EXPECT_TRUE(report.messages.empty());
  EXPECT_EQ(n_asked, 1);
  EXPECT_TRUE(says(window, "error against finite elements: "));
  ASSERT_NE(window.widget("colour"), nullptr);
  EXPECT_EQ(window.widget("colour")->value, double(ColourBy::fem));
  const bool has_scale = std::ranges::any_of(window.shown().panel, [](const Widget& each) {
    return each.label.starts_with("distance: 0 (dark) to");
  });
  EXPECT_TRUE(has_scale); // the body is coloured by it
}

TEST(LiveKeepingContract, ADifferenceIsNotShownOfAnotherState) {
  std::atomic<int> n_asked{0};
  HeadlessWindow window(160, 120);
  asked_for_truth(window, {key("Z", true)}, n_asked);
  EXPECT_EQ(n_asked, 1);
  EXPECT_FALSE(says(window, "error against finite elements: "));
}

/// What is to be seen: where cropped images lie, both eyes, pictures in motion.

using test::mm;

struct Extent {
  double left = 1e9, right = -1, top = 1e9, bottom = -1;
  std::int64_t n = 0;
};

/// Where an object is in a picture [pixels].
Extent extent_of(const Painted& painted, int object, int from = 0, int to = 1 << 20) {
  Extent extent;
  const int width = int(painted.object.size()) / painted.height;
  for (int y = 0; y < painted.height; ++y)
    for (int x = from; x < std::min(to, width); ++x)
      if (painted.object[std::size_t(y) * std::size_t(width) + std::size_t(x)] == object) {
        extent.left = std::min<double>(extent.left, x);
        extent.right = std::max<double>(extent.right, x);
        extent.top = std::min<double>(extent.top, y);
        extent.bottom = std::max<double>(extent.bottom, y);
        ++extent.n;
      }
  return extent;
}

WorldState at_rest(const WorldScene& scene) {
  WorldState state;
  state.scene_number = 1;
  for (const WorldObject& object : scene.objects) {
    state.frames.push_back(deform::frame_of(object));
    state.displacements.push_back(object.kind == ObjectKind::deformable
                                      ? std::make_shared<const Displacement>(object.scene.specimen.grid)
                                      : nullptr);
  }
  return state;
}

/// An image that is mostly empty, lies far from its world's origin and is turned: its body is cropped.
std::string image_of_a_block(const maille::test::TemporaryFolder& folder) {
  Image image;
  image.info.size = {30, 24, 20};
  image.info.spacing = {1 * mm, 1 * mm, 1 * mm};
  image.info.origin = {-0.2, 0.1, 0.35};
  image.info.direction = {{{0, -1, 0}, {1, 0, 0}, {0, 0, 1}}};
  image.info.world = WorldAxes::ras;
  image.values.assign(std::size_t(image.info.n_voxels()), 0);
  for (int k = 12; k < 17; ++k)
    for (int j = 3; j < 11; ++j)
      for (int i = 17; i < 28; ++i)
        image.values[std::size_t(i + 30 * (j + 24 * k))] = 100;
  const std::string file = folder.path() / "block.nii.gz";
  write_image(image, file);
  return file;
}

// Grey values of an image lie where the matter lies that was cut out of it, alone and in a world.
TEST(LivePicturesContract, GreyValuesLieWhereTheCroppedMatterLies) {
  const maille::test::TemporaryFolder folder;
  const std::string image = image_of_a_block(folder);
  const std::string body =
      "shape = \"image\"\nimage = \"" + image +
      "\"\nthreshold = 50\nmaterial = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n";
  const std::string look =
      "look = { colours = [[0, \"#cc2222\"], [100, \"#cc2222\"]], opacity = [[40, 0], [60, 1]] }\n";
  const auto alone = folder.write("alone.toml", "[specimen]\n" + body + "[[hold]]\nwhere = \"z-\"\n");
  const auto world = folder.write(
      "world.toml", "[world]\ncells = [60, 60, 60]\nspacing = \"1 mm\"\n[[object]]\nname = \"block\"\n"
                    "kind = \"rigid\"\nposition = [\"14 mm\", \"11 mm\", \"9 mm\"]\n" +
                        body);
  for (const auto& file : {alone, world}) {
    std::vector<std::string> notes;
    const WorldScene scene =
        is_world_scene(file) ? read_world_scene(file) : world_of_body(read_scene(file), "limits", notes);
    const std::string text = read_text_file(file, "a scene");
    const auto seen = folder.write("seen.toml", text.substr(0, text.find("threshold")) + look +
                                                    text.substr(text.find("threshold")));
    const auto looks = read_looks(seen);
    ASSERT_EQ(looks.size(), 1u);
    ASSERT_TRUE(looks[0] && !looks[0]->grey.values.empty());
    const Looking looking = first_looking(scene, 300, 300);
    const Painted matter = volume_painter({}, 1)->paint(scene, at_rest(scene), looking);
    const Painted grey = volume_painter(looks, 1)->paint(scene, at_rest(scene), looking);
    const Extent a = extent_of(matter, 0), b = extent_of(grey, 0);
    ASSERT_GT(a.n, 400) << file;
    const double voxel = (a.right - a.left) / 11; // at least
    EXPECT_NEAR(a.left, b.left, 0.6 * voxel) << file;
    EXPECT_NEAR(a.right, b.right, 0.6 * voxel) << file;
    EXPECT_NEAR(a.top, b.top, 0.6 * voxel) << file;
    EXPECT_NEAR(a.bottom, b.bottom, 0.6 * voxel) << file;
  }
}

TEST(LivePicturesContract, BothEyesSeeTheWorldFromTheirOwnSides) {
  const WorldScene scene = read_world_scene(test::world_folder / "bolt.toml");
  Looking looking = first_looking(scene, 240, 160);
  const auto painter = volume_painter({}, 1);
  const Painted one = painter->paint(scene, at_rest(scene), looking);
  looking.stereo = Stereo::side_by_side;
  const Painted two = painter->paint(scene, at_rest(scene), looking);
  EXPECT_EQ(two.width, 240);
  EXPECT_EQ(two.height, 160);
  EXPECT_EQ(two.object.size(), std::size_t{120} * 160); // the left eye's
  std::size_t n_left = 0, n_right = 0, n_other = 0;
  for (std::size_t y = 0; y < 160; ++y)
    for (std::size_t x = 0; x < 120; ++x) {
      const std::uint8_t* const left = two.rgba->data() + 4 * (240 * y + x);
      const std::uint8_t* const right = left + std::size_t{4} * 120;
      n_left += left[1] < 240;
      n_right += right[1] < 240;
      n_other += std::abs(left[1] - right[1]) > 30; // none from one place
    }
  EXPECT_GT(n_left, 500u);
  EXPECT_NEAR(double(n_right) / double(n_left), 1, 0.1);
  EXPECT_GT(n_other, 50u); // from two places
  looking.stereo = Stereo::anaglyph;
  looking.eye_separation = 0.02; // wider than by itself, so that small pictures have broad seams
  const Painted red_and_cyan = painter->paint(scene, at_rest(scene), looking);
  EXPECT_EQ(red_and_cyan.object.size(), std::size_t{240} * 160);
  std::size_t n_red = 0, n_cyan = 0;
  for (std::size_t i = 0; i < red_and_cyan.rgba->size(); i += 4) {
    const int red = (*red_and_cyan.rgba)[i], green = (*red_and_cyan.rgba)[i + 1];
    n_red += red > green + 60;
    n_cyan += green > red + 60;
  }
  EXPECT_GT(n_red, 50u); // seams of what each eye alone sees
  EXPECT_GT(n_cyan, 50u);
  EXPECT_NE(*one.rgba, *red_and_cyan.rgba);
}

// A body of 41^3 nodes, bent: the picture in motion shows it where the whole one does.
TEST(LivePicturesContract, AMovingPictureOfALargeBodyHasItsForm) {
  const WorldScene scene = test::block_world("limits", 40);
  WorldState state = at_rest(scene);
  const Specimen& body = scene.objects[0].scene.specimen;
  Displacement bent(body.grid);
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    const Vec3 x = body.position(body.grid.node_at(node));
    bent(0, node) = 8 * x[2] * x[2];
    bent(1, node) = -3 * x[2] * x[0];
  }
  state.displacements[0] = std::make_shared<const Displacement>(bent);
  Looking looking = first_looking(scene, 200, 200);
  const auto painter = volume_painter({}, 1);
  const Painted still = painter->paint(scene, at_rest(scene), looking);
  const Painted whole = painter->paint(scene, state, looking);
  looking.is_rough = true;
  const Painted rough = painter->paint(scene, state, looking);
  std::int64_t n = 0, n_other = 0, n_moved = 0;
  for (std::size_t i = 0; i < whole.object.size(); ++i) {
    n += whole.object[i] == 0;
    n_other += whole.object[i] != rough.object[i];
    n_moved += whole.object[i] != still.object[i];
  }
  EXPECT_GT(n, 4000);
  EXPECT_GT(n_moved, n / 20);
  EXPECT_LT(n_other, n / 50);
}

} // namespace
} // namespace maille::live
