/// The smooth surface that voxels stand for.

#include "maille/deform/world/world.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "world/surface/skin.hpp"
#include "world/surface/smooth_surface.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace maille::deform {
namespace {

/// Corners of a body's surface, from its grid's lower corner.
std::vector<Eigen::Vector3d> corners_of(const Specimen& body) {
  const Skin skin(body);
  std::vector<Eigen::Vector3d> corners;
  for (std::int32_t i = 0; i < skin.n_nodes(); ++i) {
    const Index3 at = body.grid.node_at(skin.node(i));
    Eigen::Vector3d corner = Eigen::Vector3d::Zero();
    for (int a = 0; a < body.grid.dimension(); ++a)
      corner[a] = at[static_cast<std::size_t>(a)] * body.grid.spacing()[static_cast<std::size_t>(a)];
    corners.push_back(corner);
  }
  return corners;
}

Specimen rigid_body(const std::string& shape, const std::string& cells) {
  return parse_world_scene(fmt::format("[world]\ncells = [99, 99, 99]\nspacing = \"1 mm\"\ncontact = "
                                       "\"surfaces\"\n[[object]]\nname = \"a\"\nkind = \"rigid\"\nshape = "
                                       "\"{}\"\ncells = [{}]\nspacing = [\"1 mm\", \"2 mm\", \"1 mm\"]\n",
                                       shape, cells))
      .objects[0]
      .scene.specimen;
}

// Analytic: an ellipsoid's equation, also where its box was cut down: no cell's middle is in its last layers.
TEST(SmoothSurfaceAnalytic, CornersOfAnEllipsoidComeToLieOnIt) {
  for (const Vec3& cells : {Vec3{16, 8, 12}, Vec3{60, 4, 4}}) {
    const Specimen body = rigid_body("ellipsoid", fmt::format("{}, {}, {}", cells[0], cells[1], cells[2]));
    std::vector<Eigen::Vector3d> corners = corners_of(body);
    const std::vector<Eigen::Vector3d> before = corners;
    make_smooth(body, corners);
    const Eigen::Vector3d axes(0.5e-3 * cells[0], 1e-3 * cells[1], 0.5e-3 * cells[2]),
        cut = Eigen::Vector3d::Map(body.position({0, 0, 0}).data());
    for (std::size_t i = 0; i < corners.size(); ++i)
      EXPECT_NEAR((corners[i] + cut - axes).cwiseQuotient(axes).norm(), 1, 1e-12);
    EXPECT_LT(body.grid.cells()[0], cells[0] == 60 ? 60 : 17);
    EXPECT_NE(before, corners);
  }
}

// Analytic: a plane of voxels is its own surface; around it edges are rounded.
TEST(SmoothSurfaceAnalytic, FlatFacesStay) {
  Specimen body = rigid_body("box", "15, 15, 15");
  std::vector<Eigen::Vector3d> corners = corners_of(body);
  const std::vector<Eigen::Vector3d> before = corners;
  make_smooth(body, corners);
  std::int64_t inner = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d cells = before[i].cwiseQuotient(Eigen::Vector3d(1e-3, 2e-3, 1e-3));
    int near_edge = 0;
    for (int a = 0; a < 3; ++a)
      near_edge += cells[a] < 6.5 || cells[a] > 8.5;
    if (near_edge == 1) { // in the middle of a face
      EXPECT_LT((corners[i] - before[i]).norm(), 1e-4 * 1e-3);
      ++inner;
    }
    EXPECT_LT((corners[i] - before[i]).cwiseQuotient(Eigen::Vector3d(1e-3, 2e-3, 1e-3)).norm(), 1.001);
  }
  EXPECT_EQ(inner, 6 * 4);
}

// Analytic: a ball's voxels, of which nothing tells that it is one. Corners lie up to 0.9 cells off it.
TEST(SmoothSurfaceAnalytic, VoxelsOfABallComeNearIt) {
  Specimen body = rigid_body("box", "24, 24, 24");
  body.grid = Grid(3, {24, 24, 24}, {1e-3, 1e-3, 1e-3});
  body.material_id.assign(static_cast<std::size_t>(body.grid.n_cells()), no_material);
  const double radius = 10.3e-3;
  const Eigen::Vector3d middle(12.1e-3, 11.8e-3, 12e-3);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const Index3 at = body.grid.cell_at(cell);
    if ((1e-3 * Eigen::Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5) - middle).norm() < radius)
      body.material_id[static_cast<std::size_t>(cell)] = 0;
  }
  std::vector<Eigen::Vector3d> corners = corners_of(body);
  const auto off = [&] { // root of the mean square, in cells
    double sum = 0;
    for (const Eigen::Vector3d& corner : corners)
      sum += std::pow(((corner - middle).norm() - radius) / 1e-3, 2);
    return std::sqrt(sum / static_cast<double>(corners.size()));
  };
  const double before = off();
  make_smooth(body, corners);
  EXPECT_GT(before, 0.35);
  EXPECT_LT(off(), 0.1);
}

} // namespace
} // namespace maille::deform
