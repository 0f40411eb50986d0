/// Worlds whose voxels hand on what they cannot move, one after another.

#include "maille/deform/world/world.hpp"
#include "support/worlds/random_worlds.hpp"
#include "support/worlds/worlds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

namespace maille::deform {
namespace {

using tests::box_object;
using tests::empty_world;
using tests::even_limits;
using tests::hold_face;

/// No cell has two nodes or voxels, counted anew from where they are.
void expect_a_cell_each(const World& world) {
  std::set<Index3> taken;
  const auto take = [&](const Eigen::Vector3d& at) {
    Index3 cell{};
    for (int a = 0; a < world.scene().dimension; ++a)
      cell[static_cast<std::size_t>(a)] =
          static_cast<int>(std::floor(at[a] / world.cell_size()[static_cast<std::size_t>(a)]));
    ASSERT_TRUE(world.map().has_cell(cell));
    ASSERT_TRUE(taken.insert(cell).second) << "two voxels in one cell";
  };
  for (int object = 0; object < world.n_objects(); ++object) {
    if (world.kind(object) == ObjectKind::deformable) {
      const Grid& grid = world.scene().objects[static_cast<std::size_t>(object)].scene.specimen.grid;
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
  drive.nodes = tests::face_nodes(scene.objects[0], 0, true);
  EXPECT_EQ(world.advance({&drive, 1}).status, Status::budget_reached);
  EXPECT_NEAR(world.displacement(0)(0, 16), 0.8, 1e-9);
  EXPECT_FALSE(world.is_settled());
  const auto furthest_from_rest = [&] {
    double most = 0;
    for (std::int64_t x = 0; x <= 16; ++x)
      most = std::max(most, std::abs(world.displacement(0)(0, x) - 0.8 * static_cast<double>(x) / 16));
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
  drive.nodes = tests::face_nodes(scene.objects[0], 0, false);
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
      drive.object = static_cast<int>(random() % 9);
      if (drive.object == 3)
        continue;
      drive.motion.by = 4 * Eigen::Vector3d(unit(random), unit(random), 0);
      if (drive.object < 2)
        drive.nodes = tests::face_nodes(scene.objects[static_cast<std::size_t>(drive.object)],
                                        static_cast<int>(random() % 2), random() % 2 == 0);
      FrameBudget budget;
      budget.rounds = 1 + static_cast<std::int64_t>(random() % 30);
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

} // namespace
} // namespace maille::deform
