/// Worlds whose voxels hand on what they cannot move, one after another.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/random_worlds.hpp"
#include "support/worlds/worlds.hpp"

namespace maille::deform {
namespace {

using test::box_object;
using test::empty_world;
using test::even_limits;
using test::hold_face;

/// No cell has two nodes or voxels, counted anew from where they are.
void expect_a_cell_each(const World& world) {
  std::set<Index3> taken;
  const auto take = [&](const Eigen::Vector3d& at) {
    Index3 cell{};
    for (int a = 0; a < world.scene().dimension; ++a)
      cell[std::size_t(a)] = int(std::floor(at[a] / world.cell_size()[std::size_t(a)]));
    ASSERT_TRUE(world.map().has_cell(cell));
    ASSERT_TRUE(taken.insert(cell).second) << "two voxels in one cell";
  };
  for (int object = 0; object < world.n_objects(); ++object) {
    if (world.kind(object) == ObjectKind::deformable) {
      const Grid& grid = world.scene().objects[std::size_t(object)].scene.specimen.grid;
      for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
        take(world.position(object, node));
      continue;
    }
    for (std::int32_t voxel = 0; voxel < world.shape(object).n_voxels(); ++voxel) {
      const Index3 at = world.shape(object).index_of(voxel);
      take(world.pose(object).position + Eigen::Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5));
    }
  }
}

// Analytic: "the sum of the voxel movements is equal to the desired movement": four voxels in a row, the
// first of which a hand pushes by three cells, a cell after another.
TEST(SingleVoxelsAnalytic, ARowHandsOnWhatAHandAsksFor) {
  WorldScene scene = empty_world({20}, "hand_on");
  for (int i = 0; i < 4; ++i)
    scene.objects.push_back(
        box_object("voxel" + std::to_string(i), ObjectKind::rigid, {1}, {double(i), 0, 0}));
  World world(scene);
  Drive drive;
  drive.object = 0;
  drive.motion.by = {3, 0, 0};
  const FrameResult result = world.advance({&drive, 1});
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    EXPECT_GE(world.pose(i).position[0], i - 1e-8);
    sum += world.pose(i).position[0] - i;
  }
  EXPECT_NEAR(sum, 3, 1e-7);                 // a billionth of a cell is kept before every face
  EXPECT_EQ(result.status, Status::clamped); // the first voxel itself came to its face
  EXPECT_NEAR(world.pose(0).position[0], 0.5, 1e-8);
  EXPECT_FALSE(result.handed_on.empty());
  expect_a_cell_each(world);
}

// Analytic: before a wall each of three voxels has half a cell, whatever is asked.
TEST(SingleVoxelsAnalytic, AWallRefusesTheRest) {
  WorldScene scene = empty_world({20}, "hand_on");
  for (int i = 0; i < 3; ++i)
    scene.objects.push_back(
        box_object("voxel" + std::to_string(i), ObjectKind::rigid, {1}, {double(i), 0, 0}));
  scene.objects.push_back(box_object("wall", ObjectKind::fixed, {2}, {3, 0, 0}));
  World world(scene);
  Drive drive;
  drive.object = 0;
  drive.motion.by = {6, 0, 0};
  EXPECT_EQ(world.advance({&drive, 1}).status, Status::clamped);
  for (int i = 0; i < 3; ++i)
    EXPECT_NEAR(world.pose(i).position[0], i + 0.5, 1e-8);
  EXPECT_EQ(world.pose(3).position[0], 3);
}

// Analytic: at rest every node is the mean of its neighbours. A few sweeps a frame show the way there.
TEST(SingleVoxelsAnalytic, FramesShowABodyOnItsWayToRest) {
  WorldScene scene = empty_world({40, 10}, "hand_on");
  scene.objects = {box_object("bar", ObjectKind::deformable, {16, 1}, {4.5, 4.5, 0}, even_limits(2, 0.5, 1))};
  hold_face(scene.objects[0], 0, false);
  scene.objects[0].scene.relaxation.sweeps = 4;
  World world(scene);
  Drive drive;
  drive.object = 0;
  drive.motion.by = {0.8, 0, 0};
  drive.nodes = test::face_nodes(scene.objects[0], 0, true);
  EXPECT_EQ(world.advance({&drive, 1}).status, Status::budget_reached);
  EXPECT_NEAR(world.displacement(0)(0, 16), 0.8, 1e-9);
  EXPECT_FALSE(world.is_settled());
  const auto furthest_from_rest = [&] {
    double most = 0;
    for (std::int64_t x = 0; x <= 16; ++x)
      most = std::max(most, std::abs(world.displacement(0)(0, x) - 0.8 * double(x) / 16));
    return most;
  };
  EXPECT_GT(furthest_from_rest(), 0.1);
  for (int frame = 0; frame < 120; ++frame) {
    world.advance({});
    expect_a_cell_each(world);
  }
  EXPECT_LT(furthest_from_rest(), 0.05);
}

// Contract: what one body cannot do of a movement the other does, though no hand has it: both end apart, and
// the second has given way.
TEST(SingleVoxelsContract, ABodyThatIsPushedPushesTheNext) {
  WorldScene scene = empty_world({30, 10}, "hand_on");
  for (const double x : {3.5, 9.5})
    scene.objects.push_back(box_object(x < 5 ? "left" : "right", ObjectKind::deformable, {4, 2}, {x, 3.5, 0},
                                       even_limits(1.2, 0.8, 0.3)));
  World world(scene);
  Drive drive;
  drive.object = 0;
  drive.motion.by = {4, 0, 0};
  drive.nodes = test::face_nodes(scene.objects[0], 0, false);
  for (int frame = 0; frame < 3; ++frame) {
    world.advance({&drive, 1});
    drive.motion.by = {0, 0, 0};
    expect_a_cell_each(world);
  }
  double shift = 0;
  for (std::int64_t node = 0; node < 15; ++node)
    shift += world.displacement(1)(0, node) / 15;
  EXPECT_GT(shift, 0.05); // it is not driven
  EXPECT_EQ(world.n_shared_cells(), 0);
}

// Contract: whatever is pushed, and whenever a frame ends, a cell has one voxel; nothing is lost.
TEST(SingleVoxelsContract, NoPushPutsTwoVoxelsIntoOneCell) {
  std::size_t handed_on = 0, contacts = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    WorldScene scene = empty_world({24, 24}, "hand_on");
    scene.objects = {
        box_object("a", ObjectKind::deformable, {4, 3}, {3.5, 4.2, 0}, even_limits(1.3, 0.7, 0.4)),
        box_object("b", ObjectKind::deformable, {3, 4}, {11.5, 3.9, 0}, even_limits(1.5, 0.6, 0.4)),
        box_object("tool", ObjectKind::rigid, {2, 3}, {8, 12, 0}),
        box_object("wall", ObjectKind::fixed, {1, 6}, {18, 3, 0})};
    for (int i = 0; i < 5; ++i)
      scene.objects.push_back(
          box_object("voxel" + std::to_string(i), ObjectKind::rigid, {1, 1}, {3.0 + 2 * i, 18, 0}));
    World world(scene);
    for (int push = 0; push < 20; ++push) {
      Drive drive;
      drive.object = int(random() % 9);
      if (drive.object == 3)
        continue;
      drive.motion.by = 4 * Eigen::Vector3d(unit(random), unit(random), 0);
      if (drive.object < 2)
        drive.nodes =
            test::face_nodes(scene.objects[std::size_t(drive.object)], int(random() % 2), random() % 2 == 0);
      FrameBudget budget;
      budget.rounds = 1 + std::int64_t(random() % 30);
      const FrameResult result = world.advance({&drive, 1}, budget);
      handed_on += result.handed_on.size();
      contacts += result.contacts.size();
      ASSERT_NO_FATAL_FAILURE(expect_a_cell_each(world)) << "world " << seed << ", push " << push;
      ASSERT_EQ(world.n_shared_cells(), 0);
      if (push % 5 == 4)
        world.release(drive.object);
    }
  }
  EXPECT_GT(handed_on, 100u); // else nothing was tested
  EXPECT_GT(contacts, 10u);
}

TEST(SingleVoxelsContract, WhatIsNotVoxelByVoxelIsRefused) {
  const auto refused = [](const auto& change) {
    WorldScene scene = empty_world({20, 20}, "hand_on");
    scene.objects = {box_object("body", ObjectKind::deformable, {3, 3}, {4.5, 4.5, 0}),
                     box_object("tool", ObjectKind::rigid, {2, 2}, {12, 12, 0})};
    change(scene);
    try {
      World world(scene);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refused([](WorldScene&) {}), "");
  const auto names = [](const std::string& message, const char* part) {
    return message.find(part) != std::string::npos;
  };
  EXPECT_TRUE(names(refused([](WorldScene& s) { s.objects[1].turn_angle = 0.1; }), "`tool` is turned"));
  EXPECT_TRUE(names(refused([](WorldScene& s) { s.friction = 0.3; }), "friction"));
  EXPECT_TRUE(names(refused([](WorldScene& s) { s.contact = ContactLaw::halving; }), "contact"));
  EXPECT_TRUE(names(refused([](WorldScene& s) {
                      s.objects[0].scene.specimen.grid = Grid(2, {6, 6, 1}, {0.5, 0.5, 1});
                    }),
                    "`body` has two voxels in a cell"));
  EXPECT_TRUE(names(refused([](WorldScene& s) {
                      s.objects[1].scene.specimen.grid = Grid(2, {2, 2, 1}, {1.5, 1.5, 1});
                    }),
                    "`tool` has not the spacing"));
  EXPECT_TRUE(names(refused([](WorldScene& s) {
                      s.objects[0].scene.prescribed = {{0, 0, 0, true}};
                    }),
                    "along some axes"));
  WorldScene scene = empty_world({20, 20}, "hand_on");
  scene.objects = {box_object("tool", ObjectKind::rigid, {2, 2}, {12, 12, 0})};
  World world(scene);
  Drive drive;
  drive.motion.angle = 0.1;
  EXPECT_THROW(world.advance({&drive, 1}), std::invalid_argument);
}

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
                                  std::to_string(int(one.param.spacing));
                         });

} // namespace
} // namespace maille::deform
