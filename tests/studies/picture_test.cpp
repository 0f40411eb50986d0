#include "picture/comparison_picture.hpp"

#include "maille/scene/world/world_scene.hpp"
#include "picture/layout.hpp"
#include "picture/question_arrows.hpp"
#include "picture/question_picture.hpp"
#include "picture/world_picture.hpp"
#include "studies/export/export_scenes.hpp"
#include "support/kit.hpp"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

namespace maille::studies {
namespace {
namespace fs = std::filesystem;
using test::block;
using test::block_with_holes;
using test::TemporaryFolder;
using test::wave;

using Colour = std::tuple<int, int, int>;

struct Picture {
  int width = 0, height = 0;
  std::map<Colour, int> pixels; ///< how many are of a colour
  Colour corner;
  double share_of_paper() const { return double(pixels.at({255, 255, 255})) / (width * height); }
};

Picture read_back(const fs::path& png) {
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(png.c_str());
  reader->Update();
  vtkImageData& image = *reader->GetOutput();
  Picture picture{image.GetDimensions()[0], image.GetDimensions()[1], {}, {}};
  const auto* values = static_cast<const unsigned char*>(image.GetScalarPointer());
  picture.corner = {values[0], values[1], values[2]};
  for (int pixel = 0; pixel < picture.width * picture.height;
       ++pixel, values += image.GetNumberOfScalarComponents())
    ++picture.pixels[{values[0], values[1], values[2]}];
  return picture;
}

struct Body {
  const char* name;
  Scene scene;
};

/// GoogleTest prints the name, not the bytes.
void PrintTo(const Body& body, std::ostream* stream) {
  *stream << body.name;
}

class PictureContract : public testing::TestWithParam<Body> {};

/// A body in colours on white paper: more colours than text alone has, and paper left and right of it.
TEST_P(PictureContract, ShowsTheBodyOnWhitePaper) {
  const Scene& scene = GetParam().scene;
  const Displacement one = wave(scene, 1e-3), other = wave(scene, 1e-3, 1);
  TemporaryFolder folder;
  const fs::path png = folder / "picture.png";
  const auto why_not = render_comparison(scene, {{"limits", &one, 0.25, false}, {"fem_q1", &other, {}, true}},
                                         png, {.width = 800});
  if (why_not)
    GTEST_SKIP() << *why_not;
  const Picture picture = read_back(png);
  EXPECT_EQ(picture.width, 800);
  EXPECT_GT(picture.height, 100);
  EXPECT_LE(picture.height, 800);
  EXPECT_GT(picture.pixels.size(), 500u); // grey text has no more than 256
  EXPECT_EQ(picture.corner, (Colour{255, 255, 255}));
  EXPECT_GT(picture.share_of_paper(), 0.2);
  EXPECT_LT(picture.share_of_paper(), 0.97);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

INSTANTIATE_TEST_SUITE_P(Bodies, PictureContract,
                         testing::Values(Body{"line", block(1, {9, 1, 1})},
                                         Body{"sheet", block(2, {9, 5, 1})}, Body{"box", block(3, {9, 4, 3})},
                                         Body{"one_cell", block(3, {1, 1, 1})},
                                         Body{"holed_line", block_with_holes(1, {9, 1, 1})},
                                         Body{"holed_sheet", block_with_holes(2, {9, 5, 1})},
                                         Body{"holed_box", block_with_holes(3, {9, 4, 3})},
                                         Body{"tall_box", block(3, {3, 4, 9})}),
                         [](const auto& parameter) { return std::string(parameter.param.name); });

TEST(PictureExtremesContract, DrawsWhatHasNoSizeOrNoValue) {
  const Scene scene = block(3, {3, 2, 2});
  const Displacement still(scene.specimen.grid);
  Displacement wild = wave(scene, 1e-3), tiny = wave(scene, 1e-300), huge = wave(scene, 1e30);
  wild(0, 3) = std::numeric_limits<double>::quiet_NaN();
  wild(1, 4) = std::numeric_limits<double>::infinity();
  TemporaryFolder folder;
  for (const Displacement* displacement :
       std::initializer_list<const Displacement*>{&still, &wild, &tiny, &huge}) {
    const auto why_not = render_comparison(scene, {{"extreme", displacement, {}, false}},
                                           folder / "picture.png", {.width = 400});
    if (why_not)
      GTEST_SKIP() << *why_not;
    EXPECT_EQ(read_back(folder / "picture.png").width, 400);
  }
}

TEST(PictureFileContract, RefusesPanelsWithoutAnswer) {
  const Scene scene = block(3, {2, 2, 2});
  const Displacement other(Grid(3, {2, 2, 3}, {1, 1, 1}));
  TemporaryFolder folder;
  EXPECT_THROW((void)render_comparison(scene, {}, folder / "a.png"), std::invalid_argument);
  EXPECT_THROW((void)render_comparison(scene, {{"none", nullptr, {}, false}}, folder / "a.png"),
               std::invalid_argument);
  EXPECT_THROW((void)render_comparison(scene, {{"other", &other, {}, false}}, folder / "a.png"),
               std::invalid_argument);
}

TEST(PictureFileContract, SaysWhereItCouldNotWriteAndLeavesNoHalfFile) {
  const Scene scene = block(2, {2, 2, 1});
  const Displacement still(scene.specimen.grid);
  TemporaryFolder folder;
  for (const bool is_full : {false, true}) {
    const std::string name = is_full ? "a.png" : "missing/a.png";
    std::optional<test::FullDisk> full;
    if (is_full)
      full.emplace(1000);
    try {
      if (const auto why_not = render_comparison(scene, {{"still", &still, {}, false}}, folder / name))
        GTEST_SKIP() << *why_not;
      ADD_FAILURE() << "written";
    } catch (const fs::filesystem_error& error) {
      EXPECT_TRUE(test::has(std::string(error.what()), name));
    }
    EXPECT_TRUE(folder.is_empty());
  }
}

/// Draws in a process that finds no EGL (an empty vendor list), and ends it with 0 if the message has `part`,
/// or if a picture was made and `part` is empty.
/// @param display  of an X server; null: none
[[noreturn]] void draw_without_egl(const char* display, const char* part) {
  setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent", 1);
  if (display == nullptr)
    unsetenv("DISPLAY");
  else
    setenv("DISPLAY", display, 1);
  const Scene scene = block(2, {2, 2, 1});
  const Displacement still(scene.specimen.grid);
  TemporaryFolder folder;
  const auto why_not =
      render_comparison(scene, {{"still", &still, {}, false}}, folder / "a.png", {.width = 300});
  std::cerr << why_not.value_or("made");
  const bool as_expected = why_not ? *part != '\0' && why_not->find(part) != std::string::npos
                                   : *part == '\0' && fs::exists(folder / "a.png");
  std::_Exit(as_expected ? 0 : 1);
}

TEST(PictureFallbackContract, SaysWhyThereIsNone) {
  GTEST_FLAG_SET(death_test_style, "threadsafe"); // a process of its own: EGL reads its vendors once
  EXPECT_EXIT(draw_without_egl(nullptr, "no picture"), testing::ExitedWithCode(0), "DISPLAY is not set");
  EXPECT_EXIT(draw_without_egl(":4711", "no picture"), testing::ExitedWithCode(0), "does not answer");
}

TEST(PictureFallbackContract, DrawsWithX) {
  if (std::getenv("DISPLAY") == nullptr)
    GTEST_SKIP() << "no X server (xvfb-run brings one)";
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(draw_without_egl(std::getenv("DISPLAY"), ""), testing::ExitedWithCode(0), "made");
}

// Truth: the rule in the header. The body is 10 cells of 1 mm long; 0.12 of that over the displacement,
// rounded down to 1, 2, 5 times a power of ten.
TEST(ChosenWarpAnalytic, KeepsTrueScaleUnlessItCannotBeSeen) {
  const Scene scene = block(1, {10, 1, 1});
  Displacement displacement(scene.specimen.grid);
  const auto warp_at = [&](double largest) {
    displacement(0, 10) = -largest;
    return chosen_warp(scene, {{"", &displacement, {}, false}});
  };
  EXPECT_EQ(warp_at(0), 1);
  EXPECT_EQ(warp_at(5e-3), 1);
  EXPECT_EQ(warp_at(3.1e-4), 1);
  EXPECT_EQ(warp_at(2.9e-4), 2);                 // 4.1
  EXPECT_EQ(warp_at(1e-4), 10);                  // 12
  EXPECT_EQ(warp_at(2.3e-4), 5);                 // 5.2
  EXPECT_NEAR(warp_at(1.1e-9), 1e6, 1e-9 * 1e6); // 1.09e6; powers of ten round
}

/// Pixels of about a colour.
int pixels_of(const fs::path& png, const Vec3& colour) {
  int n = 0;
  for (const auto& [of, count] : read_back(png).pixels) {
    const auto& [red, green, blue] = of;
    const auto is_near = [](int value, double wanted) { return std::abs(value - 255 * wanted) < 3; };
    n += is_near(red, colour[0]) && is_near(green, colour[1]) && is_near(blue, colour[2]) ? count : 0;
  }
  return n;
}

// Truth: what is held, moved, loaded, on springs and made of fibres has a colour each, which is on the page
// where the scene has such a thing, and nowhere else.
TEST(QuestionPictureContract, EveryConditionHasItsColour) {
  Scene scene = block(3, {8, 6, 4});
  scene.specimen.label.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 17);
  const auto of_plane = [&](int x, bool held) {
    for (int component = 0; component < 3; ++component)
      for (int y = 0; y <= 6; ++y)
        for (int z = 0; z <= 4; ++z)
          scene.prescribed.push_back(
              {scene.specimen.grid.node({x, y, z}), component, held ? 0 : 1e-3, held, 0});
  };
  const auto load = [&] {
    for (const bool upper : {false, true}) // whichever the viewer sees
      for (int x = 0; x < 8; ++x)
        scene.tractions.push_back(
            {scene.specimen.grid.cell({x, upper ? 5 : 0, 2}), 1, upper, {0, 100, 0}, 1});
  };
  const auto spring = [&] {
    for (const bool upper : {false, true})
      for (int x = 0; x < 8; ++x)
        scene.springs.push_back({scene.specimen.grid.cell({x, upper ? 5 : 0, 1}), 1, upper, 1e6, {}, 2});
  };
  const auto stiffen = [&] {
    scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(3e4, 1e4, 4e3, 0.3, 0.3);
  };
  scene.conditions = {{"hold[1]", "x-"}, {"load[1]", "y-"}, {"load[2]", "y-"}};
  TemporaryFolder folder;
  const fs::path bare = folder / "bare.png", full = folder / "full.png";
  if (const auto why_not = render_question(scene, bare, {.width = 500}))
    GTEST_SKIP() << *why_not;
  of_plane(0, true);
  of_plane(8, false);
  load();
  spring();
  stiffen();
  ASSERT_FALSE(render_question(scene, full, {.width = 500}));
  for (const Vec3& colour : {held_colour, moved_colour, loaded_colour, sprung_colour, fibre_colour}) {
    const int before = pixels_of(bare, colour);
    EXPECT_LT(before, 30) << colour[0]; // text has greys of all kinds
    EXPECT_GT(pixels_of(full, colour), before + 40) << colour[0];
  }
}

// Truth: a bone that goes out and comes back has moved, though at the end it is where it was.
TEST(QuestionPictureContract, ADriveThatComesBackHasItsArrow) {
  Scene scene = block(3, {8, 2, 2});
  Drive drive;
  for (int y = 0; y <= 2; ++y)
    for (int z = 0; z <= 2; ++z)
      drive.nodes.push_back(scene.specimen.grid.node({8, y, z}));
  drive.poses = {{0, {1, 0, 0, 0}, {}}, {0.5, {1, 0, 0, 0}, {0, 0, 2e-3}}, {1, {1, 0, 0, 0}, {}}};
  for (int component = 0; component < 3; ++component)
    for (const std::int64_t node : drive.nodes)
      scene.prescribed.push_back({node, component, 0, false, 0});
  scene.drives = {drive};
  scene.conditions = {{"drive[1]", "x+"}};
  const std::vector<Arrow> arrows = arrows_of(scene, 5e-3);
  ASSERT_EQ(arrows.size(), 1U);
  EXPECT_EQ(arrows[0].colour, moved_colour);
  EXPECT_NEAR(arrows[0].to[2] - arrows[0].from[2], 5e-3, 1e-9);
  EXPECT_NEAR(arrows[0].to[0], arrows[0].from[0], 1e-12);
}

// Truth: the world of a NIfTI image is right, anterior, superior: whatever an image's own axes are, superior
// is up on the page, anterior towards the viewer, and right of the patient on the viewer's left.
TEST(ImageViewAnalytic, TheBodyStandsUprightHoweverItsImageIsStored) {
  const std::array<std::array<Vec3, 3>, 3> directions{{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
                                                       {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}},
                                                       {{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}}}};
  for (const auto& direction : directions) {
    Scene scene = test::block(3, {4, 3, 2});
    scene.specimen.shape = "image";
    scene.specimen.placement.direction = direction;
    const Displacement rest(scene.specimen.grid);
    const View view = choose_view(scene, {{"rest", &rest}}, 1, {0, 1, 2});
    const auto axes = world_axes(view, scene.specimen.placement);
    EXPECT_LT(axes[0][0], -0.8) << "right";
    EXPECT_NEAR(axes[0][1], 0.4384 * 0.2079, 1e-3) << "seen from 12 degrees above, 26 to the side";
    EXPECT_LT(axes[1][1], 0);
    EXPECT_NEAR(axes[2][0], 0, 1e-12);
    EXPECT_NEAR(axes[2][1], 0.9781, 1e-4) << "superior";
  }
}

// Truth: the scene: 8 of 200 cells are the piece's, 20 the wall's; the page's colours are those that
// object_colour names.
TEST(WorldPictureAnalytic, ObjectsTakeTheirShareOfTheWorld) {
  const WorldScene world =
      parse_world_scene(test::world_text("[20, 10]") + test::object_text("wall", "fixed", "[20, 1]") +
                        test::object_text("piece", "rigid", "[4, 2]", "position = [\"3 mm\", \"4 mm\"]\n"));
  const auto corners = [](const Grid& grid, double x, double y) {
    std::vector<Vec3> nodes;
    for (int j = 0; j < grid.nodes()[1]; ++j)
      for (int i = 0; i < grid.nodes()[0]; ++i)
        nodes.push_back({x + 1e-3 * i, y + 1e-3 * j, 0});
    return std::make_shared<const std::vector<Vec3>>(std::move(nodes));
  };
  const WorldMoment moment{0,
                           {corners(world.objects[0].scene.specimen.grid, 0, 0),
                            corners(world.objects[1].scene.specimen.grid, 3e-3, 4e-3)},
                           {}};
  const test::TemporaryFolder folder;
  const auto png = folder / "world.png";
  if (const auto why = render_world(world, {{"now", &moment}}, png, {.title = "", .width = 801}))
    GTEST_SKIP() << *why;
  Picture picture = read_back(png);
  EXPECT_EQ(picture.width % 2, 0); // as films want it
  EXPECT_EQ(picture.height % 2, 0);
  const double cell = double(picture.pixels[{189, 189, 194}]) / 20; // the wall is 0.74 0.74 0.76
  EXPECT_GT(cell, 100);
  // Edges and, below the drawing, the object's name are of the same colour, and take or add a little.
  EXPECT_NEAR(double(picture.pixels[{0, 114, 178}]) / cell, 8, 1.2);
}

} // namespace
} // namespace maille::studies
