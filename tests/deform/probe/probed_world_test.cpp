#include "maille/deform/probe/servo_loop.hpp"

#include "deform/probe/probe_scenes.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>

namespace maille::deform {
namespace {

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
