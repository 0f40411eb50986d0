#include "picture/world_picture.hpp"

#include "maille/scene/world/world_scene.hpp"
#include "support/kit.hpp"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

namespace maille::studies {
namespace {

using Colour = std::tuple<int, int, int>;

struct Picture {
  int width = 0, height = 0;
  std::vector<Colour> pixels; ///< from the lowest line
  std::size_t count(const Colour& colour) const { return std::size_t(std::ranges::count(pixels, colour)); }
};

Picture read_back(const std::filesystem::path& png) {
  vtkNew<vtkPNGReader> reader;
  reader->SetFileName(png.c_str());
  reader->Update();
  vtkImageData& image = *reader->GetOutput();
  Picture picture{image.GetDimensions()[0], image.GetDimensions()[1], {}};
  const auto* values = static_cast<const unsigned char*>(image.GetScalarPointer());
  for (int pixel = 0; pixel < picture.width * picture.height;
       ++pixel, values += image.GetNumberOfScalarComponents())
    picture.pixels.push_back({values[0], values[1], values[2]});
  return picture;
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
  const Picture picture = read_back(png);
  EXPECT_EQ(picture.width % 2, 0); // as films want it
  EXPECT_EQ(picture.height % 2, 0);
  const double cell = double(picture.count({189, 189, 194})) / 20; // the wall is 0.74 0.74 0.76
  EXPECT_GT(cell, 100);
  // Edges and, below the drawing, the object's name are of the same colour, and take or add a little.
  EXPECT_NEAR(double(picture.count({0, 114, 178})) / cell, 8, 1.2);
}

} // namespace
} // namespace maille::studies
