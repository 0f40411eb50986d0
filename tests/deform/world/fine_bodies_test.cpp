/// Bodies whose nodes stand closer than the world's cells: pushed by a rigid tool as bodies of the world's
/// own spacing are.

#include "maille/deform/world/world.hpp"
#include "support/worlds/worlds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace maille::deform {
namespace {

using tests::box_object;
using tests::empty_world;
using tests::even_limits;
using tests::hold_face;

constexpr int edge = 3; ///< of the body [cells of the world]

/// How a tool meets the body, which lies at (5.1, 4.1, 4.2).
struct Tool {
  int width;    ///< [cells]
  double at;    ///< along y and z, its lowest corner
  double aside; ///< of a push along x by 1, along y
};
/// Wider than the body, one cell in its middle, over an edge and a little upwards.
constexpr Tool tools[] = {{6, 3, 0}, {1, 5, 0}, {3, 2, 0.075}};

/// @param has_limits none: elasticity alone, taut limits @param is_held at the face behind
World world_of(int dimension, const char* method, double spacing, const Tool& tool, bool has_limits,
               bool is_held) {
  WorldScene scene = empty_world({34}, method);
  scene.dimension = dimension;
  Index3 cells{1, 1, 1}, of_tool{2, 1, 1};
  Vec3 spacings{1, 1, 1}, at_body{5.1, 0, 0}, at_tool{1, 0, 0};
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a) {
    cells[a] = static_cast<int>(std::lround(edge / spacing));
    spacings[a] = edge / static_cast<double>(cells[a]);
    if (a == 0)
      continue;
    scene.cells[a] = 14;
    at_body[a] = a == 1 ? 4.1 : 4.2;
    of_tool[a] = tool.width;
    at_tool[a] = tool.at;
  }
  scene.objects = {box_object("body", ObjectKind::deformable, {1}, at_body, even_limits(1.5, 0.5, 0.5)),
                   box_object("tool", ObjectKind::rigid, {1}, at_tool)};
  scene.objects[0].scene.specimen.grid = Grid(dimension, cells, spacings);
  scene.objects[1].scene.specimen.grid = Grid(dimension, of_tool, {1, 1, 1});
  if (!has_limits)
    scene.objects[0].scene.limits = {};
  if (is_held)
    hold_face(scene.objects[0], 0, true);
  return World(std::move(scene));
}

/// Pushes by steps that are no part of a cell. @return along x
double push(World& world, const Tool& tool, int frames) {
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0.4, world.scene().dimension > 1 ? 0.4 * tool.aside : 0, 0};
  const double begin = world.pose(1).position[0];
  for (int frame = 0; frame < frames; ++frame) {
    const FrameResult result = world.advance({&drive, 1});
    EXPECT_EQ(world.n_penetrations(), 0);
    EXPECT_LT(world.largest_violation(), 1e-12);
    EXPECT_LT(result.rounds, 300);
  }
  return world.pose(1).position[0] - begin;
}

class FineBodiesAnalytic : public testing::TestWithParam<const char*> {};

// Analytic: nothing keeps a body that is free, so the tool goes all of its way and takes the body along.
TEST_P(FineBodiesAnalytic, AFreeBodyIsPushedAsFarAsTheToolGoes) {
  constexpr int frames = 40;
  for (const int dimension : {1, 2, 3})
    for (const double spacing : {1.0, 0.75, 0.5, 0.25})
      for (const Tool& tool : tools)
        for (const bool has_limits : {true, false}) {
          if ((dimension == 3 && spacing < 0.5) || (dimension == 1 && &tool != tools) ||
              (!has_limits && std::string(GetParam()) == "limits"))
            continue;
          SCOPED_TRACE(testing::Message() << dimension << "D, spacing " << spacing << ", tool of "
                                          << tool.width << (has_limits ? ", limits" : ", elastic"));
          World world = world_of(dimension, GetParam(), spacing, tool, has_limits, false);
          ASSERT_NEAR(push(world, tool, frames), 0.4 * frames, 1e-9);
          // The first node was at 5.1, and the tool's front has come from cell 2 to cell 18: 19 - 5.1, and no
          // more than the skin and what a step of a cell may have pushed it further.
          const double most = std::ranges::max(world.displacement(0).component(0));
          EXPECT_GT(most, 13.9 - 1e-6);
          EXPECT_LT(most, 13.9 + 1);
        }
}

INSTANTIATE_TEST_SUITE_P(Methods, FineBodiesAnalytic, testing::Values("limits", "coupled", "relaxed"),
                         [](const auto& method) { return std::string(method.param); });

// Oracle: the body of the world's own spacing. The limits let either be shortened by half, 1.5 of the 1.9
// that a second cell would take.
TEST(FineBodiesOracle, AHeldBodyStopsTheToolWhereOneOfTheWorldsSpacingDoes) {
  for (const int dimension : {1, 2, 3}) {
    World coarse = world_of(dimension, "limits", 1, tools[0], true, true);
    const double expected = push(coarse, tools[0], 16);
    EXPECT_NEAR(
        expected, 3.5,
        1e-6); // Analytic: the tool's front is at the face of cell 6, which the node 1.5 further is in
    for (const char* method : {"limits", "coupled"})
      for (const double spacing : {0.75, 0.5, 0.375}) {
        if (dimension == 3 && spacing < 0.5)
          continue;
        SCOPED_TRACE(testing::Message() << dimension << "D, spacing " << spacing << ", " << method);
        World fine = world_of(dimension, method, spacing, tools[0], true, true);
        EXPECT_NEAR(push(fine, tools[0], 16), expected, 1e-6);
      }
  }
}

} // namespace
} // namespace maille::deform
