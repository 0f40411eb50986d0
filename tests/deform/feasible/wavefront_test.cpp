#include "feasible/forecast.hpp"
#include "feasible/limits.hpp"
#include "feasible/wavefront/wavefront.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/holed_bodies.hpp"
#include "support/bodies/named_bodies.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/quanta.hpp"
#include "support/tiled_state.hpp"
#include "support/worlds/all_paths.hpp"

#include <cfloat>

namespace maille::deform {
namespace {

using test::Dice;
using test::largest_quantum;
using test::state_of;

bool are_same(const std::vector<Prescribed>& a, const std::vector<Prescribed>& b) {
  return std::ranges::equal(a, b,
                            [](const Prescribed& p, const Prescribed& q) { return p.value == q.value; });
}

// ---- Dijkstra in the same whole numbers ----

/// Drags, each from where the one before ended. @return how many requests were met
int expect_dijkstra(Scene scene, std::mt19937& random, int drags = 3) {
  Dice dice{random};
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  test::StateByDijkstra expected(scene, limits, body);
  int n_met = 0;
  for (int drag = 0; drag < drags && !testing::Test::HasFailure(); ++drag) {
    const std::vector<Prescribed> clipped = body.move(scene.prescribed);
    n_met += are_same(clipped, scene.prescribed) ? 1 : 0;
    expected.move(body, clipped);
    EXPECT_EQ(state_of(scene, body), expected.displacement(clipped)) << "drag " << drag;
    test::prescribe_at_random(scene, dice); // later drags start from there, and free other nodes
  }
  return n_met;
}

TEST(WavefrontOracle, EqualsDijkstraToTheBitOverThreeDragsOfRandomBodies) {
  int n_met = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = test::holed_body(random);
    n_met += expect_dijkstra(scene, random);
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GE(n_met, 200); // both kinds of question were asked
  EXPECT_LE(n_met, 1000);
}

TEST(WavefrontOracle, EqualsDijkstraToTheBitOnTheNamedBodies) {
  std::mt19937 random(1);
  for (const std::string_view name : named_bodies()) {
    SCOPED_TRACE(name);
    EXPECT_EQ(expect_dijkstra(named_body(name, 36), random, 1), 1);
  }
}

// ---- Dijkstra in metres ----

TEST(WavefrontOracle, IsWithinItsBoundOfTheAnswerInMetres) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = seed % 3 == 0 ? test::random_body(random) : test::holed_body(random);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    const std::vector<Prescribed> clipped = body.move(scene.prescribed);
    const Displacement u = state_of(scene, body);
    const double bound = (test::longest_path(scene) + 2) * largest_quantum(scene, body);
    const std::vector<Prescribed> exact = clip(scene, limits).prescribed;
    for (std::size_t i = 0; i < exact.size(); ++i)
      ASSERT_NEAR(clipped[i].value, exact[i].value, bound); // cut values, too
    Displacement expected(scene.specimen.grid);
    propagate(scene, limits, exact, expected);
    ASSERT_LE(test::largest_difference(u, expected), bound);
  }
}

TEST(WavefrontContract, NoLinkIsOutsideItsLimitsByMoreThanThreeQuanta) {
  double worst_ulp = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    auto [random, scene, limits, body] = test::HoledTiles(seed);
    Dice dice{random};
    for (int drag = 0; drag < 2; ++drag) {
      const bool is_met = are_same(body.move(scene.prescribed), scene.prescribed);
      const Displacement u = state_of(scene, body);
      ASSERT_LE(test::worst_violation(scene, limits, u, largest_quantum(scene, body)), 3.001);
      const double largest = test::largest(u);
      if (drag == 0 && is_met && largest > 0)
        worst_ulp = std::max(worst_ulp, test::worst_violation(scene, limits, u, largest * FLT_EPSILON));
      test::prescribe_at_random(scene, dice);
    }
  }
  EXPECT_LT(worst_ulp, 0.1); // of the largest displacement, in float32
}

TEST(WavefrontContract, NamedBodiesKeepTheirLimits) {
  for (const std::string_view name : named_bodies()) {
    const Scene scene = named_body(name, 32);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    body.move(scene.prescribed);
    EXPECT_LE(test::worst_violation(scene, limits, state_of(scene, body), body.quantum(0)), 3.001) << name;

    // Enhanced chain mail on the same links; it is no strawman where all paths agree (bore is one material).
    const double quantum = body.quantum(0);
    std::vector<lab::FlatLinks> links;
    std::vector<std::int32_t> target;
    for (int b = 0; b < 3; ++b) {
      links.emplace_back(scene, limits, b, quantum);
      target.push_back(
          static_cast<std::int32_t>(std::floor(scene.prescribed[std::size_t(b)].value / quantum)));
    }
    std::vector<std::vector<std::int32_t>> state(
        3, std::vector<std::int32_t>(std::size_t(scene.specimen.grid.n_nodes()), 0));
    const auto outcome = lab::enhanced_chain_mail(links, quantum, state, scene.prescribed[0].node, target);
    const double share = double(outcome.violated_links) / double(outcome.links);
    if (name == "bore")
      EXPECT_LT(share, 0.01);
    else
      EXPECT_GT(share, 0.02) << name;
  }
}

// ---- what is clipped ----

TEST(WavefrontContract, PermitsEverythingThatTautLimitsJustAllow) {
  // Taut limits have the very slack that the scene uses: nothing may be lost to rounding.
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::holed_body(random);
    scene.limits = {LimitSource::taut, {}, {}};
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    EXPECT_TRUE(are_same(body.move(scene.prescribed), scene.prescribed)) << "seed " << seed;
  }
}

TEST(WavefrontAnalytic, DyadicNumbersAreExact) {
  // A cone of dyadic slopes on a box: bit for bit what limits gives in double precision.
  Scene scene = test::lattice_box({19, 11, 9}, test::even_limits(1.25, 0.5, 0.125));
  test::move(scene, {17, 2, 8}, {-3, 2.75, 1.0625});
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  body.move(scene.prescribed);
  EXPECT_EQ(state_of(scene, body), solve_limits(scene).displacement);
}

TEST(WavefrontAnalytic, BodiesOfOneCellAndOfNoSlackMoveAsAWhole) {
  for (const int dimension : {1, 2, 3})
    for (const int n : {1, 7, 8, 9}) {
      Scene scene = test::lattice_box({1}, {});
      Index3 cells{1, 1, 1};
      for (int a = 0; a < dimension; ++a)
        cells[std::size_t(a)] = n;
      scene.specimen.grid = Grid(dimension, cells, {1, 1, 1});
      scene.limits.given = test::even_limits(1, 1, 0);
      test::move(scene, {n, 0, 0}, {100, -0.3, 1e-9});
      const LinkLimits limits(scene);
      TiledBody body(scene, limits);
      body.move(scene.prescribed);
      const Displacement u = state_of(scene, body);
      for (int b = 0; b < dimension; ++b)
        for (std::int64_t i = 0; i < scene.specimen.grid.n_nodes(); ++i) // in float32 the same number
          ASSERT_EQ(float(u(b, i)), float(std::array{100.0, -0.3, 1e-9}[std::size_t(b)]));
    }
}

// ---- real bodies are in wavefront_test.cpp, drags in steps in wavefront_drag_test.cpp ----

/// The wavefront on bodies that are one node or one cell thick along some axis.

/// Three materials of random limits, in cells of a grid of that size; holes in a third of the bodies.
Scene flat_body(std::mt19937& random, int dimension, const Index3& cells) {
  Dice dice{random};
  Scene scene = test::lattice_box({1}, {});
  scene.specimen.grid = Grid(dimension, cells, {1, 0.5, 0.75});
  scene.limits.from = LimitSource::material;
  scene.materials.assign(3, scene.materials[0]);
  for (Material& material : scene.materials)
    material.limits = test::uneven_limits(dice);
  auto& kinds = scene.specimen.material_id;
  kinds.resize(std::size_t(scene.specimen.grid.n_cells()));
  const int holes = dice.below(3) == 0 ? 20 : 0; // percent
  for (auto& kind : kinds)
    kind = dice.below(100) < holes ? no_material : std::uint8_t(dice.below(3));
  kinds[0] = 0;
  test::prescribe_at_random(scene, dice);
  return scene;
}

TEST(WavefrontFlatOracle, EqualsDijkstraToTheBitHoweverThinTheBodyIs) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    Dice dice{random};
    const int n = 1 + dice.below(40), m = 1 + dice.below(20), thin = 1 + dice.below(8);
    const std::vector<std::pair<int, Index3>> shapes{
        {1, {n, 1, 1}},    {2, {n, m, 1}},    {2, {1, n, 1}},    {2, {n, 1, 1}}, // 1D and 2D
        {3, {n, m, 1}},    {3, {n, 1, m}},    {3, {1, n, m}},                    // sheets of one cell
        {3, {n, 1, 1}},    {3, {1, n, 1}},    {3, {1, 1, n}},    {3, {1, 1, 1}}, // strands of one cell
        {3, {n, m, thin}}, {3, {n, thin, m}}, {3, {thin, n, m}},
    };
    for (const auto& [dimension, cells] : shapes) {
      SCOPED_TRACE(testing::Message() << "seed " << seed << " " << dimension << "D, " << cells[0] << " x "
                                      << cells[1] << " x " << cells[2] << " cells");
      expect_dijkstra(flat_body(random, dimension, cells), random);
      ASSERT_FALSE(HasFailure());
    }
  }
}

TEST(WavefrontFlatContract, ABodyThatIsThinAlongZHoldsNoMoreLayersThanItNeeds) {
  const auto bytes_of_values = [](int thickness) {
    const Scene scene = test::lattice_box({63, 63, thickness}, test::even_limits(1.25, 0.75, 0.25));
    for (const ArrayBytes& array : forecast_of_tiles(scene, LinkLimits(scene)))
      if (array.name == "displacement")
        return array.bytes;
    return std::int64_t{-1};
  };
  // 64 x 64 nodes and 3 components of 4 bytes, times the layers: a power of two.
  const std::int64_t layer = 64 * 64 * 3 * 4;
  EXPECT_EQ(bytes_of_values(1), 2 * layer);
  EXPECT_EQ(bytes_of_values(3), 4 * layer);
  EXPECT_EQ(bytes_of_values(4), 8 * layer);
  EXPECT_EQ(bytes_of_values(8), 16 * layer);
}

// Calves from MRI: bodies of many materials, with surfaces that no box has.

void expect_agreement(const char* file) {
  const Scene scene = read_scene(std::string(MAILLE_SCENES) + "/" + file);
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  const std::vector<Prescribed> clipped = body.move(scene.prescribed);
  const Displacement u = state_of(scene, body);
  const Answer by_dijkstra = solve_limits(scene);
  ASSERT_EQ(by_dijkstra.status, Status::done) << by_dijkstra.message;
  const Index3 n = scene.specimen.grid.nodes();
  for (std::size_t i = 0; i < clipped.size(); ++i)
    ASSERT_EQ(clipped[i].value, scene.prescribed[i].value); // all that Dijkstra permits
  for (int b = 0; b < 3; ++b) {
    // Within (k + 2) quanta; a path through a muscle has no more links than twice the sum of the box's edges.
    const double bound = (2 * (n[0] + n[1] + n[2]) + 2) * body.quantum(b);
    for (std::int64_t i = 0; i < scene.specimen.grid.n_nodes(); ++i)
      ASSERT_NEAR(u(b, i), by_dijkstra.displacement(b, i), bound) << "node " << i << " component " << b;
    if (b == 2) { // the one that moves
      EXPECT_LE(bound, 2e-6 * scene.largest_prescribed()) << "the comparison would say nothing";
    }
  }
  EXPECT_LE(test::worst_violation(scene, limits, u, largest_quantum(scene, body)), 3.001);
}

TEST(WavefrontCalfData, AgreeWithDijkstra) {
  if (!std::getenv("MAILLE_DATA"))
    GTEST_SKIP() << "MAILLE_DATA is not set: no real volumes to read";
  for (const char* file : {"calf_soleus.toml", "calf_both_legs.toml"})
    expect_agreement(file);
}

// ---- the nearest feasible state ----

TEST(WavefrontProjectionOracle, NoFeasibleStateIsNearerInTheLargestDifference) {
  // Theorem 5: the distance is half the largest amount by which two values contradict each other.
  for (unsigned seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Dice dice{random};
    Scene scene = test::random_body(random);
    const LinkLimits limits(scene);
    Displacement wanted(scene.specimen.grid);
    for (const std::int64_t node : test::matter_nodes(scene))
      for (int b = 0; b < scene.dimension(); ++b)
        wanted(b, node) = 2 * dice.uniform() - 1;
    TiledBody body(scene, limits);
    const double change = body.set_state(wanted);
    const Displacement projected = state_of(scene, body);
    const double q = largest_quantum(scene, body);
    EXPECT_LE(test::worst_violation(scene, limits, projected, q), 1.001);
    double nearest = 0;
    for (int b = 0; b < scene.dimension(); ++b) {
      const test::AllPaths paths(scene, limits, b);
      for (const std::int64_t i : test::matter_nodes(scene))
        for (const std::int64_t j : test::matter_nodes(scene))
          nearest = std::max(nearest, (wanted(b, j) - wanted(b, i) - paths(i, j)) / 2);
    }
    EXPECT_NEAR(change, nearest, (test::longest_path(scene) + 2) * q);
    for (int b = 0; b < scene.dimension(); ++b)
      for (const std::int64_t node : test::matter_nodes(scene))
        EXPECT_LE(std::abs(projected(b, node) - wanted(b, node)), change + 2 * q);
  }
}

TEST(WavefrontProjectionContract, AFeasibleStateIsTakenAsItIs) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    auto [random, scene, limits, body] = test::HoledTiles(seed);
    TiledBody other(scene, limits);
    body.move(scene.prescribed);
    body.raise(0, {}); // what was prescribed is no longer shown at its exact value, but in whole quanta
    const Displacement state = state_of(scene, body);
    // A body whose quanta have grown on the way is feasible in those, which are coarser.
    bool has_grown = false;
    for (int b = 0; b < scene.dimension(); ++b)
      has_grown = has_grown || other.quantum(b) != body.quantum(b);
    EXPECT_LE(other.set_state(state),
              has_grown ? test::longest_path(scene) * largest_quantum(scene, body) : 0)
        << "seed " << seed;
    for (std::size_t b = 0; b < state.n_components(); ++b)
      if (other.quantum(int(b)) == body.quantum(int(b))) {
        EXPECT_TRUE(std::ranges::equal(state_of(scene, other).component(b), state.component(b)))
            << "seed " << seed;
      }
  }
}

} // namespace
} // namespace maille::deform
