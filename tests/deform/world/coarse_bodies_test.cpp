/// Soft bodies whose nodes stand further apart than the world's cells: between its nodes a body is as solid
/// as at them.

#include "maille/deform/world/world.hpp"
#include "support/worlds/worlds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace maille::deform {
namespace {

using tests::box_object;
using tests::empty_world;
using tests::even_limits;
using tests::hold_face;

/// A body that is held behind, and a tip of one voxel.
std::vector<WorldObject> body_and_tip(const Vec3& at_body, const Grid& grid, const NeighbourLimits& limits,
                                      const Vec3& at_tip) {
  std::vector<WorldObject> objects{box_object("body", ObjectKind::deformable, {1}, at_body, limits),
                                   box_object("tip", ObjectKind::rigid, {1}, at_tip)};
  objects[0].scene.specimen.grid = grid;
  objects[1].scene.specimen.grid = Grid(grid.dimension(), {1, 1, 1}, {1, 1, 1});
  hold_face(objects[0], 0, true);
  return objects;
}

/// Pushes the tip along x; in no frame does matter stand in matter.
void push_tip(World& world, int frames) {
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0.4, 0, 0};
  for (int frame = 0; frame < frames; ++frame) {
    world.advance({&drive, 1});
    ASSERT_EQ(world.n_penetrations(), 0) << "frame " << frame;
    ASSERT_EQ(world.n_shared_cells(), 0) << "frame " << frame;
  }
}

struct Kind {
  int dimension;
  double spacing; ///< of the body [cells of the world]
  const char* method;
};

class CoarseBodiesContract : public testing::TestWithParam<Kind> {};

// Contract: a tool of one voxel, aimed at any place between the nodes of a body that is held behind, stops
// within what the limits let the body be shortened by, and never stands in its matter, by the geometry of its
// hexahedra.
TEST_P(CoarseBodiesContract, ATipIsStoppedBetweenTheNodes) {
  const auto& [dimension, spacing, method] = GetParam();
  constexpr int n_cells = 3;
  const int n_frames = std::string(method) == "coupled" ? 25 : 80;
  for (const double aside : {0.0, 1.0, 2.0, 3.5}) {
    SCOPED_TRACE(testing::Message() << "tip at " << aside);
    WorldScene scene = empty_world({40}, method);
    scene.dimension = dimension;
    Index3 cells{n_cells, 1, 1};
    Vec3 spacings{spacing, 1, 1}, at_body{6.1, 0, 0}, at_tip{1, 0, 0};
    for (std::size_t a = 1; a < static_cast<std::size_t>(dimension); ++a) {
      scene.cells[a] = 20;
      cells[a] = n_cells;
      spacings[a] = spacing;
      at_body[a] = 4.1;
      at_tip[a] = 5 + aside;
    }
    scene.objects =
        body_and_tip(at_body, Grid(dimension, cells, spacings), even_limits(1.5, 0.5, 0.5), at_tip);
    World world(std::move(scene));
    ASSERT_NO_FATAL_FAILURE(push_tip(world, n_frames));
    const double tip = world.pose(1).position[0] + 1, behind = 6.1 + n_cells * spacing;
    EXPECT_GT(tip, 5) << "it comes to the body";
    EXPECT_LT(tip, behind - 0.5 * n_cells * spacing + 1) << "half of the body stays behind it, to a cell";
  }
}

// Contract: the same of a body that lies turned; beside its geometry, that the tip never comes out behind it.
TEST(TurnedBodiesContract, ATipIsStoppedByTheFlankOfATurnedBody) {
  for (const int dimension : {2, 3})
    for (const double angle : {0.3, 0.25 * std::numbers::pi})
      for (const double aside : {0.0, 1.3, 2.6}) {
        SCOPED_TRACE(testing::Message() << dimension << "D, turned by " << angle << ", tip at " << aside);
        WorldScene scene = empty_world({30}, "limits");
        scene.dimension = dimension;
        Index3 cells{4, 4, 1};
        Vec3 spacings{2, 2, 1}, at_body{12, 8, 0}, at_tip{1, 11 + aside, 0};
        scene.cells[1] = 30;
        if (dimension == 3) {
          scene.cells[2] = 10;
          cells[2] = 3;
          spacings[2] = 2;
          at_body[2] = 2.1;
          at_tip[2] = 4.5;
        }
        scene.objects =
            body_and_tip(at_body, Grid(dimension, cells, spacings), even_limits(1.2, 0.8, 0.2), at_tip);
        scene.objects[0].turn_angle = angle;
        World world(std::move(scene));
        ASSERT_NO_FATAL_FAILURE(push_tip(world, 60));
        const double tip = world.pose(1).position[0];
        EXPECT_GT(tip, 5) << "it comes to the body";
        EXPECT_LT(tip, 18) << "it would have come to 25";
      }
}

// Contract: nodes beside those that make way for a tool come into its way themselves. They are asked while
// the others stay out; asked by themselves they went, the others came back, and the tool stood still.
TEST(PunchContract, WhoComesIntoTheWayBesideAPunchMakesWayToo) {
  World world(parse_world_scene("units = \"m\"\n[world]\ncells = [120, 120, 192]\nspacing = 1\n"
                                "[[object]]\nname = \"block\"\nkind = \"deformable\"\nshape = \"box\"\n"
                                "cells = [18, 18, 24]\nspacing = 4\n"
                                "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
                                "hold = [{ where = \"z-\" }, { where = \"x-\", axes = \"x\" }, "
                                "{ where = \"y-\", axes = \"y\" }]\nposition = [43.2, 43.2, 25.2]\n"
                                "[[object]]\nname = \"punch\"\nkind = \"rigid\"\nshape = \"box\"\n"
                                "cells = [60, 60, 3]\nposition = [12, 12, 123]\n"));
  Drive drive;
  drive.object = 1;
  drive.motion.by = {0, 0, -3};
  const FrameResult result = world.advance({&drive, 1});
  EXPECT_EQ(result.status, Status::done) << result.message;
  EXPECT_NEAR(world.pose(1).position[2], 120, 1e-9);
  EXPECT_LT(result.rounds, 40);
  EXPECT_EQ(world.n_penetrations(), 0);
}

INSTANTIATE_TEST_SUITE_P(Bodies, CoarseBodiesContract,
                         testing::Values(Kind{1, 3, "limits"}, Kind{2, 2, "limits"}, Kind{2, 3, "limits"},
                                         Kind{3, 2, "limits"}, Kind{2, 3, "coupled"}, Kind{3, 2, "coupled"}),
                         [](const auto& one) {
                           return std::string(one.param.method) + "_in_" +
                                  std::to_string(one.param.dimension) + "d_of_" +
                                  std::to_string(static_cast<int>(one.param.spacing));
                         });

} // namespace
} // namespace maille::deform
