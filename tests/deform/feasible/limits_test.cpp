#include "feasible/limits.hpp"
#include "oracle/literal.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/worlds/all_paths.hpp"

namespace maille::deform {
namespace {

using test::AllPaths;
using test::even_limits;
using test::hold;
using test::lattice_box;
using test::move;

constexpr double ulp = std::numeric_limits<double>::epsilon();

// ---- a drag of a resting box: a cone with one slope per axis (docs/theory.md, Theorem 2) ----

/// Slack that a node at offset `o` from the handle has along `axis` when component `b` of the handle moves by
/// `by`: what lies ahead is compressed, what lies behind is stretched, what lies beside is sheared.
double slack(const NeighbourLimits& limits, std::size_t axis, std::size_t b, int o, double by) {
  if (axis != b)
    return limits.shear[axis][b];
  const bool is_ahead = (o > 0) == (by > 0);
  return is_ahead ? 1 - limits.compress[axis] : limits.stretch[axis] - 1;
}

void expect_cone(Scene scene, const Index3& handle, const Vec3& by) {
  move(scene, handle, by);
  const Answer answer = solve_limits(scene);
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n) {
    const Index3 at = grid.node_at(n);
    for (std::size_t b = 0; b < static_cast<std::size_t>(grid.dimension()); ++b) {
      double length = std::abs(by[b]);
      for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a) {
        const int o = at[a] - handle[a];
        length -= std::abs(o) * slack(scene.limits.given, a, b, o, by[b]);
      }
      // Analytic, and exact: all numbers are dyadic.
      EXPECT_EQ(answer.displacement(static_cast<int>(b), n), std::copysign(std::max(0.0, length), by[b]))
          << "node " << n << " component " << b;
    }
  }
}

/// Another dyadic slack for every direction.
NeighbourLimits uneven_limits() {
  NeighbourLimits limits;
  limits.stretch = {1.25, 1.5, 1.125};
  limits.compress = {0.5, 0.875, 0.75};
  limits.shear = {{{0, 0.25, 0.5}, {0.375, 0, 0.125}, {0.0625, 0.75, 0}}};
  return limits;
}

TEST(LimitsConeAnalytic, HasOneSlopeAnAxisInAnyDimension) {
  for (const double by : {3.0, -3.0, 0.125})
    expect_cone(lattice_box({20}, uneven_limits()), {8, 0, 0}, {by, 0, 0});
  expect_cone(lattice_box({9, 7}, uneven_limits()), {3, 5, 0}, {1.5, -2.25, 0});
  expect_cone(lattice_box({6, 5, 7}, uneven_limits()), {2, 0, 4}, {-1.75, 2, 1.0625});
}

TEST(LimitsConeAnalytic, ARigidBodyMovesAsAWhole) {
  Scene scene = lattice_box({3, 4, 2}, even_limits(1, 1, 0));
  move(scene, {1, 4, 0}, {100, -0.3, 1e-9});
  const Answer answer = solve_limits(scene);
  for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n) {
    EXPECT_EQ(answer.displacement(0, n), 100);
    EXPECT_EQ(answer.displacement(1, n), -0.3);
    EXPECT_EQ(answer.displacement(2, n), 1e-9);
  }
}

// ---- taut chains are linear-elastic bars ----

TEST(LimitsTautChainAnalytic, IsTheElasticBar) {
  Scene scene = lattice_box({100}, {});
  scene.limits = {}; // taut
  hold(scene, {0, 0, 0});
  move(scene, {100, 0, 0}, {0.3, 0, 0});
  const Answer answer = solve_limits(scene);
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  for (std::int64_t n = 0; n <= 100; ++n) // u = by x / length; rounding: one ulp per link
    EXPECT_NEAR(answer.displacement(0, n), 0.3 * static_cast<double>(n) / 100, 100 * ulp * 0.3);
}

TEST(LimitsTautChainAnalytic, MaterialsInSeriesShareTheStretchByTheirCompliance) {
  Scene scene = lattice_box({60}, {});
  scene.limits = {};
  scene.materials.push_back(scene.materials[0]);
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, 0.3);
  scene.materials[1].elasticity = ElasticConstants::isotropic(70e3, 0.45);
  scene.specimen.material_id.assign(60, 0);
  std::fill(scene.specimen.material_id.begin() + 25, scene.specimen.material_id.end(), std::uint8_t{1});
  hold(scene, {0, 0, 0});
  move(scene, {60, 0, 0}, {-0.7, 0, 0});
  const Answer answer = solve_limits(scene);
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  const double compliance = 25 / 10e3 + 35 / 70e3; // of the whole bar, cross-section 1
  for (std::int64_t n = 0; n <= 60; ++n) {
    const double soft = static_cast<double>(std::min<std::int64_t>(n, 25)) / 10e3;
    const double stiff = static_cast<double>(std::max<std::int64_t>(n - 25, 0)) / 70e3;
    EXPECT_NEAR(answer.displacement(0, n), -0.7 * (soft + stiff) / compliance, 60 * ulp * 0.7);
  }
}

// ---- nothing moves that need not ----

TEST(LimitsAnalytic, AHandleWithinItsLinksSlackMovesNothingElse) {
  Scene scene = lattice_box({5, 4, 3}, even_limits(1.25, 0.75, 0.25));
  move(scene, {2, 2, 1}, {0.25, -0.25, 0.125});
  const Answer answer = solve_limits(scene);
  Displacement expected(scene.specimen.grid);
  for (const Prescribed& p : scene.prescribed)
    expected(p.component, p.node) = p.value;
  EXPECT_EQ(answer.displacement, expected);
}

TEST(LimitsAnalytic, AnAffineStateWithinTheLimitsStays) {
  // u = G x with |G| below every slack; one corner is then dragged by less than its links have left.
  Scene scene = lattice_box({4, 5, 3}, even_limits(1.25, 0.75, 0.25));
  const double G[3][3] = {{0.125, -0.0625, 0.03125}, {0.0625, -0.125, 0.125}, {0, 0.125, 0.0625}};
  const Grid& grid = scene.specimen.grid;
  Displacement affine(grid);
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n)
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t a = 0; a < 3; ++a)
        affine(static_cast<int>(b), n) += G[b][a] * grid.node_at(n)[a];
  const std::int64_t corner = grid.node({4, 5, 3});
  for (int b = 0; b < 3; ++b) {
    test::prescribe(scene, grid.node({0, 0, 0}), b, 0, true);
    test::prescribe(scene, corner, b, affine(b, corner) + 0.0625, false);
  }
  Displacement expected = affine;
  for (int b = 0; b < 3; ++b)
    expected(b, corner) += 0.0625;
  const LinkLimits limits(scene);
  EXPECT_EQ(drag_limits(scene, limits, affine).displacement, expected);
}

// ---- the obvious version: all pairs of nodes ----

TEST(LimitsOracle, EqualsAllPairsOfPathsOnRandomBodies) {
  int n_clamped = 0, n_done = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = test::random_body(random);
    const LinkLimits limits(scene);
    const Answer answer = solve_limits(scene);
    ASSERT_TRUE(answer.status == Status::done || answer.status == Status::clamped);
    (answer.status == Status::done ? n_done : n_clamped)++;
    const std::vector<Prescribed> clipped = clip(scene, limits).prescribed;
    for (int b = 0; b < scene.dimension(); ++b) {
      const AllPaths paths(scene, limits, b);
      std::vector<Prescribed> ends = clipped;
      std::erase_if(ends, [&](const Prescribed& p) { return p.component != b; });
      for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n) {
        const double expected = std::min(std::max(0.0, paths.lowest(ends, n)), paths.highest(ends, n));
        EXPECT_NEAR(answer.displacement(b, n), expected, 100 * ulp * 2);
      }
    }
    EXPECT_LE(largest_violation(scene, limits, answer.displacement), 100 * ulp * 2);
  }
  EXPECT_GE(n_clamped, 50); // the scenes ask both kinds of question
  EXPECT_GE(n_done, 50);
}

TEST(LimitsConsistent, TheOrderOfHandlesChangesNoBit) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::random_body(random);
    const Answer answer = solve_limits(scene);
    for (int i = 0; i < 5; ++i) {
      std::ranges::shuffle(scene.prescribed, random);
      const Answer again = solve_limits(scene);
      ASSERT_EQ(again.displacement, answer.displacement) << "seed " << seed;
      ASSERT_EQ(again.status, answer.status);
    }
  }
}

// ---- drags in steps ----

TEST(LimitsAnalytic, ADragOutAndBackLeavesTheBodyStretched) {
  // The model is plastic: a chain pulled out by 3 and pushed back to 0 stays where the way back left it.
  Scene scene = lattice_box({4}, even_limits(1.5, 0.5, 0));
  const LinkLimits limits(scene);
  move(scene, {4, 0, 0}, {3, 0, 0});
  const Displacement out = drag_limits(scene, limits, Displacement(scene.specimen.grid)).displacement;
  move(scene, {4, 0, 0}, {0, 0, 0});
  const Displacement back = drag_limits(scene, limits, out).displacement;
  EXPECT_TRUE(std::ranges::equal(out.component(0), (std::vector<double>{1, 1.5, 2, 2.5, 3})));
  EXPECT_TRUE(std::ranges::equal(back.component(0), (std::vector<double>{1, 1.5, 1, 0.5, 0})));
}

TEST(ClippingAnalytic, AHeldChainEndsWhereItsSlackEnds) {
  for (const double by : {1e-300, 2.5, 1e300, -1.25, -1e300}) {
    Scene scene = lattice_box({10}, even_limits(1.25, 0.875, 0));
    hold(scene, {0, 0, 0});
    move(scene, {10, 0, 0}, {by, 0, 0});
    const double end = std::clamp(by, -10 * 0.125, 10 * 0.25); // ten links' slack, exactly
    const Answer answer = solve_limits(scene);
    EXPECT_EQ(answer.displacement(0, 10), end);
    EXPECT_EQ(answer.displacement(0, 0), 0);
    EXPECT_EQ(answer.status, end == by ? Status::done : Status::clamped);
    EXPECT_EQ(answer.message.empty(), end == by) << answer.message;
    for (int n = 0; end != by && n <= 10; ++n) // a taut chain is a ramp
      EXPECT_EQ(answer.displacement(0, n), end * n / 10);
  }
}

TEST(ClippingContract, TheMessageSaysHowManyHowMuchAndWhere) {
  Scene scene = lattice_box({4, 2}, even_limits(1.25, 0.75, 0.25));
  scene.specimen.grid = Grid(2, {4, 2, 1}, {0.5, 0.5, 1});
  scene.specimen.origin = {1, 2, 0};
  hold(scene, {0, 0, 0});
  move(scene, {4, 0, 0}, {0.25, 0, 0});
  move(scene, {4, 2, 0}, {0, 1.5, 0}); // 4 links sheared and 2 stretched, 0.125 each
  // The hold leaves (4, 2) at most 0.75 along y; (4, 0), asked to stay, at most 0.25 from it: 0.5 too much,
  // so they meet at 0.25 and 0.5.
  const Answer answer = solve_limits(scene);
  EXPECT_EQ(answer.status, Status::clamped);
  EXPECT_EQ(answer.message,
            "the limits permit only part of 2 of 4 moved components: the largest cut is 1 m, "
            "along y at the node at (3, 3, 0) m; [limits] cut = \"allowed\" would take that for an answer");
  EXPECT_EQ(answer.displacement(1, scene.specimen.grid.node({4, 0, 0})), 0.25);
  EXPECT_EQ(answer.displacement(1, scene.specimen.grid.node({4, 2, 0})), 0.5);
}

TEST(ClippingAnalytic, ContradictoryMovesMeetHalfWay) {
  // Ten links stretch by 0.25 each: 2.5 in all, asked for 4 + 2 = 6, so each end gives 1.75 back.
  Scene scene = lattice_box({10}, even_limits(1.25, 0.75, 0));
  move(scene, {0, 0, 0}, {-4, 0, 0});
  move(scene, {10, 0, 0}, {2, 0, 0});
  const Clipping clipping = clip(scene, LinkLimits(scene));
  EXPECT_EQ(clipping.n_cut, 2);
  EXPECT_EQ(clipping.largest_cut, 1.75);
  EXPECT_EQ(clipping.prescribed[0].value, -2.25);
  EXPECT_EQ(clipping.prescribed[1].value, 0.25);
}

TEST(ClippingAnalytic, MirroredRequestsGetMirroredAnswers) {
  Scene scene = lattice_box({7, 7}, even_limits(1.25, 0.75, 0.125));
  hold(scene, {3, 3, 0});
  move(scene, {0, 0, 0}, {-9, -9, 0});
  move(scene, {7, 7, 0}, {9, 9, 0});
  move(scene, {7, 0, 0}, {9, -9, 0});
  move(scene, {0, 7, 0}, {-9, 9, 0});
  const Answer answer = solve_limits(scene);
  EXPECT_EQ(answer.status, Status::clamped);
  // Exchanging x and y maps the scene onto itself.
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n) {
    const Index3 at = grid.node_at(n);
    EXPECT_EQ(answer.displacement(0, n), answer.displacement(1, grid.node({at[1], at[0], 0})));
  }
}

TEST(ClippingAnalytic, RequestsThatCanBeMetAreKeptToTheBit) {
  // A taut scene asks for exactly what its slack allows; its sums are rounded, the request is not cut.
  for (const int n : {3, 7, 100, 3001}) {
    Scene scene = lattice_box({n}, {});
    scene.limits = {};
    hold(scene, {0, 0, 0});
    move(scene, {n, 0, 0}, {0.1, 0, 0});
    const Answer answer = solve_limits(scene);
    EXPECT_EQ(answer.status, Status::done) << n << answer.message;
    EXPECT_EQ(answer.displacement(0, n), 0.1);
  }
}

TEST(ClippingAnalytic, ARequestJustBeyondRoundingIsCut) {
  Scene scene = lattice_box({10}, even_limits(1.25, 0.75, 0));
  hold(scene, {0, 0, 0});
  move(scene, {10, 0, 0}, {2.5 * (1 + 1e-13), 0, 0});
  EXPECT_EQ(solve_limits(scene).status, Status::clamped);
  move(scene, {10, 0, 0}, {2.5 * (1 + 1e-15), 0, 0}); // within the stated 20 half-ulps of ten links
  EXPECT_EQ(solve_limits(scene).status, Status::done);
}

/// What clip_component promises, pair by pair.
void expect_nearest(const Scene& scene, const LinkLimits& limits, int component, const Clipping& clipping) {
  const AllPaths paths(scene, limits, component);
  std::vector<Prescribed> requested, clipped, holds;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    if (scene.prescribed[i].component != component)
      continue;
    requested.push_back(scene.prescribed[i]);
    clipped.push_back(clipping.prescribed[i]);
    if (scene.prescribed[i].held)
      holds.push_back(scene.prescribed[i]);
  }
  EXPECT_LE(paths.worst_contradiction(clipped), 200 * ulp);
  // The nearest feasible values to requests cut at the holds miss them by half the worst contradiction.
  std::vector<Prescribed> within_holds = requested;
  for (Prescribed& p : within_holds)
    p.value = std::min(std::max(p.value, paths.lowest(holds, p.node)), paths.highest(holds, p.node));
  double largest_change = 0;
  for (std::size_t i = 0; i < clipped.size(); ++i) {
    const double change = std::abs(clipped[i].value - within_holds[i].value);
    largest_change = std::max(largest_change, change);
    if (requested[i].held) {
      EXPECT_EQ(clipped[i].value, 0);
    }
  }
  std::vector<Prescribed> moves = within_holds;
  std::erase_if(moves, [](const Prescribed& p) { return p.held; });
  EXPECT_NEAR(largest_change, 0.5 * std::max(0.0, paths.worst_contradiction(moves)), 200 * ulp);
}

TEST(ClippingOracle, IsFeasibleAndNearestOnRandomBodies) {
  int n_cut = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = test::random_body(random);
    const LinkLimits limits(scene);
    const Clipping clipping = clip(scene, limits);
    n_cut += clipping.n_cut > 0 ? 1 : 0;
    for (int b = 0; b < scene.dimension(); ++b)
      expect_nearest(scene, limits, b, clipping);
  }
  EXPECT_GE(n_cut, 50);
}

/// A box of random size and dimension with random dyadic limits, one node dragged by multiples of 1/16.
Scene random_drag(std::mt19937& random, int dimension) {
  Scene scene = lattice_box({1}, test::random_dyadic_limits(random));
  Index3 cells{1, 1, 1}, handle{0, 0, 0};
  Vec3 by{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a) {
    cells[a] = 1 + test::below(random, dimension == 1 ? 40 : dimension == 2 ? 20 : 9);
    handle[a] = test::below(random, cells[a] + 1);
    by[a] = (test::below(random, 161) - 80) / 16.0;
  }
  scene.specimen.grid = Grid(dimension, cells, {1, 0.5, 2});
  move(scene, handle, by);
  return scene;
}

TEST(LiteralOracle, EqualsLimitsToTheBitOnABoxWithOneHandle) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (unsigned seed = 1; seed <= 40; ++seed) {
      std::mt19937 random(seed);
      const Scene scene = random_drag(random, dimension);
      const Answer literal = solve_literal(scene);
      ASSERT_EQ(literal.displacement, solve_limits(scene).displacement) << dimension << "D, seed " << seed;
      EXPECT_EQ(literal.message, "");
      EXPECT_EQ(literal.status, Status::done);
    }
}

TEST(LiteralContract, CountsTheLinksThatItLeavesBroken) {
  // A slot: the way from the handle to the far side of it is longer than what the lists follow.
  Scene slotted = test::slotted_sheet();
  move(slotted, {0, 9, 0}, {-3, 3, 0});
  const Answer answer = solve_literal(slotted);
  EXPECT_EQ(answer.status, Status::done);
  const LinkLimits limits(slotted);
  const double worst = largest_violation(slotted, limits, answer.displacement);
  EXPECT_GT(worst, 0.1);
  EXPECT_TRUE(test::has(answer.message, "outside their limits"));
  EXPECT_LE(largest_violation(slotted, limits, solve_limits(slotted).displacement), 1e-15);
}

TEST(LiteralContract, PrescribedComponentsStayWhereTheyWerePut) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    const Scene scene = test::random_body(random);
    const Answer answer = solve_literal(scene);
    for (const Prescribed& p : scene.prescribed)
      EXPECT_EQ(answer.displacement(p.component, p.node), p.value) << "seed " << seed;
  }
}

TEST(LiteralContract, VisitsEveryNodeOfABoxOnce) {
  Scene scene = lattice_box({6, 5, 4}, even_limits(1, 1, 0));
  move(scene, {2, 5, 1}, {1, 1, 1});
  EXPECT_EQ(solve_literal(scene).iterations, 7 * 6 * 5 - 1); // all but the handle
}

TEST(LiteralContract, StopsWhenAsked) {
  Scene scene = lattice_box({40, 40, 40}, even_limits(1, 1, 0));
  move(scene, {0, 0, 0}, {1, 1, 1});
  Control control;
  control.stop_requested = [] { return true; };
  EXPECT_EQ(solve_literal(scene, control).status, Status::interrupted);
}

} // namespace
} // namespace maille::deform
