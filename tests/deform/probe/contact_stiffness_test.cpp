#include "deform/probe/probe_scenes.hpp"
#include "maille/deform/probe/probe.hpp"
#include "maille/deform/probe/servo_loop.hpp"
#include "support/dice.hpp"
#include "support/kit.hpp"

#include <chrono>

namespace maille::deform {
namespace {

using test::free_block;

std::shared_ptr<const BodySurface> surface_of(const Scene& scene, const Pose& pose = {}) {
  return std::make_shared<BodySurface>(scene, Displacement(), pose);
}

/// Face of the body on top of a column of cells.
std::int32_t top_face(const BodySurface& surface, const Scene& scene, int x, int y) {
  for (std::size_t i = 0; i < surface.faces().size(); ++i) {
    const auto& face = surface.faces()[i];
    const Index3 cell = scene.specimen.grid.cell_at(face.cell);
    if (face.axis == 2 && face.upper && cell[0] == x && cell[1] == y)
      return static_cast<std::int32_t>(i);
  }
  return -1;
}

TEST(ContactStiffnessAnalytic, ABlockUnderAPlateIsABar) {
  const Scene scene = free_block({6, 4, 8});
  const auto surface = surface_of(scene);
  const ContactSolver solver(scene, surface, 10e-3); // over the whole top
  const ContactSite site{1, top_face(*surface, scene, 3, 2), {3e-3, 2e-3, 8e-3}, 0.2e-3};
  const ContactStiffness found = solver.solve(site);
  ASSERT_EQ(found.status, Status::done);
  EXPECT_EQ(found.nodes, 7 * 5);
  const double expected = 10e3 * (6e-3 * 4e-3) / 8e-3;     // analytic: E A / L
  EXPECT_NEAR(found.stiffness, expected, 1e-5 * expected); // the solver's tolerance
  EXPECT_NEAR(found.reaction, expected * 0.2e-3, 1e-5 * expected * 0.2e-3);
}

TEST(ContactStiffnessAnalytic, StiffnessDoesNotDependOnTheDepthOfALinearBody) {
  Scene scene = test::carved_body({6, 6, 6}, {1e-3, 1e-3, 1e-3});
  scene.relaxation.tolerance = 1e-7;
  const auto surface = surface_of(scene);
  const ContactSolver solver(scene, surface, 0);
  EXPECT_FALSE(solver.depends_on_depth());
  ContactSite site{1, top_face(*surface, scene, 4, 4), {4.2e-3, 4.3e-3, 6e-3}, 1e-6};
  const double shallow = solver.solve(site).stiffness;
  site.depth = 1e-3;
  EXPECT_NEAR(solver.solve(site).stiffness, shallow, 1e-5 * shallow);
  EXPECT_EQ(solver.footprint(site), std::vector<std::int64_t>{scene.specimen.grid.node({4, 4, 6})});
}

// Analytic: a point on a body is softer than the same on the half space is stiff, and the estimate is of that
// size.
TEST(ContactStiffnessAnalytic, TheEstimateIsOfTheSizeOfADeepBodysStiffness) {
  Scene scene = test::box_scene(3, {16, 16, 16});
  test::hold_face(scene, 2, false);
  const auto surface = surface_of(scene);
  const ContactSolver solver(scene, surface, 3e-3);
  const ContactStiffness estimate = solver.estimate();
  // Sneddon: 2 a E / (1 - nu^2)
  EXPECT_NEAR(estimate.stiffness, 2 * 3e-3 * 10e3 / (1 - 0.09), 1e-9);
  const ContactStiffness found =
      solver.solve({1, top_face(*surface, scene, 8, 8), {8e-3, 8e-3, 16e-3}, 0.1e-3});
  EXPECT_GT(found.stiffness, 0.8 * estimate.stiffness);
  EXPECT_LT(found.stiffness, 1.6 * estimate.stiffness);
}

// Oracle: all nodes of the body asked.
TEST(ContactStiffnessOracle, TheFootprintIsAllNodesOfThatSideWithinTheRadius) {
  const Scene scene = test::carved_body({7, 8, 6}, {1e-3, 1.1e-3, 0.9e-3});
  const Pose pose = test::turned_pose(0.7, {1, 0, 2}, {0.1, 0.2, 0.3});
  const auto surface = surface_of(scene, pose);
  std::mt19937 random(3);
  test::Dice dice{random};
  for (int round = 0; round < 200; ++round) {
    const double radius = dice.between(0, 4e-3);
    const ContactSolver solver(scene, surface, radius);
    const auto number = static_cast<std::int32_t>(dice.below(static_cast<int>(surface->faces().size())));
    const auto& face = surface->faces()[static_cast<std::size_t>(number)];
    const auto corner = [&](std::size_t i) { return surface->position(face.corners[i]); };
    const double s = dice.between(0, 1), t = dice.between(0, 1);
    const Eigen::Vector3d point = corner(0) + s * (corner(1) - corner(0)) + t * (corner(3) - corner(0));
    std::set<std::int64_t> expected;
    for (const auto& other : surface->faces())
      for (const std::int32_t c : other.corners) {
        const Eigen::Vector3d away = pose.rotation.transpose() * (surface->position(c) - point);
        const bool same_side = other.axis == face.axis && other.upper == face.upper;
        if (same_side && std::abs(away[face.axis]) < 1e-9 && away.norm() <= radius)
          expected.insert(surface->node(c));
      }
    const auto found = solver.footprint({1, number, point, 1e-4});
    if (expected.empty()) {
      ASSERT_EQ(found.size(), 1u);
      continue;
    }
    // Nodes where the side's matter ends against a step up are covered, and left out.
    for (const std::int64_t node : found)
      ASSERT_TRUE(expected.contains(node)) << round;
    std::size_t covered = 0;
    for (const std::int64_t node : expected)
      if (std::ranges::find(found, node) == found.end()) {
        bool has_matter_above = false;
        const Index3 at = scene.specimen.grid.node_at(node);
        scene.specimen.for_each_cell_at(at, [&](std::int64_t cell) {
          const bool above = scene.specimen.grid.cell_at(cell)[static_cast<std::size_t>(face.axis)] ==
                             at[static_cast<std::size_t>(face.axis)];
          has_matter_above = has_matter_above || above == face.upper;
        });
        ASSERT_TRUE(has_matter_above) << round;
        ++covered;
      }
    ASSERT_EQ(found.size() + covered, expected.size());
  }
}

TEST(ContactStiffnessContract, WhatIsHeldIsRigid) {
  const Scene scene = free_block({4, 4, 4});
  const auto surface = surface_of(scene);
  const ContactSolver solver(scene, surface, 0);
  for (std::size_t i = 0; i < surface->faces().size(); ++i)
    if (surface->faces()[i].axis == 2 && !surface->faces()[i].upper) {
      const auto found = solver.solve({1, static_cast<std::int32_t>(i), {1e-3, 1e-3, 0}, 1e-4});
      EXPECT_TRUE(std::isinf(found.stiffness));
      EXPECT_EQ(found.nodes, 0);
    }
  Scene moved = scene;
  moved.prescribed[0].held = false;
  EXPECT_THROW(ContactSolver(moved, surface, 0), std::invalid_argument);
}

TEST(ContactStiffnessContract, ABodyThatNothingHoldsKeepsItsEstimate) {
  const Scene scene = test::box_scene(3, {4, 4, 4});
  const auto surface = surface_of(scene);
  const ContactSolver solver(scene, surface, 0);
  const auto found = solver.solve({1, 0, surface->position(surface->faces()[0].corners[0]), 1e-4});
  EXPECT_EQ(found.status, Status::refused);
  EXPECT_EQ(found.stiffness, solver.estimate().stiffness);
}

TEST(ContactStiffnessContract, ThePhysicsBesideGivesTheSolversBits) {
  const Scene scene = test::carved_body({8, 8, 8}, {1e-3, 1e-3, 1e-3});
  const auto surface = surface_of(scene);
  const ContactSolver solver(scene, surface, 1.5e-3);
  const ContactSite site{5, top_face(*surface, scene, 5, 5), {5.2e-3, 5.5e-3, 8e-3}, 1e-4};
  for (const int threads : {1, 2}) {
    ContactPhysics physics(solver, threads);
    EXPECT_EQ(physics.newest().number, 0);
    EXPECT_EQ(physics.newest().stiffness, solver.estimate().stiffness);
    physics.ask({4, site.face, site.point, 2e-4});
    physics.ask(site);
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(2);
    while (physics.newest().number != 5 && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(physics.newest().stiffness, solver.solve(site).stiffness) << threads;
  }
}

WorldObject object_of(const std::string& name, ObjectKind kind, const Index3& cells, const Vec3& position) {
  WorldObject object;
  object.name = name;
  object.kind = kind;
  object.scene = test::box_scene(3, cells);
  if (kind == ObjectKind::deformable)
    test::hold_face(object.scene, 2, false);
  object.position = position;
  return object;
}

WorldScene three_objects() {
  WorldScene scene;
  scene.cells = {30, 20, 20};
  scene.spacing = {1e-3, 1e-3, 1e-3};
  scene.objects = {object_of("wall", ObjectKind::fixed, {2, 20, 20}, {0, 0, 0}),
                   object_of("pad", ObjectKind::deformable, {6, 6, 4}, {8e-3, 6e-3, 2e-3}),
                   object_of("finger", ObjectKind::rigid, {2, 2, 3}, {20e-3, 8e-3, 10e-3})};
  return scene;
}

TEST(ProbedWorldContract, TheToolIsTakenOutOfTheMapAndBodiesAreSurfaces) {
  const ProbedWorld world(three_objects(), 2, 0);
  EXPECT_EQ(world.n_bodies(), 1);
  EXPECT_EQ(world.name(0), "pad");
  EXPECT_EQ(world.tool().n_voxels(), 12);
  ASSERT_TRUE(world.start());
  EXPECT_LT((world.start()->position - Eigen::Vector3d(21e-3, 9e-3, 11.5e-3)).norm(),
            1e-15); // the box's middle
  // The wall alone is in the map: neither the tool nor the pad, which gives way.
  EXPECT_EQ(world.surroundings()->map()->n_occupied(), 2 * 20 * 20);
  const Surroundings& around = *world.surroundings();
  const RigidShape point = point_tool({1e-3, 1e-3, 1e-3});
  const auto is_inside = [&](const Eigen::Vector3d& at) {
    return around.n_inside(point, Proxy(point, Pose{.position = at}).pose()) > 0;
  };
  EXPECT_TRUE(is_inside({1e-3, 5e-3, 5e-3}));
  EXPECT_TRUE(is_inside({10e-3, 8e-3, 5e-3}));
  EXPECT_FALSE(is_inside({21e-3, 9e-3, 11.5e-3}));
  EXPECT_FALSE(is_inside({10e-3, 8e-3, 7e-3}));
  EXPECT_TRUE(is_inside({-1e-3, 8e-3, 7e-3})); // beyond the border
}

TEST(ProbedWorldContract, AToolIsRigidAndObjectsAreApart) {
  EXPECT_THROW(ProbedWorld(three_objects(), 0, 0), std::invalid_argument);
  EXPECT_THROW(ProbedWorld(three_objects(), 1, 0), std::invalid_argument);
  EXPECT_THROW(ProbedWorld(three_objects(), 3, 0), std::invalid_argument);
  WorldScene overlapping = three_objects();
  overlapping.objects[2].position = {9e-3, 7e-3, 3e-3};
  EXPECT_THROW(ProbedWorld(overlapping, -1, 0), std::invalid_argument);
}

TEST(ProbedWorldContract, OfOneBodyItsHoldsAloneAreKept) {
  Scene scene = test::box_scene(3, {4, 4, 4});
  test::hold_face(scene, 2, false);
  test::move_face(scene, 2, true, {0, 0, 1e-3});
  scene.gravity = {0, 0, -9.81};
  const ProbedWorld world(scene, 0);
  EXPECT_EQ(world.surroundings()->map(), nullptr);
  EXPECT_FALSE(world.scene(0).has_loads());
  EXPECT_EQ(world.scene(0).prescribed.size(), 3u * 25u);
}

// Analytic: a finger of 2 x 2 voxels on a pad of the same cells has nine of its nodes before it; what stands
// over the pad's edge has the nodes of the pad alone.
TEST(ProbedWorldAnalytic, AToolPressesTheNodesThatItsVoxelsComeTo) {
  const ProbedWorld world(three_objects(), 2, 0);
  const auto faces = world.solver(0).surface().faces();
  ContactSite site;
  for (std::size_t face = 0; face < faces.size() && site.face < 0; ++face)
    if (faces[face].axis == 2 && faces[face].upper)
      site.face = static_cast<std::int32_t>(face);
  ASSERT_GE(site.face, 0);
  site.depth = 1e-3;
  site.tool = Pose{.position = {10e-3, 8e-3, 6e-3 + 1e-9}};
  EXPECT_EQ(world.solver(0).footprint(site).size(), 9u);
  site.tool->position[0] = 13e-3;
  EXPECT_EQ(world.solver(0).footprint(site).size(), 6u);
  site.tool->position[2] += 0.4e-3; // and comes to them within the depth
  EXPECT_EQ(world.solver(0).footprint(site).size(), 6u);
  site.tool->position[2] += 2e-3;
  EXPECT_EQ(world.solver(0).footprint(site).size(), 1u); // a point: the nearest node
}

// Contract: where a free tool goes towards a body its stiffness is asked for on the way, and the first touch
// finds it, in place of an estimate that is blended over.
TEST(ProbedWorldContract, AFirstTouchFindsTheStiffnessThatWasAskedForBefore) {
  const ProbedWorld world(three_objects(), -1, 0);
  const auto above = [](double z) { return Pose{.position = {11.2e-3, 9.3e-3, z}}; };
  Probe probe(world.surroundings(), Proxy(world.tool(), above(10e-3)), {}, 0.5);
  ContactStiffness newest;
  newest.stiffness = 50;
  int asked = 0;
  probe.link(0, {[&](const ContactSite&) {
                   ++asked;
                   newest.stiffness = 123;
                 },
                 [&]() -> const ContactStiffness& { return newest; }, false});
  probe.tick(above(10e-3));
  EXPECT_EQ(asked, 0); // a hand that does not move goes nowhere
  int tick = 1;
  for (; tick < 200 && !probe.tick(above(10e-3 - 0.05e-3 * tick)).is_touching; ++tick)
    ASSERT_LE(asked, 1); // one place, asked about once
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(probe.state().stiffness, 123);
}

} // namespace
} // namespace maille::deform
