/// Fixed, rigid and deformable objects in one map.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/feasible_world.hpp"
#include "support/worlds/worlds.hpp"

namespace maille::deform {
namespace {

using test::box_object;
using test::drive_of;
using test::elastic_object;
using test::empty_world;
using test::even_limits;
using test::expect_feasible;
using test::expect_map_in_step;
using test::face_nodes;
using test::hold_face;

FrameResult advance(World& world, const Drive& drive, const FrameBudget& budget = {}) {
  return world.advance({&drive, 1}, budget);
}

// Analytic: Gibson 1995, figure 7. Pushed, voxels follow at the least separation; pulled, at the largest.
TEST(WorldAnalytic, ABarIsPushedAndPulledAsInFigure7) {
  for (const double step : {0.3, 3.0}) {
    WorldScene scene = empty_world({40}, "limits");
    scene.objects = {box_object("bar", ObjectKind::deformable, {10}, {9.5, 0, 0}, even_limits(1.4, 0.75, 0))};
    World pushed(scene), pulled(scene);
    for (double done = 0; done < 3 - 1e-9; done += step) {
      EXPECT_EQ(advance(pushed, drive_of(0, {step, 0, 0}, {0})).status, Status::done);
      EXPECT_EQ(advance(pulled, drive_of(0, {-step, 0, 0}, {0})).status, Status::done);
    }
    for (int i = 0; i <= 10; ++i) {
      EXPECT_NEAR(pushed.displacement(0)(0, i), std::max(0.0, 3 - 0.25 * i), 1e-12);
      EXPECT_NEAR(pulled.displacement(0)(0, i), -std::max(0.0, 3 - 0.4 * i), 1e-12);
    }
    expect_feasible(pushed);
    expect_map_in_step(pushed);
  }
}

// Analytic: two stiff bars and a wall. All movement that is asked for is made by one bar or the other until
// the wall is met, and not after.
TEST(WorldAnalytic, MovementThatIsHandedOnAddsUp) {
  WorldScene scene = empty_world({30}, "limits");
  scene.objects = {box_object("a", ObjectKind::deformable, {3}, {2.5, 0, 0}),
                   box_object("b", ObjectKind::deformable, {3}, {8.5, 0, 0}),
                   box_object("wall", ObjectKind::fixed, {2}, {20, 0, 0})};
  World world(scene);
  double asked = 0, refused = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const double before = world.position(1, 0)[0];
    const auto result = advance(world, drive_of(0, {0.375, 0, 0}, {0}));
    asked += 0.375;
    double received = 0;
    for (const HandOver& hand_over : result.handed_on) {
      ASSERT_EQ(hand_over.to, 1);
      received += hand_over.moved;
      refused += hand_over.refused();
    }
    ASSERT_NEAR(world.position(1, 0)[0] - before, received, 1e-12);
    expect_feasible(world);
  }
  const double a = world.position(0, 0)[0] - 2.5, b = world.position(1, 0)[0] - 8.5;
  EXPECT_NEAR(a + b + refused, asked, 1e-7); // contacts keep a billionth of a cell each
  EXPECT_GT(refused, 1);
  EXPECT_NEAR(world.position(1, 3)[0], 20, 1e-7); // at the wall
  EXPECT_NEAR(world.position(0, 3)[0], 16,
              1e-7); // at the face of cell 16, which the other's first node is in, just below 17
}

// Analytic: a bar between a held end and a rigid plane, nu = 0: the ramp, and its force E A strain.
TEST(WorldAnalytic, ARigidPlanePressesABarEvenly) {
  for (const char* method : {"coupled", "relaxed"}) {
    WorldScene scene = empty_world({12, 24}, method);
    scene.objects = {elastic_object("bar", {4, 8}, {4, 4, 0}),
                     box_object("plane", ObjectKind::rigid, {10, 2}, {1, 14, 0})};
    scene.objects[0].scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0);
    hold_face(scene.objects[0], 1, false);
    World world(scene);
    for (int frame = 0; frame < 8; ++frame)
      ASSERT_EQ(advance(world, drive_of(1, {0, -0.5, 0})).status, Status::done);
    // The plane's lower voxels have gone from cell 14 to cell 10: the top is at 10, 2 below rest.
    for (int y = 0; y <= 8; ++y)
      EXPECT_NEAR(world.displacement(0)(1, 2 + 5 * y), -0.25 * y, 1e-4); // the method's tolerance
    const auto result = advance(world, drive_of(1, {0, -1e-3, 0}));
    EXPECT_EQ(result.contacts.size(), 5u);
    EXPECT_NEAR(result.drives[0].force[1], -1e4 * 0.25 * 4, 20); // E strain width
    expect_feasible(world);
    // Let go of, it comes back all the way.
    for (int frame = 0; frame < 8; ++frame)
      advance(world, drive_of(1, {0, 0.5, 0}));
    EXPECT_NEAR(world.displacement(0)(1, 2 + 5 * 8), 0, 1e-12);
  }
}

// Analytic: Coulomb. A plane pressed on a bar and shifted along it takes it along up to friction times the
// pressing force, and no further.
TEST(WorldAnalytic, FrictionHoldsUpToItsCoefficient) {
  for (const double friction : {0.0, 0.05, 5.0}) {
    WorldScene scene = empty_world({16, 24}, "coupled");
    scene.friction = friction;
    scene.objects = {elastic_object("bar", {4, 8}, {4.5, 4, 0}),
                     box_object("plane", ObjectKind::rigid, {10, 2}, {1, 14, 0})};
    scene.objects[0].scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0);
    hold_face(scene.objects[0], 1, false);
    World world(scene);
    for (int frame = 0; frame < 4; ++frame)
      ASSERT_EQ(advance(world, drive_of(1, {0, -1, 0})).status, Status::done);
    FrameResult result;
    for (int frame = 0; frame < 4; ++frame) {
      result = advance(world, drive_of(1, {0.25, 0, 0}));
      ASSERT_EQ(result.status, Status::done) << result.message;
      expect_feasible(world);
    }
    const double pressing = -result.drives[0].force[1], along = result.drives[0].force[0];
    const double carried = world.displacement(0)(0, 2 + 5 * 8);
    EXPECT_GT(pressing, 5e3);
    EXPECT_LE(along, friction * pressing * 1.02 + 1e-6);
    if (friction == 0.05) { // the shift of 1 asks for 809 where 500 hold it: slips
      EXPECT_GE(along, friction * pressing * 0.9);
      EXPECT_LT(carried, 0.9);
      EXPECT_GT(carried, 0.01);
    } else
      EXPECT_NEAR(carried, friction > 0 ? 1 : 0, 0.02); // sticks, or feels nothing
  }
}

// Contract: two soft bodies pressed together, as the prototype that Gibson 1995 announces: neither enters the
// other, both yield alike.
TEST(WorldContract, TwoSoftBodiesPressedTogetherYieldAlike) {
  WorldScene scene = empty_world({40, 16}, "coupled");
  scene.objects = {elastic_object("a", {8, 8}, {4.5, 3.5, 0}), elastic_object("b", {8, 8}, {13.5, 3.5, 0})};
  hold_face(scene.objects[1], 0, true);
  World world(scene);
  FrameResult result;
  for (int frame = 0; frame < 8; ++frame) {
    result = advance(world, drive_of(0, {0.5, 0, 0}, face_nodes(scene.objects[0], 0, false)));
    ASSERT_EQ(result.status, Status::done) << result.message;
    ASSERT_LT(result.rounds, 60);
    expect_feasible(world);
    expect_map_in_step(world);
  }
  // 4 of movement less a gap of 1: 3 to be shared. Truth: alike bodies press alike.
  double on_a = 0, on_b = 0;
  for (const WorldContact& contact : result.contacts)
    (contact.object == 0 ? on_a : on_b) += contact.force[0];
  EXPECT_NEAR(on_a, -on_b, 1e-3 * on_b);
  EXPECT_GT(on_b, 1e4);
  const double shortened_a = 8 - (world.position(0, 8)[0] - world.position(0, 0)[0]),
               shortened_b = 8 - (world.position(1, 8)[0] - world.position(1, 0)[0]);
  EXPECT_NEAR(shortened_a, 1.5, 0.01);
  EXPECT_NEAR(shortened_b, 1.5, 0.01);
}

// Contract: a tool goes into a body as far as the limits let it, exactly, and no further.
TEST(WorldContract, LimitsStopARigidTool) {
  WorldScene scene = empty_world({24, 24}, "limits");
  scene.objects = {
      box_object("body", ObjectKind::deformable, {8, 8}, {4.5, 4.5, 0}, even_limits(1.3, 0.75, 0.3)),
      box_object("punch", ObjectKind::rigid, {3, 3}, {6, 14, 0})};
  hold_face(scene.objects[0], 1, false);
  World world(scene);
  FrameResult result;
  for (int frame = 0; frame < 20; ++frame) {
    result = advance(world, drive_of(1, {0, -0.25, 0}));
    expect_feasible(world);
  }
  EXPECT_EQ(result.status, Status::clamped);
  EXPECT_FALSE(result.message.empty());
  // Eight links of 1 - 0.75 below the tool: 2, from 12.5 to 10.5 at most; the tool cannot enter cell 10, its
  // face is at 11.
  EXPECT_NEAR(world.position(0, 9 * 8 + 2)[1], 10.5, 1e-7);
  EXPECT_GT(world.pose(1).position[1], 10.5 - 1e-6); // its lowest centres still in cell 11
}

// Contract: dense regions. Many nodes share a cell, the map keeps in step, and who enters the cell moves them
// all.
TEST(WorldContract, NodesThatShareACellArePushedTogether) {
  WorldScene scene = empty_world({12, 12}, "limits");
  scene.objects = {
      box_object("fine", ObjectKind::deformable, {8, 8}, {4.1, 4.1, 0}, even_limits(1.5, 0.5, 0.5)),
      box_object("tool", ObjectKind::rigid, {2, 4}, {0, 4, 0})};
  scene.objects[0].scene.specimen.grid = Grid(2, {8, 8, 1}, {0.25, 0.25, 1}); // 16 nodes a cell
  World world(scene);
  int n_in_cell = 0;
  for (std::int64_t node = 0; node < 81; ++node)
    n_in_cell += (world.position(0, node).array().head(2).floor() == 4).all();
  EXPECT_EQ(n_in_cell, 16);
  expect_map_in_step(world);
  for (int frame = 0; frame < 12; ++frame) {
    advance(world, drive_of(1, {0.4, 0.05, 0}));
    expect_feasible(world);
    expect_map_in_step(world);
  }
  EXPECT_GT(world.position(0, 0)[0], 5); // it has been pushed along
}

// Contract: whatever ends a frame, the state is feasible, and a frame with all the time settles
// what was left.
TEST(WorldContract, AFrameMayEndAtAnyTime) {
  WorldScene scene = empty_world({40, 16}, "coupled");
  scene.objects = {elastic_object("a", {8, 8}, {4.5, 3.5, 0}), elastic_object("b", {8, 8}, {13.5, 3.5, 0})};
  hold_face(scene.objects[1], 0, true);
  const auto left = face_nodes(scene.objects[0], 0, false);
  for (int rounds = 1; rounds < 12; ++rounds) {
    World world(scene);
    FrameBudget budget;
    budget.rounds = rounds;
    const auto result = advance(world, drive_of(0, {4, 0.75, 0}, left), budget);
    ASSERT_EQ(result.status, Status::budget_reached);
    ASSERT_LE(result.rounds, rounds);
    expect_feasible(world);
    for (int frame = 0; frame < 10; ++frame) {
      advance(world, drive_of(0, {0.1, 0, 0}, left), budget);
      expect_feasible(world);
    }
    EXPECT_EQ(world.advance({}).status, Status::done); // with all the time
    EXPECT_EQ(world.advance({}).rounds, 0);            // nothing is left to do
    expect_feasible(world);
  }
  World world(scene);
  FrameBudget budget;
  budget.stop_requested = [] { return true; };
  EXPECT_EQ(advance(world, drive_of(0, {4, 0, 0}, left), budget).status, Status::interrupted);
  budget = {};
  budget.seconds = 0;
  EXPECT_EQ(advance(world, drive_of(0, {4, 0, 0}, left), budget).status, Status::budget_reached);
  EXPECT_EQ(world.displacement(0)(0, 0), 0);
}

TEST(WorldContract, AFreeRigidObjectIsPushed) {
  WorldScene scene = empty_world({30, 6}, "limits");
  scene.objects = {box_object("hand", ObjectKind::rigid, {2, 2}, {1, 2, 0}),
                   box_object("first", ObjectKind::rigid, {2, 2}, {5, 2, 0}),
                   box_object("second", ObjectKind::rigid, {2, 2}, {10, 2, 0}),
                   box_object("wall", ObjectKind::fixed, {1, 6}, {20, 0, 0})};
  World world(scene);
  for (int frame = 0; frame < 10; ++frame) {
    advance(world, drive_of(0, {3.5, 0, 0}));
    expect_feasible(world);
  }
  // Three objects of two cells before the wall at 20; centres may come up to half a cell nearer than faces.
  EXPECT_NEAR(world.pose(2).position[0], 18.5, 1.01);
  EXPECT_NEAR(world.pose(0).position[0], 14.5, 1.51);
  // A driven object stays in place until it is released.
  const double before = world.pose(0).position[0];
  advance(world, drive_of(1, {-3, 0, 0}));
  EXPECT_EQ(world.pose(0).position[0], before);
  world.release(0);
  advance(world, drive_of(1, {-3, 0, 0}));
  EXPECT_LT(world.pose(0).position[0], before - 2);
}

TEST(WorldContract, ScenesThatCannotBeMovedAreRefused) {
  WorldScene scene = empty_world({12, 12}, "limits");
  scene.objects = {
      box_object("body", ObjectKind::deformable, {2, 2}, {2.5, 2.5, 0}, even_limits(1.2, 0.8, 0.1)),
      box_object("wall", ObjectKind::fixed, {1, 1}, {8, 8, 0})};
  WorldScene bad = scene;
  bad.objects[1].position = {3, 3, 0};
  EXPECT_THROW(World{bad}, std::invalid_argument);
  bad = scene;
  bad.objects[0].scene.limits = {}; // taut
  EXPECT_THROW(World{bad}, std::invalid_argument);
  bad = scene;
  bad.method = "fem_q1";
  EXPECT_THROW(World{bad}, std::invalid_argument);
  bad = scene;
  test::prescribe(bad.objects[0].scene, 0, 0, 1, false);
  EXPECT_THROW(World{bad}, std::invalid_argument);
}

/// Bodies that nothing holds, one on another, pressed to the floor until their limits stop the tool.
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

/// Bodies whose nodes stand closer than the world's cells: pushed by a rigid tool as bodies of the world's
/// own spacing are.

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
  for (std::size_t a = 0; a < std::size_t(dimension); ++a) {
    cells[a] = int(std::lround(edge / spacing));
    spacings[a] = edge / double(cells[a]);
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
  Drive drive = drive_of(1, {0.4, world.scene().dimension > 1 ? 0.4 * tool.aside : 0, 0});
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
TEST(FineBodiesConsistent, AHeldBodyStopsTheToolWhereOneOfTheWorldsSpacingDoes) {
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

/// Soft bodies whose nodes stand further apart than the world's cells: between its nodes a body is as solid
/// as at them.

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
  Drive drive = drive_of(1, {0.4, 0, 0});
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
    for (std::size_t a = 1; a < std::size_t(dimension); ++a) {
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
  Drive drive = drive_of(1, {0, 0, -3});
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
                                  std::to_string(int(one.param.spacing));
                         });

} // namespace
} // namespace maille::deform
