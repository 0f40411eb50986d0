#include "maille/scene/fibre/fibre_field.hpp"

#include "maille/scene/read_scene.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

/// A box held at x- and moved at x+, on either lattice.
std::string text(const std::string& fibre, const std::string& lattice,
                 const std::string& cells = "[12, 6, 6]", const std::string& more = "") {
  return fmt::format("[specimen]\nshape = \"box\"\nlattice = \"{}\"\ncells = {}\nspacing = \"1 mm\"\n"
                     "material = \"muscle/soleus\"\nfibre = {}\n[[hold]]\nwhere = \"x-\"\n"
                     "[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n{}",
                     lattice, cells, fibre, more);
}

Vec3 in_world(const Specimen& body, const Vec3& v) {
  return to_world(body.placement, v);
}

std::vector<Fault> faults(const std::string& scene) {
  return test::faults_found_by([&] { parse_scene(scene); });
}

} // namespace

TEST(FibreLatticeContract, FibresAlongXLeaveTheSceneAsItIs) {
  const Scene turned = parse_scene(text("[-1, 0, 0]", "fibre")),
              plain = parse_scene(text("[-1, 0, 0]", "grid"));
  EXPECT_TRUE(turned.specimen.placement.is_identity());
  EXPECT_EQ(turned.specimen.grid.cells(), plain.specimen.grid.cells());
  EXPECT_TRUE(turned.specimen.material_id.empty());
  EXPECT_EQ(turned.prescribed.size(), plain.prescribed.size());
}

TEST(FibreLatticeAnalytic, AQuarterTurnRenamesTheAxes) {
  const Scene plain = parse_scene(text("[0, 0, 1]", "grid", "[12, 6, 4]"));
  const Scene turned = parse_scene(text("[0, 0, 1]", "fibre", "[12, 6, 4]"));
  const Specimen& body = turned.specimen;
  // Truth: the lattice's x is the world's z, its z the world's -x; the same cells, the same conditions.
  EXPECT_EQ(body.grid.cells(), (Index3{4, 6, 12}));
  EXPECT_EQ(body.n_matter_cells(), plain.specimen.n_matter_cells());
  EXPECT_EQ(body.fibre, (Vec3{1, 0, 0}));
  EXPECT_EQ(turned.prescribed.size(), plain.prescribed.size());
  for (const Prescribed& p : turned.prescribed) {
    const Vec3 x = in_world(body, body.position(body.grid.node_at(p.node)));
    EXPECT_NEAR(x[0], p.held ? 0 : 12e-3, 1e-15);
    EXPECT_NEAR(p.value, p.held || p.component != 2 ? 0 : -1e-3, 1e-18);
  }
}

// Truth: the same box with its axes in another order has its cells at the same places.
TEST(FibreLatticeAnalytic, OrderOfAxesChangesNothing) {
  std::mt19937 random(41);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int n = 0; n < 50; ++n) {
    const Vec3 fibre{any(random), any(random), any(random)};
    std::array<std::set<std::array<long, 3>>, 3> places;
    for (std::size_t order = 0; order < 3; ++order) {
      const auto of = [order](const auto& values, std::size_t a) { return values[(a + order) % 3]; };
      const std::array<int, 3> cells{9, 7, 6};
      const Vec3 h{1, 1.5, 2};
      const Specimen body =
          parse_scene(fmt::format("[specimen]\nshape = \"box\"\nlattice = \"fibre\"\ncells = [{}, {}, {}]\n"
                                  "spacing = [\"{} mm\", \"{} mm\", \"{} mm\"]\nmaterial = "
                                  "\"muscle/soleus\"\nfibre = [{}, {}, {}]\n[[hold]]\nwhere = {{ sphere = {{ "
                                  "centre = [0, 0, 0], radius = \"1 m\" }} }}\n",
                                  of(cells, 0), of(cells, 1), of(cells, 2), of(h, 0), of(h, 1), of(h, 2),
                                  of(fibre, 0), of(fibre, 1), of(fibre, 2)))
              .specimen;
      for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
        if (body.is_node(body.grid.node_at(node))) {
          const Vec3 x = in_world(body, body.position(body.grid.node_at(node)));
          places[order].insert({std::lround(1e7 * x[(3 - order) % 3]), std::lround(1e7 * x[(4 - order) % 3]),
                                std::lround(1e7 * x[(5 - order) % 3])});
        }
    }
    EXPECT_EQ(places[0], places[1]) << n;
    EXPECT_EQ(places[0], places[2]) << n;
  }
}

TEST(FibreLatticeAnalytic, FibresRunAlongTheTurnedAxis) {
  for (const double degrees : {5.0, 20.0, 45.0, 70.0, 110.0}) {
    SCOPED_TRACE(degrees);
    const double angle = degrees * std::numbers::pi / 180;
    const Scene scene =
        parse_scene(text(fmt::format("{{ angle = \"{} deg\", plane = \"xz\" }}", degrees), "fibre"));
    const Specimen& body = scene.specimen;
    EXPECT_EQ(std::abs(body.fibre[0]), 1);
    const Vec3 fibre = in_world(body, body.fibre);
    EXPECT_NEAR(fibre[0] * std::cos(angle) + fibre[2] * std::sin(angle), 1, 1e-12);
    // Truth: 12 x 6 x 6 cells of 1 mm^3, and cells counted by their middles are right but for the skin: no
    // more than one layer's tenth is expected of so smooth a body.
    EXPECT_NEAR(static_cast<double>(body.n_matter_cells()), 432, 0.1 * (4 * 72 + 2 * 36));
    // Every node is within half a cell's diagonal of the box.
    for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
      if (!body.is_node(body.grid.node_at(node)))
        continue;
      const Vec3 x = in_world(body, body.position(body.grid.node_at(node)));
      const Vec3 size{12e-3, 6e-3, 6e-3};
      for (std::size_t a = 0; a < 3; ++a) {
        EXPECT_GT(x[a], -0.87e-3);
        EXPECT_LT(x[a], size[a] + 0.87e-3);
      }
    }
  }
}

TEST(FibreLatticeAnalytic, HoldsAndMovesReachHalfASpacingIn) {
  const Scene scene = parse_scene(text("{ angle = \"20 deg\", plane = \"xz\" }", "fibre"));
  const Specimen& body = scene.specimen;
  std::set<std::int64_t> held, moved;
  for (const Prescribed& p : scene.prescribed)
    (p.held ? held : moved).insert(p.node);
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    if (!body.is_node(body.grid.node_at(node)))
      continue;
    const double x = in_world(body, body.position(body.grid.node_at(node)))[0];
    EXPECT_EQ(held.count(node), x <= 0.5e-3 ? 1u : 0u) << x;
    EXPECT_EQ(moved.count(node), x >= 11.5e-3 ? 1u : 0u) << x;
  }
  for (const std::int64_t node : moved) {
    Vec3 by{};
    for (const Prescribed& p : scene.prescribed)
      if (p.node == node)
        by[static_cast<std::size_t>(p.component)] = p.value;
    const Vec3 world = in_world(body, by); // truth: the scene's 1 mm along x
    EXPECT_NEAR(world[0], 1e-3, 1e-15);
    EXPECT_NEAR(world[1], 0, 1e-15);
    EXPECT_NEAR(world[2], 0, 1e-15);
  }
}

TEST(FibreLatticeAnalytic, TurnsAndGravityTurnAlong) {
  const std::string more =
      "turn = { angle = \"30 deg\", axis = [1, 0, 0], about = [0, \"3 mm\", \"3 mm\"] }\n"
      "[[load]]\ngravity = [0, 0, -9.81]\n";
  const Scene scene =
      parse_scene(text("{ angle = \"20 deg\", plane = \"xz\" }", "fibre", "[12, 6, 6]", more));
  const Specimen& body = scene.specimen;
  const Vec3 gravity = in_world(body, scene.gravity);
  EXPECT_NEAR(gravity[0], 0, 1e-14);
  EXPECT_NEAR(gravity[2], -9.81, 1e-14);
  ASSERT_EQ(scene.turns.size(), 1u);
  EXPECT_FALSE(scene.turns[0].nodes.empty());
  for (const std::int64_t node : scene.turns[0].nodes) {
    const Vec3 x = in_world(body, body.position(body.grid.node_at(node)));
    Vec3 u{};
    for (const Prescribed& p : scene.prescribed)
      if (p.node == node)
        u[static_cast<std::size_t>(p.component)] = p.value;
    const Vec3 world = in_world(body, u);
    // Truth: a turn by 30 degrees about a line along x, right-handed, then 1 mm along x.
    const double c = std::cos(std::numbers::pi / 6), s = std::sin(std::numbers::pi / 6);
    const double y = x[1] - 3e-3, z = x[2] - 3e-3;
    EXPECT_NEAR(world[0], 1e-3, 1e-15);
    EXPECT_NEAR(world[1], c * y - s * z - y, 1e-15);
    EXPECT_NEAR(world[2], s * y + c * z - z, 1e-15);
  }
}

TEST(FibreLatticeContract, AMuscleTurnsToItsMeanFibre) {
  const Scene scene = parse_scene(
      "[specimen]\nshape = \"muscle\"\nlattice = \"fibre\"\ncells = [40, 12, 12]\nspacing = \"1 mm\"\n"
      "material = \"muscle/soleus\"\ntendon = { material = \"tendon/tibialis_anterior\" }\n"
      "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n");
  double agreement = 0;
  const Vec3 mean = mean_fibre(scene.specimen, agreement);
  EXPECT_NEAR(mean[0], 1, 1e-6) << "the mean of the turned fibres";
  EXPECT_GT(agreement, 0.95);
  const Vec3 axis = in_world(scene.specimen, {1, 0, 0});
  EXPECT_NEAR(axis[1], 0, 1e-6);
  EXPECT_GT(std::atan2(axis[2], axis[0]),
            14 * std::numbers::pi / 180); // between the tendons' 0 and the belly's 20 degrees
  EXPECT_LT(std::atan2(axis[2], axis[0]), 20 * std::numbers::pi / 180);
}

TEST(FibreLatticeContract, WhatItCannotTurnIsRefusedAtItsLine) {
  const std::string at20 = "{ angle = \"20 deg\", plane = \"xz\" }";
  const auto refused = [](const std::string& scene, const std::string& words) {
    EXPECT_TRUE(test::says_only(faults(scene), {.line = 3, .key = "specimen.lattice"}));
    EXPECT_TRUE(test::has(to_string(faults(scene).front()), words));
  };
  refused(text(at20, "fibre", "[12, 6, 6]", "[[load]]\nwhere = \"z+\"\ntraction = [0, 0, 1]\n"), "traction");
  refused(text(at20, "fibre", "[12, 6, 6]", "axes = \"x\"\n"), "single axes");
  refused(text(at20, "fibre", "[12, 6]"), "fibres in the plane of the scene");
  refused("[specimen]\nshape = \"box\"\nlattice = \"fibre\"\ncells = 12\nspacing = \"1 mm\"\n"
          "material = \"muscle/soleus\"\n[[hold]]\nwhere = \"x-\"\n",
          "a line, which has nothing to turn");
  // Rotation breaks a layer one cell thick into crumbs.
  refused(text("{ angle = \"45 deg\", plane = \"xz\" }", "fibre", "[30, 10, 1]"), "hang together");
  // A turn within x and z leaves y an axis.
  EXPECT_EQ(faults(text(at20, "fibre", "[12, 6, 6]", "[[hold]]\nwhere = \"z-\"\naxes = \"y\"\n")).size(), 0u);
  EXPECT_TRUE(test::says_only(faults(text(at20, "fiber")), {.key = "specimen.lattice"}));
}

TEST(FibreLatticeAnalytic, AHoldWithoutANodeIsRefused) {
  const std::string at20 = "{ angle = \"20 deg\", plane = \"xz\" }";
  const Scene plain = parse_scene(text(at20, "fibre"));
  const Specimen& body = plain.specimen;
  int n_met = 0, n_refused = 0;
  for (int place = 0; place < 45; ++place) {
    const int i = 2 + place % 9, k = 1 + place / 9;
    bool is_met = false; // truth: a node of the turned body within half a spacing along each axis
    for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node)
      if (body.is_node(body.grid.node_at(node))) {
        const Vec3 x = in_world(body, body.position(body.grid.node_at(node)));
        is_met = is_met || (std::abs(x[0] - 1e-3 * i) < 0.5e-3 && std::abs(x[1] - 3e-3) < 0.5e-3 &&
                            std::abs(x[2] - 1e-3 * k) < 0.5e-3);
      }
    const auto found = faults(text(at20, "fibre", "[12, 6, 6]",
                                   fmt::format("[[hold]]\nwhere = {{ box = [[\"{0} mm\", \"3 mm\", \"{1} "
                                               "mm\"], [\"{0} mm\", \"3 mm\", \"{1} mm\"]] }}\n",
                                               i, k)));
    EXPECT_EQ(found.empty(), is_met) << i << " " << k;
    (is_met ? n_met : n_refused) += 1;
  }
  EXPECT_GT(n_met, 0);
  EXPECT_GT(n_refused, 0);
}

} // namespace maille
