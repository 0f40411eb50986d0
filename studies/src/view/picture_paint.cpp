// Colour pictures on the cells of bodies.

#include "maille/materials/fault.hpp"
#include "picture/read_picture.hpp"
#include "view/seen_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>

namespace maille::studies {

std::shared_ptr<const render::Paint> paint_of_picture(const Specimen& body, const Look& look) {
  ColourPicture picture = read_picture(look.picture);
  const Vec3& h = body.grid.spacing();
  std::array<double, 2> pixel{look.pixel, look.pixel};
  if (look.pixel == 0)
    pixel = {h[0], h[1]};
  const std::array<int, 2> size{picture.width, picture.height};
  constexpr double rounding = 1e-6; // of a pixel
  std::array<double, 2> low{}, high{};
  bool reaches = true;
  for (std::size_t a = 0; a < 2; ++a) {
    low[a] = body.origin[a] / pixel[a];
    high[a] = (body.origin[a] + body.grid.cells()[a] * h[a]) / pixel[a];
    reaches = reaches && low[a] >= -rounding && high[a] <= size[a] + rounding;
  }
  if (!reaches)
    throw InputError({{look.picture, 0, "picture",
                       fmt::format("pixels from {:.6g}, {:.6g} to {:.6g}, {:.6g}, over which the body lies",
                                   low[0], low[1], high[0], high[1]),
                       fmt::format("{} x {} pixels", size[0], size[1])}});
  render::VoxelGrid grid;
  grid.size = {size[0], size[1], 1};
  grid.spacing = {pixel[0], pixel[1], h[2]};
  grid.origin = {0.5 * pixel[0], 0.5 * pixel[1], body.origin[2] + 0.5 * h[2]};
  const auto row = static_cast<std::ptrdiff_t>(3) * size[0];
  const auto begin = picture.rgb.begin();
  for (int y = 0; y < size[1] / 2; ++y) // rows upwards, as y goes
    std::swap_ranges(begin + row * y, begin + row * (y + 1), begin + row * (size[1] - 1 - y));
  return render::Paint::picture(grid, picture.rgb);
}

} // namespace maille::studies
