/// Soft bodies that are folded, closed and pulled about: none passes through itself, or comes to hold another
/// object between its stretched nodes.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/worlds.hpp"

namespace maille::deform {
namespace {

using test::drive_of;
using test::elastic_object;
using test::empty_world;
using test::hold_face;

struct Method {
  const char* name;
  const char* method;
  const char* keys; ///< of the object
  const char* material = "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3";
};

/// A C whose arms are `gap` cells apart, held by its back.
World letter_c(const Method& method, int gap) {
  std::string rows = "\"############\",\"############\",";
  for (int i = 0; i < gap; ++i)
    rows += "\"###.........\",";
  rows += "\"############\",\"############\"";
  return World(parse_world_scene(fmt::format(R"(
[world]
cells = [30, 30]
spacing = "1 mm"
method = "{}"
[[object]]
name = "c"
kind = "deformable"
shape = "rows"
rows = [{}]
material = {{ {} }}
hold = [{{ where = "x-" }}]
position = ["8.5 mm", "8.5 mm"]
{}
)",
                                             method.method, rows, method.material, method.keys)));
}

std::vector<std::int64_t> nodes_at(const World& world, double x, double y0, double y1) {
  const Specimen& body = world.scene().objects[0].scene.specimen;
  std::vector<std::int64_t> nodes;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
    if (const Vec3 at = body.position(body.grid.node_at(node));
        body.is_node(body.grid.node_at(node)) && at[0] > x && at[1] > y0 && at[1] < y1)
      nodes.push_back(node);
  return nodes;
}

/// Segments of the outline of one arm of a C that cross some of the other arm's: each against each.
int n_crossings(const World& world, int object) {
  const Specimen& body = world.scene().objects[static_cast<std::size_t>(object)].scene.specimen;
  const Grid& grid = body.grid;
  std::array<std::vector<std::pair<std::int64_t, std::int64_t>>, 2> arms; // lower, upper
  const auto add = [&](const Index3& from, const Index3& to) {
    if (from[0] >= 3)
      arms[from[1] > 2 ? 1 : 0].emplace_back(grid.node(from), grid.node(to));
  };
  const auto is_matter = [&](const Index3& cell) {
    return grid.has_cell(cell) && body.is_matter(grid.cell(cell));
  };
  for (int y = 0; y <= grid.cells()[1]; ++y)
    for (int x = 0; x <= grid.cells()[0]; ++x) {
      if (x < grid.cells()[0] && is_matter({x, y, 0}) != is_matter({x, y - 1, 0}))
        add({x, y, 0}, {x + 1, y, 0});
      if (y < grid.cells()[1] && is_matter({x, y, 0}) != is_matter({x - 1, y, 0}))
        add({x, y, 0}, {x, y + 1, 0});
    }
  const auto side = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
    return (q - p).cross(r - p)[2];
  };
  int n = 0;
  for (const auto& [a, b] : arms[0])
    for (const auto& [c, d] : arms[1]) {
      const Eigen::Vector3d pa = world.position(object, a), pb = world.position(object, b),
                            pc = world.position(object, c), pd = world.position(object, d);
      n += side(pa, pb, pc) * side(pa, pb, pd) < 0 && side(pc, pd, pa) * side(pc, pd, pb) < 0;
    }
  return n;
}

class SelfContactIndependent : public testing::TestWithParam<Method> {};

// Independent: every segment of one arm's outline against every one of the other's. Arms that are closed by
// more than their gap stop before one another, and come back.
TEST_P(SelfContactIndependent, AClosedCDoesNotPassThroughItself) {
  for (const int gap : {1, 4}) {
    SCOPED_TRACE(testing::Message() << "gap " << gap);
    World world = letter_c(GetParam(), gap);
    ASSERT_EQ(n_crossings(world, 0), 0);
    Drive drive;
    drive.nodes = nodes_at(world, 9.5e-3, (2.5 + gap) * 1e-3 - 1e-3, 1);
    ASSERT_GE(drive.nodes.size(), 6u);
    bool has_met = false;
    for (int frame = 0; frame < gap + 3; ++frame) {
      drive.motion.by = {0, -0.8e-3, 0};
      const FrameResult result = world.advance({&drive, 1});
      ASSERT_EQ(n_crossings(world, 0), 0) << "frame " << frame;
      ASSERT_EQ(world.n_shared_cells(), 0);
      for (const WorldContact& contact : result.contacts)
        has_met = has_met || contact.other == 0;
    }
    EXPECT_TRUE(has_met);
    // Not stopped long before: the tips have come as near as a cell; at finite strain nearly so, for no cell
    // between handles and touches may invert.
    const double nearest = GetParam().name == std::string_view("finite") ? 1.2e-3 : 1e-3;
    double lowest = 1, highest = 0;
    for (const std::int64_t node : drive.nodes)
      lowest = std::min(lowest, world.position(0, node)[1]);
    for (const std::int64_t node : nodes_at(world, 9.5e-3, -1, 2.5e-3))
      highest = std::max(highest, world.position(0, node)[1]);
    EXPECT_LT(lowest - highest, nearest);
    for (int frame = 0; frame < 3; ++frame) {
      drive.motion.by = {0, 0.8e-3, 0};
      EXPECT_GT(world.advance({&drive, 1}).drives[0].fraction, 0.9) << "frame " << frame;
      ASSERT_EQ(n_crossings(world, 0), 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Methods, SelfContactIndependent,
    testing::Values(Method{"limits", "limits",
                           "limits = { from = \"given\", stretch = 1.4, compress = 0.6, shear = 0.9 }"},
                    Method{"coupled", "coupled", ""}, Method{"relaxed", "relaxed", ""},
                    Method{"finite", "coupled", "relaxation = { frame = \"blocks\" }",
                           "law = \"neo_hookean\", E = \"10 kPa\", nu = 0.3"}),
    [](const auto& one) { return std::string(one.param.name); });

// Independent: the same, of handles that pull a C about at random.
TEST(SelfContactIndependent, NoRandomDragCrossesABody) {
  const Method methods[] = {
      {"limits", "limits", "limits = { from = \"given\", stretch = 1.5, compress = 0.6, shear = 0.9 }"},
      {"coupled", "coupled", ""}};
  for (const Method& method : methods)
    for (unsigned seed = 0; seed < 4; ++seed) {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> unit(-1, 1);
      World world = letter_c(method, 1 + static_cast<int>(seed) % 4);
      for (int drag = 0; drag < 12; ++drag) {
        Drive drive;
        const bool is_upper = random() % 2 == 0;
        drive.nodes = is_upper ? nodes_at(world, 9.5e-3, 3.5e-3, 1) : nodes_at(world, 9.5e-3, -1, 2.5e-3);
        drive.motion.by = 3e-3 * Eigen::Vector3d(unit(random), unit(random), 0);
        FrameBudget budget;
        budget.rounds = 60;
        world.advance({&drive, 1}, budget);
        ASSERT_EQ(n_crossings(world, 0), 0) << method.name << ", seed " << seed << ", drag " << drag;
        if (random() % 3 == 0)
          world.release(0);
      }
    }
}

// Contract: limits that keep a box in order leave nothing to look for; a C needs it whatever its limits are.
TEST(SelfContactContract, WhereLimitsKeepOrderNothingIsLookedFor) {
  // What is looked for is seen by how long the narrowest gap would have to close: see SelfContact::is_never.
  WorldScene scene = empty_world({20, 20}, "limits");
  scene.objects = {test::box_object("box", ObjectKind::deformable, {6, 6}, {4.5, 4.5, 0},
                                    test::even_limits(1.2, 0.8, 0.2))};
  World world(scene);
  const Drive drive = drive_of(0, {-2, 0, 0}, test::face_nodes(scene.objects[0], 0, true));
  const FrameResult result = world.advance({&drive, 1});
  for (const WorldContact& contact : result.contacts)
    EXPECT_NE(contact.other, 0);
}

// Independent: the geometry of hexahedra (World::n_penetrations). A body that is pulled to twice its length
// is as solid as it was: a tip of one voxel that is pushed against its flank between two nodes stays out.
// A probe that is deep in a body and goes aside drags nodes through one another: where what touches what does
// not
// change from one answer to the next, the frame ends.
TEST(SelfContactContract, AFrameEndsWhereABodyIsInItsOwnWay) {
  const WorldScene scene = parse_world_scene(R"([world]
cells = [34, 20, 30]
spacing = "1 mm"
[[object]]
name = "body"
kind = "deformable"
shape = "ellipsoid"
cells = [10, 9, 7]
material = { youngs_modulus = "20 kPa", poisson_ratio = 0.4 }
hold = [{ where = "x-" }, { where = "x+" }]
position = ["6.5 mm", "5.5 mm", "5.5 mm"]
[[object]]
name = "probe"
kind = "rigid"
shape = "ellipsoid"
cells = [4, 4, 8]
position = ["9 mm", "8 mm", "13 mm"]
)");
  // Where a frame ends is up to the last bits of answers: of several, some end so.
  int n_in_their_way = 0;
  for (const double up : {0.0, 1.5e-3, 4e-3}) {
    World world(scene);
    Drive drive = drive_of(1, {0, 0, -4e-3});
    world.advance({&drive, 1});
    drive.motion.by = {4e-3, 0, up};
    const FrameResult result = world.advance({&drive, 1});
    n_in_their_way +=
        result.status == Status::clamped && result.message.find("in its own way") != std::string::npos ? 1
                                                                                                       : 0;
    EXPECT_LT(result.rounds, 100);
    EXPECT_EQ(world.n_penetrations(), 0);
  }
  EXPECT_GT(n_in_their_way, 0);
}

TEST(StretchedMatterIndependent, NothingComesBetweenTheNodesOfAStretchedBody) {
  for (const char* method : {"coupled", "relaxed"})
    for (const double aside : {0.0, 0.4, 0.8, 1.2, 1.6}) {
      WorldScene scene = empty_world({40, 24}, method);
      scene.objects = {elastic_object("body", {8, 4}, {4.5, 4.5, 0}),
                       test::box_object("tip", ObjectKind::rigid, {1, 1}, {14.1 + aside, 12, 0})};
      scene.objects[0].scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0);
      hold_face(scene.objects[0], 0, false);
      World world(scene);
      Drive pull;
      pull.object = 0;
      pull.nodes = test::face_nodes(scene.objects[0], 0, true);
      pull.motion.by = {1, 0, 0};
      for (int frame = 0; frame < 8; ++frame)
        world.advance({&pull, 1});
      Drive push;
      push.object = 1;
      push.motion.by = {0, -0.5, 0};
      bool has_met = false;
      for (int frame = 0; frame < 10; ++frame) {
        has_met = has_met || !world.advance({&push, 1}).contacts.empty();
        ASSERT_EQ(world.n_penetrations(), 0) << method << ", tip at " << aside << ", frame " << frame;
        ASSERT_EQ(world.n_shared_cells(), 0);
      }
      EXPECT_TRUE(has_met) << method << ", tip at " << aside;
    }
}

} // namespace
} // namespace maille::deform
