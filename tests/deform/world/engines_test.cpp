/// What every engine of a world does, and what the loops of 1995 do beside.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/loops_of_1995.hpp"
#include "support/worlds/worlds.hpp"

namespace maille::deform {
namespace {

using test::box_object;
using test::drive_of;
using test::empty_world;
using test::even_limits;
using test::hold_face;
using test::world_of_1995;

World world_by(const std::string& engine, WorldScene scene) {
  if (engine == "halving" || engine == "sweep" || engine == "hand_on")
    return world_of_1995(engine, std::move(scene));
  scene.method = engine == "limits" || engine == "relaxed" ? engine : "coupled";
  if (engine == "surfaces" || engine == "masses") {
    scene.contact = ContactLaw::surfaces;
    for (WorldObject& object : scene.objects)
      object.scene.limits = {};
  }
  if (engine == "masses")
    scene.dynamics.emplace().damping = 1;
  return World(std::move(scene));
}

/// A held bar, a tool that stands free, and a wall, in cells of 1.
WorldScene workshop() {
  WorldScene scene = empty_world({24, 24}, "coupled");
  scene.objects = {
      box_object("bar", ObjectKind::deformable, {6, 2}, {2.5, 3.5, 0}, even_limits(1.5, 0.6, 0.5)),
      box_object("tool", ObjectKind::rigid, {2, 3}, {8, 12, 0}),
      box_object("wall", ObjectKind::fixed, {1, 6}, {18, 9, 0})};
  hold_face(scene.objects[0], 0, false);
  return scene;
}

Drive of_bar(const Eigen::Vector3d& by) {
  return drive_of(0, by, test::face_nodes(workshop().objects[0], 0, true));
}

class EnginesContract : public testing::TestWithParam<const char*> {
protected:
  World world = world_by(GetParam(), workshop());
  const bool has_masses = std::string(GetParam()) == "masses";
};

// A free way is gone to its end, exactly; a wall stops the tool at its face, or half a cell further where
// cells belong to voxels' middles.
TEST_P(EnginesContract, AToolGoesItsWayAndStopsBeforeAWall) {
  const std::vector free{drive_of(1, {3, -1, 0})};
  const FrameResult gone = world.advance(free);
  EXPECT_EQ(gone.status, Status::done) << gone.message;
  EXPECT_NEAR(gone.drives[0].fraction, 1, 1e-9);
  EXPECT_NEAR(world.pose(1).position[0], 11, 1e-6);
  EXPECT_NEAR(world.pose(1).position[1], 11, 1e-6);
  const std::vector against{drive_of(1, {9, 0, 0})};
  const FrameResult stopped = world.advance(against);
  EXPECT_EQ(stopped.status, Status::clamped) << stopped.message;
  EXPECT_LT(stopped.drives[0].fraction, 0.7);
  EXPECT_GT(world.pose(1).position[0], 15.4);
  EXPECT_LT(world.pose(1).position[0], 16.5 + 1e-9);
  EXPECT_EQ(world.pose(2).position[0], 18);
}

// Handles are where the hand has them, holds where they were, and nothing of the bar is beyond either.
TEST_P(EnginesContract, ABodyFollowsItsHandle) {
  const Drive pull = of_bar({0.4, 0, 0});
  const FrameResult result = world.advance({&pull, 1});
  EXPECT_NEAR(result.drives[0].fraction, 1, 1e-6) << result.message;
  const Grid& grid = world.scene().objects[0].scene.specimen.grid;
  for (int frame = 0; frame < 3; ++frame) {
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const double u = world.displacement(0)(0, node);
      const int along = grid.node_at(node)[0];
      EXPECT_NEAR(along == 0 ? u : 0, 0, 1e-9);
      EXPECT_NEAR(along == 6 ? u : 0.4, 0.4, 1e-6);
      EXPECT_GT(u, has_masses ? -0.1 : -1e-6);
      EXPECT_LT(u, has_masses ? 0.5 : 0.4 + 1e-6);
      EXPECT_NEAR((world.position(0, node) - Eigen::Vector3d(2.5, 3.5, 0))[0] - grid.node_at(node)[0], u,
                  1e-12);
    }
    world.advance({});
  }
}

// Frames without drives settle, where time does not go on.
TEST_P(EnginesContract, WhatIsReleasedComesToRest) {
  const Drive pull = of_bar({0.4, 0, 0});
  world.advance({&pull, 1});
  world.release(0);
  for (int frame = 0; frame < 200 && !world.is_settled(); ++frame)
    world.advance({});
  EXPECT_NE(world.is_settled(), has_masses);
}

TEST_P(EnginesContract, TheSameDrivesGiveTheSameBits) {
  World other = world_by(GetParam(), workshop());
  std::optional<World> copy;
  for (int frame = 0; frame < 4; ++frame) {
    const std::vector drives{of_bar({0.1, 0.05, 0}), drive_of(1, {2.5, -0.5, 0})};
    world.advance(drives);
    other.advance(drives);
    if (copy)
      copy->advance(drives);
    for (World* same : {&other, copy ? &*copy : &other}) {
      EXPECT_EQ(world.displacement(0), same->displacement(0));
      EXPECT_EQ(world.pose(1).position, same->pose(1).position);
      EXPECT_EQ(world.map().n_occupied(), same->map().n_occupied());
    }
    if (frame == 1)
      copy = world.copy();
  }
}

TEST_P(EnginesContract, DrivesThatDoNotFitMoveNothing) {
  Drive of_wall = drive_of(2, {1, 0, 0}), of_none = drive_of(3, {1, 0, 0}), endless = drive_of(1, {1, 0, 0});
  endless.motion.by[1] = std::numeric_limits<double>::infinity();
  for (const Drive& wrong : {of_wall, of_none, endless, drive_of(0, {1, 0, 0}, {1000})}) {
    const std::vector drives{drive_of(1, {1, 0, 0}), wrong};
    EXPECT_THROW(world.advance(drives), std::invalid_argument);
    EXPECT_EQ(world.pose(1).position[0], 8);
  }
}

// Whatever is pushed, and whenever a frame ends, no cell is shared, where cells keep objects apart, and no
// matter is in matter, where the engine promises it.
TEST_P(EnginesContract, NoPushBringsOneIntoAnother) {
  const std::string engine = GetParam();
  for (unsigned seed = 0; seed < 8; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    WorldScene scene = workshop();
    scene.objects.push_back(
        box_object("ball", ObjectKind::deformable, {3, 3}, {11.5, 3.9, 0}, even_limits(1.5, 0.6, 0.4)));
    for (int i = 0; i < 4; ++i)
      scene.objects.push_back(
          box_object("voxel" + std::to_string(i), ObjectKind::rigid, {1, 1}, {3.0 + 3 * i, 18, 0}));
    World pushed = world_by(engine, scene);
    for (int push = 0; push < 16; ++push) {
      Drive drive;
      drive.object = int(random() % 8);
      if (drive.object == 2)
        continue;
      drive.motion.by = 3 * Eigen::Vector3d(unit(random), unit(random), 0);
      if (pushed.kind(drive.object) == ObjectKind::deformable)
        drive.nodes = test::face_nodes(scene.objects[std::size_t(drive.object)], int(random() % 2), true);
      FrameBudget budget;
      budget.rounds = 1 + std::int64_t(random() % 30);
      pushed.advance({&drive, 1}, budget);
      SCOPED_TRACE("world " + std::to_string(seed) + ", push " + std::to_string(push));
      const bool has_surfaces = engine == "surfaces" || engine == "masses";
      ASSERT_EQ(has_surfaces ? 0 : pushed.n_shared_cells(), 0);
      ASSERT_EQ(has_surfaces || engine == "limits" ? pushed.n_penetrations() : 0, 0);
      if (push % 5 == 4)
        pushed.release(drive.object);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Engines, EnginesContract,
                         testing::Values("limits", "relaxed", "coupled", "surfaces", "masses", "halving",
                                         "sweep", "hand_on"),
                         [](const auto& engine) { return std::string(engine.param); });

// Analytic: "the sum of the voxel movements is equal to the desired movement": four voxels in a row, the
// first of which a hand pushes by three cells; before a wall each has half a cell, and the wall refuses the
// rest.
TEST(HandOnAnalytic, ARowHandsOnWhatAHandAsksFor) {
  for (const bool has_wall : {false, true}) {
    WorldScene scene = empty_world({20}, "limits");
    for (int i = 0; i < 4; ++i)
      scene.objects.push_back(
          box_object("voxel" + std::to_string(i), ObjectKind::rigid, {1}, {double(i), 0, 0}));
    if (has_wall)
      scene.objects.push_back(box_object("wall", ObjectKind::fixed, {2}, {4, 0, 0}));
    World world = world_of_1995("hand_on", scene);
    Drive drive = drive_of(0, {3, 0, 0});
    const FrameResult result = world.advance({&drive, 1});
    double sum = 0;
    for (int i = 0; i < 4; ++i)
      sum += world.pose(i).position[0] - i;
    EXPECT_NEAR(sum, has_wall ? 2 : 3, 1e-7);  // a billionth of a cell is kept before every face
    EXPECT_EQ(result.status, Status::clamped); // the first voxel itself came to its face
    EXPECT_NEAR(world.pose(0).position[0], 0.5, 1e-8);
  }
}

// Analytic: at rest every node is the mean of its neighbours. A few sweeps a frame show the way there.
TEST(SweepAnalytic, FramesShowABodyOnItsWayToRest) {
  for (const char* loop : {"sweep", "hand_on"}) {
    WorldScene scene = empty_world({40, 10}, "limits");
    scene.objects = {
        box_object("bar", ObjectKind::deformable, {16, 1}, {4.5, 4.5, 0}, even_limits(2, 0.5, 1))};
    hold_face(scene.objects[0], 0, false);
    scene.objects[0].scene.relaxation.sweeps = 4;
    World world = world_of_1995(loop, scene);
    Drive drive = drive_of(0, {0.8, 0, 0});
    drive.nodes = test::face_nodes(scene.objects[0], 0, true);
    EXPECT_EQ(world.advance({&drive, 1}).status, Status::budget_reached) << loop; // a state on the way
    EXPECT_NEAR(world.displacement(0)(0, 16), 0.8, 1e-9);
    const auto furthest_from_rest = [&] {
      double most = 0;
      for (std::int64_t x = 0; x <= 16; ++x)
        most = std::max(most, std::abs(world.displacement(0)(0, x) - 0.8 * double(x) / 16));
      return most;
    };
    EXPECT_GT(furthest_from_rest(), 0.1) << loop;
    for (int frame = 0; frame < 120; ++frame)
      world.advance({});
    EXPECT_LT(furthest_from_rest(), 0.05) << loop;
    EXPECT_GT(furthest_from_rest(), 0) << loop;
  }
}

} // namespace
} // namespace maille::deform
