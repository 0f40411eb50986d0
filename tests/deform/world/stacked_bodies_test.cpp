/// Bodies that nothing holds, one on another, pressed to the floor until their limits stop the tool.

#include "maille/deform/world/world.hpp"
#include "support/worlds/feasible_world.hpp"
#include "support/worlds/worlds.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using namespace tests;

class StackedBodiesAnalytic : public testing::TestWithParam<const char*> {};

// Analytic: a body of six links of 0.7 is 4.2 high at least. The lower one stands on the floor, so its top
// comes to 4.2, in cell 4; the upper one stands on the face at 5, so its top comes to 9.2, in cell 9. The
// tool's lowest centres stop at 10.
TEST_P(StackedBodiesAnalytic, EachHandsOnWhatItCannotTake) {
  WorldScene scene = empty_world({12, 24}, GetParam());
  const NeighbourLimits limits = even_limits(1.3, 0.7, 0.3);
  scene.objects = {box_object("lower", ObjectKind::deformable, {6, 6}, {2.5, 1.5, 0}, limits),
                   box_object("upper", ObjectKind::deformable, {6, 6}, {2.5, 9.5, 0}, limits),
                   box_object("tool", ObjectKind::rigid, {10, 2}, {1, 20, 0})};
  World world(scene);
  Drive down;
  down.object = 2;
  down.motion.by = {0, -0.25, 0};
  FrameResult result;
  for (int frame = 0; frame < 60; ++frame) {
    result = world.advance({&down, 1});
    expect_feasible(world);
  }
  EXPECT_EQ(result.status, Status::clamped); // 15 would be too much
  EXPECT_NEAR(world.pose(2).position[1], 9.5, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Methods, StackedBodiesAnalytic, testing::Values("coupled", "relaxed", "limits"),
                         [](const auto& method) { return std::string(method.param); });

} // namespace
} // namespace maille::deform
