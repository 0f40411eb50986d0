#include "feasible/wavefront/wavefront.hpp"

#include "feasible/limits.hpp"
#include "support/bodies/named_bodies.hpp"
#include "support/bodies/holed_bodies.hpp"
#include "support/fields.hpp"
#include "support/quanta.hpp"
#include "support/tiled_state.hpp"

#include <cfloat>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::Dice;
using tests::largest_quantum;
using tests::state_of;

/// Like ASSERT_EQ of the two, but says where they differ.
void expect_same(const Displacement& u, const Displacement& expected) {
  for (std::size_t b = 0; b < u.n_components(); ++b)
    for (std::size_t n = 0; n < u.n_nodes(); ++n)
      ASSERT_EQ(u(b, n), expected(b, n)) << "component " << b << " node " << n;
}

bool are_same(const std::vector<Prescribed>& a, const std::vector<Prescribed>& b) {
  return std::ranges::equal(a, b,
                            [](const Prescribed& p, const Prescribed& q) { return p.value == q.value; });
}

// ---- Dijkstra in the same whole numbers ----

TEST(WavefrontOracle, EqualsDijkstraToTheBitOverThreeDragsOfRandomBodies) {
  int n_cut = 0, n_met = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Dice dice{random};
    Scene scene = tests::holed_body(random);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    tests::StateByDijkstra expected(scene, limits, body);
    for (int drag = 0; drag < 3; ++drag) {
      const std::vector<Prescribed> clipped = body.move(scene.prescribed);
      (are_same(clipped, scene.prescribed) ? n_met : n_cut)++;
      expected.move(body, clipped);
      expect_same(state_of(scene, body), expected.displacement(clipped));
      ASSERT_FALSE(HasFailure()) << "drag " << drag;
      tests::prescribe_at_random(scene, dice); // later drags start from there, and free other nodes
    }
  }
  EXPECT_GE(n_cut, 200); // both kinds of question were asked
  EXPECT_GE(n_met, 200);
}

TEST(WavefrontOracle, EqualsDijkstraToTheBitOnTheNamedBodies) {
  for (const std::string_view name : named_bodies()) {
    SCOPED_TRACE(name);
    const Scene scene = named_body(name, 36);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    tests::StateByDijkstra expected(scene, limits, body);
    const std::vector<Prescribed> clipped = body.move(scene.prescribed);
    EXPECT_TRUE(are_same(clipped, scene.prescribed));
    expected.move(body, clipped);
    expect_same(state_of(scene, body), expected.displacement(clipped));
  }
}

// ---- Dijkstra in metres ----

TEST(WavefrontOracle, IsWithinItsBoundOfTheAnswerInMetres) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = seed % 3 == 0 ? tests::random_body(random) : tests::holed_body(random);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    const std::vector<Prescribed> clipped = body.move(scene.prescribed);
    const Displacement u = state_of(scene, body);
    const double bound = (tests::longest_path(scene) + 2) * largest_quantum(scene, body);
    const std::vector<Prescribed> exact = clip(scene, limits).prescribed;
    for (std::size_t i = 0; i < exact.size(); ++i)
      ASSERT_NEAR(clipped[i].value, exact[i].value, bound); // cut values, too
    Displacement expected(scene.specimen.grid);
    propagate(scene, limits, exact, expected);
    for (int b = 0; b < scene.dimension(); ++b)
      for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n)
        ASSERT_NEAR(u(b, n), expected(b, n), bound) << "node " << n << " component " << b;
  }
}

TEST(WavefrontContract, NoLinkIsOutsideItsLimitsByMoreThanThreeQuanta) {
  double worst_ulp = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Dice dice{random};
    Scene scene = tests::holed_body(random);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    for (int drag = 0; drag < 2; ++drag) {
      const bool is_met = are_same(body.move(scene.prescribed), scene.prescribed);
      const Displacement u = state_of(scene, body);
      ASSERT_LE(tests::worst_violation(scene, limits, u, largest_quantum(scene, body)), 3.001);
      const double largest = test::largest(u);
      if (drag == 0 && is_met && largest > 0)
        worst_ulp = std::max(worst_ulp, tests::worst_violation(scene, limits, u, largest * FLT_EPSILON));
      tests::prescribe_at_random(scene, dice);
    }
  }
  EXPECT_LT(worst_ulp, 0.1); // of the largest displacement, in float32
}

TEST(WavefrontContract, TheNamedBodiesKeepTheirLimitsWhereTheOldOrderBreaksThem) {
  for (const std::string_view name : named_bodies()) {
    const Scene scene = named_body(name, 32);
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    body.move(scene.prescribed);
    EXPECT_LE(tests::worst_violation(scene, limits, state_of(scene, body), body.quantum(0)), 3.001) << name;

    // Enhanced chain mail on the same links; it is no strawman where all paths agree (bore is one material).
    const double quantum = body.quantum(0);
    std::vector<lab::FlatLinks> links;
    std::vector<std::int32_t> target;
    for (int b = 0; b < 3; ++b) {
      links.emplace_back(scene, limits, b, quantum);
      target.push_back(static_cast<std::int32_t>(
          std::floor(scene.prescribed[static_cast<std::size_t>(b)].value / quantum)));
    }
    std::vector<std::vector<std::int32_t>> state(
        3, std::vector<std::int32_t>(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 0));
    const auto outcome = lab::enhanced_chain_mail(links, quantum, state, scene.prescribed[0].node, target);
    const double share = static_cast<double>(outcome.violated_links) / static_cast<double>(outcome.links);
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
    Scene scene = tests::holed_body(random);
    scene.limits = {LimitSource::taut, {}, {}};
    const LinkLimits limits(scene);
    TiledBody body(scene, limits);
    EXPECT_TRUE(are_same(body.move(scene.prescribed), scene.prescribed)) << "seed " << seed;
  }
}

TEST(WavefrontAnalytic, ATautChainIsTheElasticBar) {
  Scene scene = tests::lattice_box({100}, {});
  scene.limits = {LimitSource::taut, {}, {}};
  tests::hold(scene, {0, 0, 0});
  tests::move(scene, {100, 0, 0}, {0.3, 0, 0});
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  EXPECT_TRUE(are_same(body.move(scene.prescribed), scene.prescribed));
  const Displacement u = state_of(scene, body);
  for (std::int64_t n = 0; n <= 100; ++n) // u = by x / length
    EXPECT_NEAR(u(0, n), 0.3 * static_cast<double>(n) / 100, 102 * body.quantum(0));
  EXPECT_EQ(u(0, 100), 0.3); // what is prescribed is met exactly
}

TEST(WavefrontAnalytic, DyadicNumbersAreExact) {
  // A cone of dyadic slopes on a box: bit for bit what limits gives in double precision.
  Scene scene = tests::lattice_box({19, 11, 9}, tests::even_limits(1.25, 0.5, 0.125));
  tests::move(scene, {17, 2, 8}, {-3, 2.75, 1.0625});
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  body.move(scene.prescribed);
  EXPECT_EQ(state_of(scene, body), solve_limits(scene).displacement);
}

TEST(WavefrontAnalytic, BodiesOfOneCellAndOfNoSlackMoveAsAWhole) {
  for (const int dimension : {1, 2, 3})
    for (const int n : {1, 7, 8, 9}) {
      Scene scene = tests::lattice_box({1}, {});
      Index3 cells{1, 1, 1};
      for (int a = 0; a < dimension; ++a)
        cells[static_cast<std::size_t>(a)] = n;
      scene.specimen.grid = Grid(dimension, cells, {1, 1, 1});
      scene.limits.given = tests::even_limits(1, 1, 0);
      tests::move(scene, {n, 0, 0}, {100, -0.3, 1e-9});
      const LinkLimits limits(scene);
      TiledBody body(scene, limits);
      body.move(scene.prescribed);
      const Displacement u = state_of(scene, body);
      for (int b = 0; b < dimension; ++b)
        for (std::int64_t i = 0; i < scene.specimen.grid.n_nodes(); ++i) // in float32 the same number
          ASSERT_EQ(static_cast<float>(u(b, i)),
                    static_cast<float>(std::array{100.0, -0.3, 1e-9}[static_cast<std::size_t>(b)]));
    }
}

// ---- real bodies are in wavefront_data_test.cpp, drags in steps in wavefront_drag_test.cpp ----

} // namespace
} // namespace maille::deform
