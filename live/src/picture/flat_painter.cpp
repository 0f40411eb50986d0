/// 2D worlds from above: each pixel belongs to the object at its position, with cells drawn deformed.

#include "maille/live/picture.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

constexpr std::array<std::uint8_t, 3> ground{250, 248, 244}, beyond{206, 204, 200};
/// Colours of objects in turn; walls are grey.
constexpr std::array<std::array<float, 3>, 8> colours{{{0.85f, 0.37f, 0.22f},
                                                       {0.20f, 0.47f, 0.70f},
                                                       {0.33f, 0.62f, 0.29f},
                                                       {0.58f, 0.40f, 0.70f},
                                                       {0.90f, 0.67f, 0.20f},
                                                       {0.30f, 0.66f, 0.66f},
                                                       {0.78f, 0.44f, 0.60f},
                                                       {0.55f, 0.45f, 0.33f}}};
constexpr std::array<float, 3> grey{0.42f, 0.42f, 0.44f};

struct Canvas {
  int width, height;
  std::vector<std::uint8_t> rgba;
  std::vector<std::int32_t> object;

  void put(int x, int y, int of, const std::array<float, 3>& colour) {
    const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
    for (std::size_t c = 0; c < 3; ++c)
      rgba[4 * pixel + c] = static_cast<std::uint8_t>(std::clamp(255 * colour[c], 0.0f, 255.0f));
    object[pixel] = of;
  }
};

/// From the world to pixels and back.
struct Mapping {
  double scale, left, top; ///< pixels per metre; world position of the picture's upper left corner
  Mapping(const Looking& looking, int width, int height) {
    scale = height / looking.height;
    left = looking.middle[0] - 0.5 * width / scale;
    top = looking.middle[1] + 0.5 * looking.height;
  }
  double x(double world) const { return (world - left) * scale; }
  double y(double world) const { return (top - world) * scale; }
  double world_x(double x) const { return left + x / scale; }
  double world_y(double y) const { return top - y / scale; }
};

std::array<float, 3> shaded(std::array<float, 3> colour, float light) {
  for (float& c : colour)
    c *= light;
  return colour;
}

/// Quadrilateral of a cell in the picture, corners in order.
using Corners = std::array<Eigen::Vector2d, 4>;

/// Calls visit(x, y) for pixels with centres in a convex or mildly concave quadrilateral.
template<class Visit>
void for_each_pixel(const Corners& corners, const Canvas& canvas, Visit&& visit) {
  Eigen::Vector2d low = corners[0], high = corners[0];
  for (const Eigen::Vector2d& corner : corners) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  if (!low.allFinite() || !high.allFinite())
    return;
  const int first_x = static_cast<int>(std::clamp(std::floor(low[0]), 0.0, 1.0 * canvas.width)),
            last_x = static_cast<int>(std::clamp(std::ceil(high[0]), -1.0, canvas.width - 1.0)),
            first_y = static_cast<int>(std::clamp(std::floor(low[1]), 0.0, 1.0 * canvas.height)),
            last_y = static_cast<int>(std::clamp(std::ceil(high[1]), -1.0, canvas.height - 1.0));
  for (int y = first_y; y <= last_y; ++y)
    for (int x = first_x; x <= last_x; ++x) {
      bool is_in = false; // by the crossings of a ray to the right
      const double px = x + 0.5, py = y + 0.5;
      for (std::size_t i = 0, j = 3; i < 4; j = i++)
        if ((corners[i][1] > py) != (corners[j][1] > py) &&
            px < (corners[j][0] - corners[i][0]) * (py - corners[i][1]) / (corners[j][1] - corners[i][1]) +
                     corners[i][0])
          is_in = !is_in;
      if (is_in)
        visit(x, y);
    }
}

class FlatPainter : public Painter {
public:
  Painted paint(const WorldScene& scene, const WorldState& state, const Looking& looking) override {
    Painted painted;
    painted.width = looking.view.width;
    painted.height = looking.view.height;
    const std::size_t pixels = static_cast<std::size_t>(painted.width) * painted.height;
    Canvas canvas{painted.width, painted.height, std::vector<std::uint8_t>(4 * pixels),
                  std::vector<std::int32_t>(pixels, -1)};
    const Mapping mapping(looking, painted.width, painted.height);
    draw_ground(scene, mapping, canvas);
    int colour = 0;
    for (std::size_t object = 0; object < scene.objects.size(); ++object) {
      const bool is_fixed = scene.objects[object].kind == ObjectKind::fixed;
      draw(scene.objects[object], state, object, is_fixed ? grey : colours[colour % 8], looking, mapping,
           canvas);
      colour += is_fixed ? 0 : 1;
    }
    painted.rgba = std::make_shared<const std::vector<std::uint8_t>>(std::move(canvas.rgba));
    painted.object = std::move(canvas.object);
    return painted;
  }

private:
  static void draw_ground(const WorldScene& scene, const Mapping& mapping, Canvas& canvas) {
    const double right = scene.cells[0] * scene.spacing[0], top = scene.cells[1] * scene.spacing[1];
    for (int y = 0; y < canvas.height; ++y)
      for (int x = 0; x < canvas.width; ++x) {
        const double wx = mapping.world_x(x + 0.5), wy = mapping.world_y(y + 0.5);
        const bool is_in =
            scene.is_open || (wx >= 0 && wx < right && (scene.dimension < 2 || (wy >= 0 && wy < top)));
        const auto& colour = is_in ? ground : beyond;
        std::uint8_t* const at = canvas.rgba.data() + 4 * (static_cast<std::size_t>(y) * canvas.width + x);
        std::copy(colour.begin(), colour.end(), at);
        at[3] = 255;
      }
  }

  static void draw(const WorldObject& object, const WorldState& state, std::size_t number,
                   const std::array<float, 3>& colour, const Looking& looking, const Mapping& mapping,
                   Canvas& canvas) {
    const Specimen& body = object.scene.specimen;
    const Grid& grid = body.grid;
    const deform::Pose& frame = state.frames[number];
    const Displacement* const by = state.displacements[number].get();
    const bool has_field = looking.field && looking.field->object == static_cast<int>(number) &&
                           looking.field->of_cells.size() == static_cast<std::size_t>(grid.n_cells());
    const std::vector<Rgb> palette = has_field ? render::field_colours() : std::vector<Rgb>{};
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
      if (!body.is_matter(cell))
        continue;
      const Index3 at = grid.cell_at(cell);
      Corners corners;
      constexpr std::array<std::array<int, 2>, 4> around{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
      for (std::size_t i = 0; i < 4; ++i) {
        const Index3 node{at[0] + around[i][0], at[1] + (grid.dimension() > 1 ? around[i][1] : 0), 0};
        Vec3 x = body.position(node);
        if (by != nullptr) {
          const Vec3 u = by->at(grid.node(node));
          for (std::size_t a = 0; a < 3; ++a)
            x[a] += u[a];
        }
        if (grid.dimension() < 2) // a bar is drawn four spacings high
          x[1] = (around[i][1] - 0.5) * 4 * grid.spacing()[0];
        const Eigen::Vector3d w = frame.position + frame.rotation * Eigen::Vector3d(x[0], x[1], x[2]);
        corners[i] = {mapping.x(w[0]), mapping.y(w[1])};
      }
      // Two shades of cells show rotation and deformation of an object; each material has its own colour.
      const int shade = (at[0] + at[1]) & 1;
      std::array<float, 3> own =
          shaded(colour, (shade ? 1.0f : 0.94f) * (1 - 0.18f * static_cast<float>(body.material(cell) % 4)));
      if (has_field) {
        const double value = (looking.field->of_cells[cell] - looking.field->low) /
                             std::max(1e-300, looking.field->high - looking.field->low);
        own = palette[static_cast<std::size_t>(std::clamp(value, 0.0, 1.0) *
                                               static_cast<double>(palette.size() - 1))];
      }
      for_each_pixel(corners, canvas, [&](int x, int y) { canvas.put(x, y, static_cast<int>(number), own); });
    }
  }
};

} // namespace

std::unique_ptr<Painter> flat_painter() {
  return std::make_unique<FlatPainter>();
}

std::array<double, 2> flat_place(const Looking& looking, double aspect, const Vec3& world) {
  return {0.5 + (world[0] - looking.middle[0]) / (looking.height * aspect),
          0.5 - (world[1] - looking.middle[1]) / looking.height};
}

Vec3 flat_point(const Looking& looking, double aspect, double x, double y) {
  return {looking.middle[0] + (x - 0.5) * looking.height * aspect,
          looking.middle[1] - (y - 0.5) * looking.height, 0};
}

Looking flat_looking(const WorldScene& scene, double aspect) {
  Looking looking;
  Vec3 low{}, high{};
  for (std::size_t a = 0; a < 2; ++a) {
    if (scene.is_open) {
      const Specimen& body = scene.objects.front().scene.specimen;
      const double size = body.grid.cells()[a] * body.grid.spacing()[a];
      low[a] = body.origin[a] - 0.4 * size;
      high[a] = body.origin[a] + 1.4 * size;
    } else if (a < static_cast<std::size_t>(scene.dimension)) {
      high[a] = scene.cells[a] * scene.spacing[a];
    }
    looking.middle[a] = 0.5 * (low[a] + high[a]);
  }
  looking.height = 1.04 * std::max(high[1] - low[1], (high[0] - low[0]) / aspect);
  return looking;
}

} // namespace maille::live
