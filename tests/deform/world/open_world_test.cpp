/// A single body that is dragged, and bodies of which rounds of contact move a part.

#include "elastic/model/lattice_elasticity.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/solve.hpp"
#include "maille/deform/world/trajectory_drives.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/scene/read_scene.hpp"
#include "parallel/thread_team.hpp"
#include "support/kit.hpp"
#include "support/worlds/worlds.hpp"

namespace maille::deform {
namespace {

using test::drive_of;

constexpr double mm = 1e-3;

Scene block(const char* limits) {
  return parse_scene(std::string("[specimen]\nshape = \"box\"\ncells = [7, 6, 5]\nspacing = \"1 mm\"\n"
                                 "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
                                 "[[hold]]\nwhere = \"z-\"\n"
                                 "[[move]]\nwhere = \"z+\"\nby = [0, 0, \"1 mm\"]\n") +
                         limits,
                     "block.toml");
}

World open_world(const char* method, const char* limits = "") {
  std::vector<std::string> left_out;
  World world(world_of_body(block(limits), method, left_out));
  EXPECT_EQ(left_out.size(), 1u); // its move
  return world;
}

Drive pull(const World& world, const Eigen::Vector3d& by) {
  return drive_of(0, by, {world.scene().objects[0].scene.specimen.grid.node({3, 3, 5})});
}

// The answer of the method itself to where the hand has the node.
TEST(OpenWorldConsistent, ElasticBodiesAreWhereTheirMethodHasThem) {
  for (const char* method : {"relaxed", "coupled"}) {
    World world = open_world(method);
    FrameResult result;
    for (const double step : {0.3, -0.1, 0.2})
      result = world.advance(std::vector{pull(world, Eigen::Vector3d(step, 0.05, 2 * step) * mm)});
    const Answer answer = solve(world.question(0), method);
    EXPECT_EQ(answer.displacement, world.displacement(0)) << method;
    const std::int64_t node = pull(world, {0, 0, 0}).nodes[0];
    EXPECT_NEAR(world.displacement(0).at(node)[0], 0.4 * mm, 1e-12) << method;
    EXPECT_NEAR(world.displacement(0).at(node)[2], 0.8 * mm, 1e-12) << method;
    EXPECT_GT(result.drives[0].force[2], 0) << method;
    EXPECT_EQ(result.status, Status::done) << method << result.message;
    world.release(0);
    EXPECT_FALSE(world.is_settled()) << method;
    world.advance({});
    EXPECT_TRUE(world.is_settled()) << method;
    EXPECT_NEAR(world.displacement(0).at(node)[2], 0, 1e-12) << method;
  }
}

TEST(OpenWorldConsistent, ByLimitsABodyIsDragged) {
  const char* const limits = "[limits]\nfrom = \"given\"\nstretch = 1.25\ncompress = 0.75\nshear = 0.125\n";
  World world = open_world("limits", limits);
  const Scene& scene = world.scene().objects[0].scene;
  const LinkLimits resolved(scene);
  Drag drag(scene, resolved);
  Vec3 to{};
  FrameResult result;
  for (const double step : {0.5, 0.5, 0.5, -0.75}) { // dyadic, so that sums have no rounding
    const Drive drive = pull(world, {step * mm, 0, 0});
    to = world.displacement(0).at(drive.nodes[0]);
    to[0] += step * mm;
    result = world.advance(std::vector{drive});
    drag.move_to(drive.nodes[0], to);
    for (std::size_t i = 0; i < world.displacement(0).values().size(); ++i)
      ASSERT_NEAR(drag.displacement().values()[i], world.displacement(0).values()[i], 1e-9 * mm);
  }
  EXPECT_LE(world.largest_violation(), 1e-6);
  result = world.advance(std::vector{pull(world, {90 * mm, 0, 0})});
  EXPECT_EQ(result.status, Status::clamped);
  EXPECT_LT(result.drives[0].fraction, 0.1);
  EXPECT_LE(world.largest_violation(), 1e-6);
}

TEST(OpenWorldContract, TautLimitsAreThoseOfTheScenesOwnMove) {
  World world = open_world("limits", "[limits]\nfrom = \"taut\"\n");
  // The move is 1 mm over 5 links: they are taut just there.
  const FrameResult result = world.advance(std::vector{pull(world, {0, 0, 3 * mm})});
  EXPECT_EQ(result.status, Status::clamped);
  EXPECT_NEAR(world.displacement(0).at(pull(world, {0, 0, 0}).nodes[0])[2], 1 * mm, 1e-6 * mm);
}

// Rounds of contact move what is near something, the rest of a body comes after; and what a frame that is cut
// short says of what is left.

/// A belly that is held at both ends, and a smooth ball over its middle.
WorldScene belly_and_ball() {
  return test::belly_and(R"([[object]]
name     = "ball"
kind     = "rigid"
shape    = "ellipsoid"
surface  = "smooth"
cells    = [5, 5, 5]
position = ["9.5 mm", "5 mm", "10.2 mm"]
)");
}

/// [m]; of nodes without matter nothing in the world.
Eigen::Vector3d position_of(const World& world, std::int64_t node) {
  const Specimen& body = world.scene().objects[0].scene.specimen;
  return body.is_node(body.grid.node_at(node)) ? world.position(0, node) : Eigen::Vector3d::Constant(1);
}

Eigen::Vector3d on_muscle(const FrameResult& result) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const WorldContact& contact : result.contacts)
    if (contact.object == 0)
      sum += contact.force;
  return sum;
}

FrameResult pushed_down(World& world, double by, std::optional<std::int64_t> rounds = std::nullopt) {
  Drive drive = drive_of(1, {0, 0, -by});
  FrameBudget budget;
  budget.rounds = rounds;
  return world.advance({&drive, 1}, budget);
}

// Oracle: the lattice's elasticity, of the whole body. Where nothing touches it is at rest, inside and far
// away too, and all that pulls at its holds is what the ball presses with.
TEST(LocalRoundsOracle, TheRestOfABodyIsWhereItsContactsHaveIt) {
  World world(belly_and_ball());
  const Scene& scene = world.scene().objects[0].scene;
  const LatticeElasticity elasticity(scene);
  ThreadTeam team(1);
  for (int frame = 0; frame < 4; ++frame) {
    const FrameResult result = pushed_down(world, 0.7e-3);
    ASSERT_EQ(result.status, Status::done) << result.message;
    EXPECT_EQ(result.motion_left, 0);
    EXPECT_EQ(result.force_left, 0);
    Displacement forces(scene.specimen.grid);
    elasticity.apply(world.displacement(0), forces, team);
    const Eigen::Vector3d pressed = on_muscle(result);
    if (frame > 0) {
      EXPECT_LT(pressed[2], -1e-4);
    }
    double at_rest = 0, most = 0;
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
      const bool is_held = std::ranges::any_of(
          scene.prescribed, [&](const Prescribed& prescribed) { return prescribed.node == node; });
      const bool is_touched = std::ranges::any_of(result.contacts, [&](const WorldContact& contact) {
        return (*contact.at - position_of(world, node)).norm() < 1.5e-3; // on a face that has the node
      });
      for (int b = 0; b < 3; ++b) {
        const double force = std::abs(forces(b, node));
        most = std::max(most, force);
        if (!is_held && !is_touched)
          at_rest = std::max(at_rest, force);
      }
    }
    EXPECT_LT(at_rest, 1e-6 * most + 1e-12) << "frame " << frame;
  }
}

// Reference: the settled frame. What a frame that was cut short says is left is of the size of what then
// changes: an estimate, by the last rounds.
TEST(LocalRoundsReference, WhatIsLeftIsWhatThenChanges) {
  for (const std::int64_t rounds : {6, 9, 12}) {
    World world(belly_and_ball());
    ASSERT_EQ(pushed_down(world, 1.4e-3).status, Status::done);
    const FrameResult cut = pushed_down(world, 0.2e-3, rounds);
    ASSERT_EQ(cut.status, Status::budget_reached);
    EXPECT_FALSE(world.is_settled());
    std::vector<Eigen::Vector3d> before;
    const std::int64_t n = world.scene().objects[0].scene.specimen.grid.n_nodes();
    for (std::int64_t node = 0; node < n; ++node)
      before.push_back(position_of(world, node));
    const FrameResult settled = world.advance({});
    ASSERT_EQ(settled.status, Status::done);
    EXPECT_TRUE(world.is_settled());
    double motion = 0;
    for (std::int64_t node = 0; node < n; ++node)
      motion = std::max(motion, (position_of(world, node) - before[static_cast<std::size_t>(node)]).norm());
    const double force = (on_muscle(settled) - on_muscle(cut)).norm();
    EXPECT_LT(motion, 5 * *cut.motion_left);
    EXPECT_LT(*cut.motion_left, 20 * motion);
    EXPECT_LT(force, 5 * *cut.force_left);
  }
}

} // namespace
} // namespace maille::deform
