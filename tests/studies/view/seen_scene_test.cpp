// What scenes and worlds become for the renderer: pictures on pieces, labels and fibres as colours.

#include "picture/read_picture.hpp"
#include "studies/prototype_scenes.hpp"
#include "support/kit.hpp"
#include "view/seen_scene.hpp"

#include "maille/scene/read_scene.hpp"

#include <zlib.h>

namespace maille::studies {
namespace {

using test::mm;

const std::filesystem::path folder = std::filesystem::path(MAILLE_SCENES) / "render";

/// Straight from above, a pixel a cell, over a box of the plane whose lower left corner is given [m].
render::View from_above(double x, double y, int width, int height) {
  render::View view;
  view.width = width;
  view.height = height;
  view.camera.parallel = true;
  view.camera.parallel_scale = 0.5 * height * mm;
  view.camera.focal_point = {x + 0.5 * width * mm, y + 0.5 * height * mm, 0};
  view.camera.position = view.camera.focal_point;
  view.camera.position[2] = 0.1;
  view.camera.view_up = {0, 1, 0};
  return view;
}

Player puzzle() {
  WorldScene world = read_world_scene(folder / "puzzle.toml");
  Trajectory path = read_trajectory(folder / "puzzle_solved.toml", world);
  return {deform::World(std::move(world)), std::move(path)};
}

// The pieces were cut from the picture: put together they are it, in every byte.
TEST(PuzzleOfAPictureAnalytic, AssembledPixelForPixel) {
  Player player = puzzle();
  for (const PlayedFrame& frame : test::play_to_the_end(player))
    EXPECT_NEAR(test::done_of(frame), 1, 1e-9) << "in frame " << frame.number;
  SeenScene seen = seen_world(player.world().scene(), folder / "puzzle.toml");
  const ColourPicture source = read_picture(folder / "puzzle.png");
  ASSERT_EQ(source.width, 144);
  ASSERT_EQ(source.height, 96);
  const render::View view = from_above(28 * mm, 27 * mm, source.width, source.height);
  render::Renderer renderer;
  EXPECT_NE(renderer.render(seen.objects, view).rgb8(), source.rgb); // apart
  follow(player.world(), seen);
  EXPECT_EQ(renderer.render(seen.objects, view).rgb8(), source.rgb);
}

// Seen from a slant, too, nothing shines through where two pieces meet.
TEST(PuzzleOfAPictureAnalytic, SeamsAreClosed) {
  WorldScene scene = read_world_scene(folder / "puzzle.toml");
  for (WorldObject& object : scene.objects)
    object.position = {28 * mm, 27 * mm, 2 * mm};
  SeenScene seen = seen_world(scene, folder / "puzzle.toml");
  follow(deform::World(std::move(scene)), seen);
  render::View view = from_above(28 * mm, 27 * mm, 160, 120);
  view.camera.parallel = false;
  view.camera.view_angle = 20;
  for (const double across : {0.0, 0.04, -0.1}) {
    view.camera.position = {100 * mm + across, 75 * mm - 0.08, 0.3};
    render::Renderer renderer;
    const render::Picture& picture = renderer.render(seen.objects, view);
    for (std::size_t p = 0; p < picture.rgba.size(); ++p) {
      const auto x = int(p % 160), y = int(p / 160);
      const render::Ray ray = view.camera.ray(160, 120, x, y);
      // Where the ray meets the middle of the pieces, 3 mm thick; two cells at the rim are left out.
      const double t = (3.5 * mm - ray.origin[2]) / ray.direction[2];
      const double at_x = ray.origin[0] + t * ray.direction[0], at_y = ray.origin[1] + t * ray.direction[1];
      // Corners are rounded: where four of them meet they leave a dot.
      const bool is_corner = std::abs(at_y - 75 * mm) < 2 * mm &&
                             std::min(std::abs(at_x - 76 * mm), std::abs(at_x - 124 * mm)) < 2 * mm;
      if (at_x > 31 * mm && at_x < 169 * mm && at_y > 30 * mm && at_y < 120 * mm && !is_corner) {
        EXPECT_EQ(picture.rgba[p][3], 1) << "at " << at_x / mm << ", " << at_y / mm << " mm from " << across;
      }
    }
  }
}

/// A bar of 8 x 4 x 4 voxels, its halves along x of two values.
std::string image_of_halves(int left, int right) {
  std::string values;
  for (int voxel = 0; voxel < 8 * 4 * 4; ++voxel)
    values += char(voxel % 8 < 4 ? left : right);
  return test::meta_image({8, 4, 4}, values);
}

// A bar of two labels, one of which has a colour: the other keeps the look's, up to the surface.
TEST(LabelPaintAnalytic, WhatHasNoColourOfItsOwnKeepsTheLooks) {
  const test::TemporaryFolder temporary;
  temporary.write("labels.mha", image_of_halves(1, 2));
  const auto file = temporary.write("bar.toml", R"(title = "a bar"
[specimen]
shape = "image"
image = "labels.mha"
labels = { 1 = "muscle/soleus", 2 = "muscle/soleus" }
fibre = [1, 0, 0]
look = { colour = "#0000ff", shading = false, labels = { 2 = "#ff0000" } }
[[hold]]
where = "x-"
)");
  const SeenScene seen = seen_scene(read_scene(file), file, false);
  const render::View view = [&] {
    render::View from = from_above(0, 0, 80, 40);
    const auto box = render::bounds_of(seen.objects[0]);
    for (std::size_t a = 0; a < 2; ++a)
      from.camera.focal_point[a] = from.camera.position[a] = 0.5 * (box->low[a] + box->high[a]);
    from.camera.parallel_scale = 2 * mm;
    return from;
  }();
  render::Renderer renderer;
  const std::vector<std::uint8_t> rgb = renderer.render(seen.objects, view).rgb8();
  for (int y = 6; y < 34; ++y)
    for (int x = 4; x < 76; ++x) {
      if (x > 37 && x < 42)
        continue;
      const std::uint8_t* const pixel = rgb.data() + 3 * (80 * y + x);
      ASSERT_EQ(pixel[x < 40 ? 2 : 0], 255) << x << " " << y;
      ASSERT_EQ(pixel[x < 40 ? 0 : 2], 0) << x << " " << y;
    }
}

TEST(PuzzleOfAPictureContract, UndercutTabsHoldInThePlane) {
  WorldScene scene = read_world_scene(folder / "puzzle.toml");
  for (WorldObject& object : scene.objects)
    object.position = {28 * mm, 27 * mm, 2 * mm};
  for (const char* name : {"piece_00", "piece_11", "piece_21"}) {
    deform::World world(scene);
    for (int i = 0; i < world.n_objects(); ++i) { // a hand on each
      deform::Drive held;
      held.object = i;
      world.advance({&held, 1});
    }
    deform::Drive drive;
    drive.object = test::object_named(world, name);
    const bool is_left = name == std::string("piece_00"), is_right = name == std::string("piece_21");
    drive.motion.by = {is_left ? -10 * mm : is_right ? 10 * mm : 0, is_left || is_right ? 0 : 10 * mm, 0};
    EXPECT_LT(world.advance({&drive, 1}).drives[0].fraction, 0.3) << name;
    drive.motion.by = {0, 0, 8 * mm};
    EXPECT_NEAR(world.advance({&drive, 1}).drives[0].fraction, 1, 1e-9) << name;
  }
}

class PicturesContract : public testing::Test {
protected:
  std::string fault_of(const std::string& look) {
    const auto file = folder_.write(
        "world.toml",
        test::world_text("[9, 9]") + test::object_text("a", "rigid", "[4, 3]", "look = { " + look + " }\n"));
    const auto faults = test::faults_found_by([&] { seen_world(read_world_scene(file), file); });
    return faults.empty() ? "" : InputError(faults).what();
  }
  void write_picture(const char* name, int width, int height) const {
    write_png(std::vector<std::uint8_t>(std::size_t(3 * width * height), 200), width, height,
              folder_.path() / name);
  }
  test::TemporaryFolder folder_;
};

TEST_F(PicturesContract, WhatIsNoPictureIsTold) {
  folder_.write("words.png", "no picture at all");
  write_picture("whole.png", 40, 40);
  const std::string whole = test::text_of(folder_.path() / "whole.png");
  folder_.write("broken.png", whole.substr(0, whole.size() / 2));
  std::string damaged = whole;
  damaged[whole.size() / 2] ^= 1;
  folder_.write("damaged.png", damaged);
  for (const auto& [name, part] : {std::pair{"words.png", "a file that is none"},
                                   {"broken.png", "breaks off"},
                                   {"damaged.png", "is damaged"},
                                   {"absent.png", "absent.png"},
                                   {"words.bmp", ".png, .jpg or .jpeg"}})
    EXPECT_TRUE(test::has(fault_of(fmt::format("picture = \"{}\"", name)), part));
}

TEST_F(PicturesContract, APictureReachesOverAllOfTheBody) {
  write_picture("small.png", 3, 3);
  EXPECT_TRUE(test::has(fault_of("picture = \"small.png\""), "3 x 3 pixels"));
  EXPECT_EQ(fault_of("picture = \"small.png\", pixel = \"2 mm\""), "");
  EXPECT_TRUE(test::has(fault_of("picture = \"small.png\", pixel = \"-2 mm\""), "pixel"));
  EXPECT_TRUE(test::has(fault_of("colour = \"#ff0000\", picture = \"small.png\""), "one of"));
  EXPECT_TRUE(test::has(fault_of("colour = \"#ff0000\", pixel = \"1 mm\""), "without `picture`"));
}

TEST(FieldPaintAnalytic, LabelsAndFibresColourTheirCells) {
  const Scene scene = parse_scene("[specimen]\nshape = \"box\"\ncells = [4, 4, 4]\nspacing = \"1 mm\"\n"
                                  "material = \"muscle/soleus\"\nfibre = [0, 0.6, 0.8]\n"
                                  "[[hold]]\nwhere = \"x-\"\n");
  double largest = 0;
  const auto fibres = paint_of_field(scene, nullptr, "fibres", largest);
  EXPECT_EQ(fibres->pixels()[1 + 4 * (2 + 4 * 3)], 0xcc9900U); // 0.8 of blue, 0.6 of green: z and y
  const auto labels = paint_of_field(scene, nullptr, "labels", largest);
  EXPECT_EQ(labels->numbers()[0], labels->numbers()[63]); // of one material
  EXPECT_EQ(paint_of_field(scene, nullptr, "strain", largest), nullptr);
}

// A bar of 8 mm, of one value on the left and another on the right, is pulled to twice its length: the border
// of its colours is then at 8 mm of 16, and where it is drawn half as far at 6 mm of 12.
TEST(GreyPanelsAnalytic, CarryTheImageWithTheBody) {
  const test::TemporaryFolder temporary;
  temporary.write("grey.mha", image_of_halves(50, 100));
  const auto file = temporary.write("bar.toml", R"(title = "a bar"
[specimen]
shape = "image"
image = "grey.mha"
threshold = 20
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
look = { image = "grey.mha", colours = [[50, "#ff0000"], [100, "#0000ff"]], opacity = [[0, 1], [255, 1]], shading = false }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["1 mm", 0, 0]
)");
  const Scene scene = read_scene(file);
  const DrawBody draw = draw_grey_values(scene, file, 1);
  ASSERT_TRUE(draw);
  const Grid& grid = scene.specimen.grid;
  Displacement pulled(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    pulled(0, node) = 1 * mm * double(grid.node_at(node)[0]);
  for (const double warp : {0.0, 0.5, 1.0}) {
    PanelView panel;
    panel.centre = {0.5 * 8 * mm * (1 + warp), 2 * mm, 2 * mm};
    for (std::size_t a = 0; a < 3; ++a)
      panel.centre[a] += scene.specimen.origin[a];
    panel.pixels_per_metre = 10e3;
    panel.width = 200;
    panel.height = 60;
    panel.warp = warp;
    const std::vector<std::uint8_t> rgb = draw(pulled, panel);
    int red = 0, blue = 0;
    for (std::size_t x = 0; x < 200; ++x) {
      const std::uint8_t* const pixel = rgb.data() + 3 * (200 * 30 + x);
      const bool is_red = pixel[0] > 128 && pixel[1] < 64 && pixel[2]<128, is_blue = pixel[2]> 128 &&
                          pixel[1] < 64 && pixel[0] < 128;
      red += is_red;
      blue += is_blue;
      EXPECT_FALSE(is_red && x > 101) << x;
      EXPECT_FALSE(is_blue && x < 98) << x;
    }
    // Beyond the outermost centres of voxels there is nothing: half a voxel at either end.
    EXPECT_NEAR(red, 35 * (1 + warp), 7 * (1 + warp)) << warp;
    EXPECT_NEAR(blue, 35 * (1 + warp), 7 * (1 + warp)) << warp;
  }
}

// Pictures that libpng refuses, and bytes changed at random: a fault or a picture, never a signal.
TEST_F(PicturesContract, DamagedPicturesAreFaults) {
  write_picture("whole.png", 12, 9);
  const std::string whole = test::text_of(folder_.path() / "whole.png");
  std::mt19937 random(5);
  int n_refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string bytes = whole;
    for (std::uint64_t n = 1 + random() % 3; n > 0; --n)
      bytes[random() % bytes.size()] = char(random());
    if (i % 2 == 0) { // the header's checksum is right
      const auto sum = std::uint32_t(crc32(0, reinterpret_cast<const Bytef*>(bytes.data()) + 12, 17));
      for (std::size_t b = 0; b < 4; ++b)
        bytes[29 + b] = char(sum >> (24 - 8 * b));
    }
    try {
      const ColourPicture picture = read_png(bytes, "a.png");
      EXPECT_EQ(picture.rgb.size(), std::size_t(3 * picture.width * picture.height));
    } catch (const InputError& error) {
      ++n_refused;
      EXPECT_EQ(error.faults().front().file, "a.png");
    }
  }
  EXPECT_GT(n_refused, 500);
}

TEST_F(PicturesContract, PixelsFollowTheFile) {
  EXPECT_THROW(require_picture_size("a.png", 16384, 16384, 783'000), InputError);
  EXPECT_THROW(require_picture_size("a.png", 16385, 1, 1 << 30), InputError);
  EXPECT_NO_THROW(require_picture_size("a.png", 16384, 16384, 30'000'000));
  EXPECT_NO_THROW(require_picture_size("a.png", 4096, 4096, 100));
}

} // namespace
} // namespace maille::studies
