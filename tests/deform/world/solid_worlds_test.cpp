/// Solid stays solid: needles, stacks and bodies that keep their volume, by both laws.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/worlds.hpp"
#include "world/cell_overlap.hpp"
#include "world/dynamics/impacts.hpp"

#include <Eigen/Geometry>

namespace maille::deform {
namespace {

using test::drive_of;

constexpr double mm = 1e-3;

std::string world_text(const std::string& cells, const std::string& law) {
  return fmt::format("[world]\ncells = [{}]\nspacing = \"1 mm\"\n{}\n", cells, law);
}

std::string object(const std::string& name, const std::string& kind, const std::string& cells,
                   const Eigen::Vector3d& place, const std::string& more = "") {
  return fmt::format("[[object]]\nname = \"{}\"\nkind = \"{}\"\nshape = \"box\"\ncells = [{}]\nposition = "
                     "[\"{:.6f} mm\", \"{:.6f} mm\", \"{:.6f} mm\"]\n{}\n",
                     name, kind, cells, place[0], place[1], place[2], more);
}

std::string soft(double poisson, const std::string& hold = "") {
  return fmt::format("material = {{ youngs_modulus = \"10 kPa\", poisson_ratio = {} }}\n{}", poisson, hold);
}

/// How many worlds: MAILLE_WORLDS, or 60.
int n_worlds() {
  const char* const asked = std::getenv("MAILLE_WORLDS");
  return asked == nullptr ? test::cases(60, 6) : std::atoi(asked);
}

// Contract: no settled frame has matter in other matter, and what ends otherwise says why.
TEST(SolidWorldsContract, NothingComesIntoAnything) {
  int n_frames = 0, n_settled = 0, n_inside = 0;
  for (int seed = 0; seed < n_worlds(); ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto any = [&](double low, double high) {
      return std::uniform_real_distribution(low, high)(random);
    };
    const std::vector<double> ratios{0.3, 0.45, 0.499, 0.4999};
    const bool by_surfaces = seed % 3 != 0, has_time = seed % 6 == 5;
    const double off = 0.5 * (seed / 2 % 2), wide = 1 + seed / 4 % 3;
    const int width = 1 + static_cast<int>(any(0, 2.5)), body = 4 + static_cast<int>(any(0, 4));
    std::string text = world_text("20, 20, 30", has_time ? "dynamics = { gravity = [0, 0, \"-9.81 m/s^2\"] }"
                                                : by_surfaces ? "contact = \"surfaces\""
                                                              : "contact = \"cells\"") +
                       object("body", "deformable", fmt::format("{0}, {0}, {1}", body, 3 + seed % 3),
                              {5, 5, 0.5}, soft(ratios[random() % 4], "hold = [{ where = \"z-\" }]")) +
                       object("tool", "rigid", fmt::format("{0}, {0}, 12", width),
                              {any(5, 4 + body), any(5, 4 + body), 7.5});
    for (int i = 0; i < 3; ++i) // a stack: aligned, or every other off by half a cell
      text += object(fmt::format("box{}", i), "rigid", fmt::format("{0}, {0}, 4", wide),
                     {15 + off * (i % 2), 15 + off * (i / 2), 0.5 * has_time + 4.0 * i});
    World world(parse_world_scene(text));
    for (int frame = 0; frame < 5; ++frame) {
      Drive drive =
          drive_of(1, mm * Eigen::Vector3d(any(-1, 1), any(-1, 1), frame == 0 ? -1.5 : any(-2, 0.5)));
      drive.motion.axis = Eigen::Vector3d(any(-1, 1), any(-1, 1), any(-1, 1)).normalized();
      drive.motion.angle = seed % 2 == 0 ? any(0, 0.2) : 0;
      drive.motion.about = world.pose(1).position;
      Drive press; // on the top of the stack
      press.object = 4;
      press.motion.by = mm * Eigen::Vector3d(any(-0.5, 0.5), any(-0.5, 0.5), any(-1, 0.2));
      FrameBudget budget;
      budget.rounds = 2000;
      budget.frame_seconds = has_time ? 0.003 : 0;
      const FrameResult result =
          world.advance(has_time ? std::vector{drive} : std::vector{drive, press}, budget);
      ++n_frames;
      n_settled += is_converged(result.status);
      EXPECT_TRUE(result.status == Status::done || !result.message.empty());
      if (is_converged(result.status) || !by_surfaces)
        n_inside += world.n_penetrations() > 0;
      for (int i = 1; i < 5 && by_surfaces; ++i)
        for (int j = 1; j < i; ++j)
          n_inside += is_matter_in(
              world.scene().objects[static_cast<unsigned>(i)].scene.specimen, world.pose(i),
              world.scene().objects[static_cast<unsigned>(j)].scene.specimen, world.pose(j), 0.35 * mm);
    }
  }
  EXPECT_EQ(n_inside, 0);
  EXPECT_GT(n_settled, n_frames / 2);
  RecordProperty("frames", n_frames);
  RecordProperty("settled", n_settled);
  fmt::print("{} frames, {} settled, {} with matter in matter\n", n_frames, n_settled, n_inside);
}

// Contract: a needle of one voxel stays out of a body, wherever its nodes lie, and feels the force of the
// exact surfaces to a cell (docs/contact.md): one of depth, and one of width, which doubles a voxel's.
TEST(SolidWorldsContract, ANeedleOfOneVoxelPressesToACell) {
  const auto world_of = [](const char* law, double poisson, double body, double needle) {
    return World(parse_world_scene(world_text("10, 10, 21", fmt::format("contact = \"{}\"", law)) +
                                   object("fat", "deformable", "8, 8, 6", {body, body, 3},
                                          soft(poisson, "hold = [{ where = \"z-\" }]")) +
                                   object("needle", "rigid", "1, 1, 10", {needle, needle, 10})));
  };
  for (const double poisson : {0.3, 0.45, 0.4999})
    for (const double body : {1.0, 1.25, 1.5})
      for (const double needle : {4.0, 4.5}) {
        World exact = world_of("surfaces", poisson, body, needle);
        const double stiffness =
            -exact.advance(std::vector{drive_of(1, {0, 0, -1.5 * mm})}).drives[0].force[2] / 0.5; // [N/mm]
        World world = world_of("cells", poisson, body, needle);
        for (int frame = 0; frame < 8; ++frame) {
          const FrameResult result = world.advance(std::vector{drive_of(1, {0, 0, -0.5 * mm})});
          const double depth = 9 - world.pose(1).position[2] / mm, force = -result.drives[0].force[2];
          const std::string here = fmt::format("nu {}, body {}, needle {}: {} N at {} mm of {} N/mm", poisson,
                                               body, needle, force, depth, stiffness);
          EXPECT_GT(force, 0.7 * stiffness * (depth - 1) - 1e-3) << here;
          EXPECT_LT(force, 2 * stiffness * std::max(0.0, depth + 1)) << here;
          EXPECT_EQ(world.n_penetrations(), 0) << here;
          EXPECT_TRUE(result.status == Status::done || result.message.ends_with("and touches object `fat`"))
              << here << result.message;
        }
      }
}

// Contract: thin boxes that fall onto one another edge on edge, or off by half a cell, stay out.
TEST(StacksContract, NeedlesDoNotFallThroughNeedles) {
  for (const char* cells : {"1, 1, 6", "2, 1, 6", "3, 3, 2"})
    for (const double off : {0.0, 0.4, 0.5})
      for (const double above : {0.0, 0.5, 2.0}) {
        World world(parse_world_scene(
            world_text("20, 20, 40", "dynamics = { gravity = [0, 0, \"-9.81 m/s^2\"] }") +
            object("lower", "fixed", cells, {10, 10, 0.5}) +
            object("upper", "rigid", cells, {10 + off, 10, (cells[0] == '3' ? 2.5 : 6.5) + above})));
        FrameBudget budget;
        budget.frame_seconds = 0.005;
        for (int frame = 0; frame < 8; ++frame) {
          world.advance({}, budget);
          ASSERT_FALSE(is_matter_in(world.scene().objects[0].scene.specimen, world.pose(0),
                                    world.scene().objects[1].scene.specimen, world.pose(1), 0.3 * mm))
              << cells << " " << off << " " << above << " " << frame;
        }
      }
}

// Contract: what overlaps by a hair as a world begins is refused, what touches is not, whatever keeps apart.
TEST(SolidWorldsContract, AnOverlapAtTheBeginningIsRefused) {
  for (const char* law :
       {"contact = \"cells\"", "contact = \"surfaces\"", "dynamics = { gravity = [0, 0, \"-9.81 m/s^2\"] }"})
    for (const char* kind : {"rigid", "fixed"})
      for (const bool is_soft : {false, true})
        for (const double overlap : {0.0, 0.03, 0.3, 0.9})
          for (const double beside : {0.0, 0.37}) {
            // By surfaces two may meet in a cell.
            const double off = std::string(law) == "contact = \"surfaces\"" || law[0] == 'd' ? 0.5 : 0;
            const std::string text =
                world_text("20, 20, 20", law) + object("one", kind, "4, 4, 4", {4 + off, 4, 4}) +
                object("two", is_soft ? "deformable" : "rigid", "4, 4, 4",
                       {8 + off - overlap, 4 + beside, 4 + beside}, is_soft ? soft(0.3) : "");
            if (overlap == 0) {
              EXPECT_NO_THROW(World(parse_world_scene(text))) << text;
            } else {
              EXPECT_THROW(World(parse_world_scene(text)), std::invalid_argument) << text;
            }
          }
}

// Analytic: two bars whose edges cross, no corner of either in the other.
TEST(SolidWorldsAnalytic, CrossedEdgesAreSeen) {
  const auto bar = [](const Eigen::Matrix3d& turn, const Eigen::Vector3d& middle) {
    std::vector<Eigen::Vector3d> corners;
    for (int i = 0; i < 8; ++i)
      corners.emplace_back(middle +
                           turn * Eigen::Vector3d(i & 1 ? 10 : -10, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5));
    return ConvexCell(std::move(corners));
  };
  const Eigen::Matrix3d on_edge = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitX()).toRotationMatrix(),
                        across = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  for (const double depth : {0.01, 0.1, 0.5}) {
    const ConvexCell lower = bar(on_edge, {0, 0, 0}),
                     upper = bar(across * on_edge, {0, 0, std::sqrt(2.0) - depth});
    EXPECT_TRUE(lower.is_deeper_in(upper, 0.99 * depth));
    EXPECT_FALSE(lower.is_deeper_in(upper, 1.01 * depth));
  }
}

// Oracle: all points of a face give the same speeds as those that carry what they could.
TEST(CarriersOracle, TheyGiveTheSpeedsOfAllPoints) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-1, 1);
  const auto vector = [&] { return Eigen::Vector3d(any(random), any(random), any(random)); };
  const WorldScene scene = parse_world_scene(world_text("40, 40, 40", "contact = \"surfaces\"") +
                                             object("one", "rigid", "8, 10, 6", {1, 1, 1}));
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<MovingObject> moving(2, MovingObject(scene.objects[0], 3, true));
    const std::vector<Pose> poses{{Eigen::Matrix3d::Identity(), {0, 0, 6 * mm}}, Pose()};
    for (MovingObject& one : moving)
      one.velocity = vector(), one.spin = 50 * vector();
    std::vector<ImpactPoint> all;
    for (int i = 0; i < 60; ++i) {
      ImpactPoint point;
      point.object = 0, point.other = 1, point.node = i;
      point.at = mm * Eigen::Vector3d(4 + 4 * any(random), 5 + 5 * any(random), 6);
      point.normal = Eigen::Vector3d::UnitZ();
      all.push_back(point);
    }
    std::vector<ImpactPoint> few = carriers_of(all);
    EXPECT_LT(few.size(), 25u);
    std::vector<MovingObject> by_all = moving, by_few = moving;
    resolve_impacts(all, poses, by_all, 0);
    resolve_impacts(few, poses, by_few, 0);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_LT((by_all[i].velocity - by_few[i].velocity).norm(), 1e-6);
      EXPECT_LT(mm * (by_all[i].spin - by_few[i].spin).norm(), 1e-6);
    }
  }
}

// Contract: a stack that lies takes few steps a frame, with few points a pair.
TEST(StacksContract, TenBoxesTakeFewPoints) {
  std::string text =
      world_text("40, 40, 90", "dynamics = { gravity = [0, 0, \"-9.81 m/s^2\"], restitution = 0.2 }") +
      object("floor", "fixed", "30, 30, 2", {5, 5, 0});
  for (int i = 0; i < 10; ++i)
    text += object(fmt::format("box{}", i), "rigid", "8, 10, 6", {15 + 0.3 * (i % 3), 15, 2 + 6.01 * i});
  World world(parse_world_scene(text));
  FrameBudget budget;
  budget.frame_seconds = 0.01;
  for (int frame = 0; frame < 20; ++frame) {
    const FrameResult result = world.advance({}, budget);
    ASSERT_EQ(result.status, Status::done);
    EXPECT_LE(result.rounds, frame < 10 ? 200 : 5) << "frame " << frame;
    EXPECT_LE(result.contacts.size(), 10u * 2 * 40) << "frame " << frame;
  }
  EXPECT_EQ(world.n_penetrations(), 0);
  for (int i = 1; i <= 10; ++i)
    EXPECT_NEAR(world.pose(i).position[2], (2 + 6 * (i - 1)) * mm, 0.02 * mm);
}

// Contract: a rounded soft body that lies down on a table settles in every step, in few rounds.
TEST(StacksContract, ALimbLiesDownOnATable) {
  World world(parse_world_scene(
      "[world]\ncells = [60, 40, 40]\nspacing = \"2 mm\"\ncontact = \"surfaces\"\n"
      "dynamics = { gravity = [0, 0, \"-9.81 m/s^2\"], damping = 5 }\n[[object]]\nname = \"limb\"\n"
      "kind = \"deformable\"\nshape = \"ellipsoid\"\ncells = [32, 16, 16]\ndensity = 1050\n" +
      soft(0.45, "position = [\"28 mm\", \"24 mm\", \"6.5 mm\"]\n") +
      object("table", "fixed", "50, 36, 3", {10, 4, 0})));
  FrameBudget budget;
  budget.frame_seconds = 0.02;
  for (int frame = 0; frame < 2; ++frame) {
    const FrameResult result = world.advance({}, budget);
    EXPECT_EQ(result.status, Status::done) << result.message;
    EXPECT_LT(result.rounds, 90);
  }
}

// Contract: a soft body at rest on its world's floor takes one step a frame, until a ball falls on it.
TEST(StacksContract, ABodyAtRestTakesAStepAFrame) {
  World world(parse_world_scene(
      world_text("12, 12, 40", "dynamics = { gravity = [0, 0, \"-9.81 m/s^2\"], damping = 20 }") +
      object("body", "deformable", "4, 4, 3", {4, 4, 0}, soft(0.45, "density = 1050")) +
      object("ball", "rigid", "2, 2, 2", {5, 5, 30})));
  FrameBudget budget;
  budget.frame_seconds = 0.01;
  FrameResult result = world.advance(std::vector{drive_of(1, Eigen::Vector3d::Zero())}, budget); // held
  for (int frame = 0; frame < 30; ++frame)
    result = world.advance({}, budget);
  EXPECT_EQ(result.rounds, 1);
  world.release(1);
  for (int frame = 0; frame < 12; ++frame)
    EXPECT_GE(world.advance({}, budget).rounds, 10);
  EXPECT_NEAR(world.pose(1).position[2], 3 * mm, 0.3 * mm) << "on the body";
}

// Contract: a tool whose edges are on, between or beside nodes settles as deep as it goes, in few rounds and
// contacts, of a body on a floor as of one above it.
TEST(PressesContract, DeepOnesSettle) {
  for (const double off : {0.0, 0.3, 0.5})
    for (const double poisson : {0.3, 0.45, 0.499})
      for (const double z : {2, 5}) {
        World world(parse_world_scene(world_text("32, 32, 46", "contact = \"surfaces\"") +
                                      object("floor", "fixed", "28, 28, 2", {2, 2, 0}) +
                                      object("body", "deformable", "12, 12, 6", {10, 10, z},
                                             soft(poisson, "hold = [{ where = \"z-\" }]")) +
                                      object("tool", "rigid", "4, 4, 12", {14 + off, 14 + off, z + 6.1})));
        Drive drive = drive_of(2, {0, 0, -0.3 * mm});
        for (int frame = 0; frame < 8; ++frame) {
          const FrameResult result = world.advance(std::vector{drive}, {});
          EXPECT_TRUE(is_converged(result.status)) << off << " " << poisson << " " << frame;
          EXPECT_LT(result.rounds, 150) << off << " " << poisson << " " << frame;
          EXPECT_LT(result.contacts.size(), 100U);
        }
        EXPECT_EQ(world.n_penetrations(), 0);
      }
}

// Contract: a body that is held at the world's border presses nothing there.
TEST(BordersContract, WhatIsHeldAtTheBorderDoesNotPressIt) {
  std::vector<std::size_t> contacts;
  for (const double above : {0.0, 1.0}) {
    World world(parse_world_scene(
        world_text("20, 20, 30", "contact = \"surfaces\"") +
        object("body", "deformable", "6, 6, 4", {5, 5, above}, soft(0.3, "hold = [{ where = \"z-\" }]")) +
        object("tool", "rigid", "2, 2, 6", {7, 7, 4.2 + above})));
    Drive drive = drive_of(1, {0, 0, -0.7 * mm});
    const FrameResult result = world.advance(std::vector{drive}, {});
    EXPECT_EQ(result.status, Status::done);
    contacts.push_back(result.contacts.size());
    for (const WorldContact& contact : result.contacts)
      EXPECT_TRUE(contact.object >= 0 && contact.other >= 0);
  }
  EXPECT_EQ(contacts[0], contacts[1]);
}

} // namespace
} // namespace maille::deform
