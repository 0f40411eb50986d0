/// Gibson's own loops in worlds: halved steps, and bodies that are on their way to rest.

#include "maille/deform/world/world.hpp"
#include "support/worlds/worlds.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille::deform {
namespace {

using tests::box_object;
using tests::empty_world;
using tests::hold_face;

// Analytic: voxels' middles at 3.5 + x before a wall whose first cell is 8: free while x < 4.5. The frame
// goes in 10 steps of a cell; the fifth is halved until it is free.
TEST(OldLoopsAnalytic, ABlockedStepIsHalvedWithoutPushing) {
  WorldScene scene = empty_world({20, 5}, "coupled");
  scene.contact = ContactLaw::halving;
  scene.objects = {box_object("tool", ObjectKind::rigid, {2, 2}, {2, 1, 0}),
                   box_object("free", ObjectKind::rigid, {1, 2}, {8, 1, 0})};
  World world(scene);
  Drive drive;
  drive.object = 0;
  drive.motion.by = {10, 0, 0};
  const FrameResult result = world.advance({&drive, 1});
  EXPECT_EQ(result.status, Status::clamped);
  const double x = world.pose(0).position[0] - 2;
  EXPECT_NEAR(x, 4 + 0.5 * (1 - 1.0 / 64), 1e-12); // steps 5 to 10, each half of what is left
  EXPECT_EQ(world.pose(1).position[0], 8);
  EXPECT_EQ(world.n_shared_cells(), 0);
}

// Analytic: at rest every node is the mean of its neighbours, so a bar that is pulled is stretched evenly; a
// few sweeps a frame show the way there, frame by frame.
TEST(OldLoopsAnalytic, FramesShowABodyOnItsWayToRest) {
  WorldScene scene = empty_world({40, 10}, "sweep");
  scene.objects = {
      box_object("bar", ObjectKind::deformable, {16, 1}, {4.5, 4.5, 0}, tests::even_limits(2, 0.5, 1))};
  hold_face(scene.objects[0], 0, false);
  scene.objects[0].scene.relaxation.sweeps = 4;
  World world(scene);
  Drive drive;
  drive.object = 0;
  drive.motion.by = {0.8, 0, 0};
  drive.nodes = tests::face_nodes(scene.objects[0], 0, true);
  EXPECT_EQ(world.advance({&drive, 1}).status, Status::budget_reached); // a state on the way
  const auto furthest_from_rest = [&] {
    double most = 0;
    for (std::int64_t x = 0; x <= 16; ++x)
      most = std::max(most, std::abs(world.displacement(0)(0, x) - 0.8 * static_cast<double>(x) / 16));
    return most;
  };
  double before = furthest_from_rest();
  EXPECT_GT(before, 0.1); // a handle alone has moved, and what limits and few sweeps took along
  for (int frame = 0; frame < 120; ++frame) {
    world.advance({});
    const double now = furthest_from_rest();
    EXPECT_LE(now, before * (1 + 1e-9)) << "frame " << frame;
    before = now;
    EXPECT_EQ(world.n_shared_cells(), 0);
  }
  EXPECT_LT(before, 1e-2);
  EXPECT_GT(before, 0);
}

} // namespace
} // namespace maille::deform
