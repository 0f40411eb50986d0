#include "feasible/box/separable_scans.hpp"
#include "feasible/feasible_set.hpp"
#include "feasible/limits.hpp"
#include "lattice/body.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"
#include "support/worlds/all_paths.hpp"

namespace maille::deform {
namespace {

using test::below;
using test::even_limits;
using test::ForcedVectors;
using test::lattice_box;
using test::random_box;
using test::random_node;
using test::vector_targets;

/// What is asked of a body in one go: values that can be met together, per component.
using Request = std::array<std::vector<HandleValue>, 3>;

Request clipped(const Scene& scene) {
  Request request;
  for (const Prescribed& p : clip(scene, LinkLimits(scene)).prescribed)
    request[std::size_t(p.component)].push_back({scene.specimen.grid.node_at(p.node), p.value});
  return request;
}

/// Handles of a random number, sometimes whole rows, with values that the limits permit.
Request random_request(std::mt19937& random, Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  scene.prescribed.clear();
  const int n = 1 + below(random, below(random, 2) == 0 ? 4 : 60);
  for (int k = 0; k < n; ++k)
    test::move(scene, random_node(random, grid), test::random_dyadic(random, 4));
  if (below(random, 3) == 0) { // a row of more handles than are laid out one by one
    Index3 at = random_node(random, grid);
    for (at[0] = 0; at[0] < grid.nodes()[0]; ++at[0])
      test::move(scene, at, test::random_dyadic(random, 4));
  }
  if (below(random, 2) == 0)
    test::hold(scene, random_node(random, grid));
  return clipped(scene);
}

/// A body of float32, dragged by scans alone.
class ScannedBody {
public:
  ScannedBody(const Scene& scene, int threads)
      : body(scene), scans_(scene.specimen.grid, intervals_by_axis(scene, LinkLimits(scene)), threads),
        team_(threads) {}

  void drag(const Request& request) {
    for (int b = 0; b < body.dimension(); ++b)
      scans_.add(b, body.field(b), request[std::size_t(b)], rounding_[std::size_t(b)]);
    scans_.run(team_);
  }

  Body body;

private:
  SeparableScans<float> scans_;
  ThreadTeam team_;
  std::array<Rounding, 3> rounding_;
};

/// The obvious way: shortest paths from and to every handle, from the state before.
Displacement dragged_by_dijkstra(const Scene& scene, const Request& request, Displacement state) {
  std::vector<Prescribed> prescribed;
  for (int b = 0; b < scene.dimension(); ++b)
    for (const HandleValue& handle : request[std::size_t(b)])
      prescribed.push_back({scene.specimen.grid.node(handle.at), b, handle.value, false});
  propagate(scene, LinkLimits(scene), prescribed, state);
  return state;
}

TEST(SeparableScansOracle, EqualsDijkstraForVectorsAndThreads) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    Scene scene = random_box(random, 1 + below(random, 3));
    const Request first = random_request(random, scene), second = random_request(random, scene);
    Displacement expected_first = dragged_by_dijkstra(scene, first, Displacement(scene.specimen.grid));
    const Displacement expected_second = dragged_by_dijkstra(scene, second, expected_first);
    for (const std::int64_t target : vector_targets()) {
      const ForcedVectors forced(target);
      for (const int threads : {1, 2, 3, 7}) {
        SCOPED_TRACE("seed " + std::to_string(seed) + " " + hwy::TargetName(target) + " threads " +
                     std::to_string(threads));
        ScannedBody scanned(scene, threads);
        scanned.drag(first);
        ASSERT_EQ(scanned.body.displacement(), expected_first);
        scanned.drag(second);
        ASSERT_EQ(scanned.body.displacement(), expected_second);
      }
    }
  }
}

/// A box large enough for several threads and strips; nothing is dyadic.
Scene rounded_box() {
  NeighbourLimits limits = even_limits(1.23456, 0.87654, 0.1357);
  limits.stretch[1] = 1.0999;
  limits.shear[2][0] = 0.0777;
  return lattice_box({69, 28, 33}, limits);
}

Request rounded_request(std::mt19937& random, Scene& scene, int n) {
  std::uniform_real_distribution<double> uniform(-3, 3);
  scene.prescribed.clear();
  for (int k = 0; k < n; ++k)
    test::move(scene, random_node(random, scene.specimen.grid),
               {uniform(random), uniform(random), uniform(random)});
  return clipped(scene);
}

TEST(SeparableScansContract, SameBitsForVectorsAndThreads) {
  std::mt19937 random(5);
  Scene scene = rounded_box();
  std::vector<Request> requests;
  for (const int n : {3, 40, 400})
    requests.push_back(rounded_request(random, scene, n));
  std::vector<Displacement> expected;
  for (const std::int64_t target : vector_targets()) {
    const ForcedVectors forced(target);
    for (const int threads : {1, 2, 3, 7}) {
      ScannedBody scanned(scene, threads);
      for (std::size_t k = 0; k < requests.size(); ++k) {
        scanned.drag(requests[k]);
        const Displacement state = scanned.body.displacement();
        if (expected.size() == k)
          expected.push_back(state);
        ASSERT_EQ(state, expected[k]) << hwy::TargetName(target) << " threads " << threads;
      }
    }
  }
}

TEST(SeparableScansOracle, IsWithinRoundingOfDijkstraAndFeasible) {
  std::mt19937 random(6);
  Scene scene = rounded_box();
  const LinkLimits limits(scene);
  ScannedBody scanned(scene, 1);
  Displacement expected(scene.specimen.grid);
  // Sums of up to 134 rounded steps; displacements are below 4, half an ulp of float32 there is 2^-23.
  const double tolerance = 140 * std::ldexp(1.0, -23);
  for (const int n : {3, 40, test::cases(400, 80)}) {
    const Request request = rounded_request(random, scene, n);
    expected = dragged_by_dijkstra(scene, request, expected);
    scanned.drag(request);
    const Displacement state = scanned.body.displacement();
    ASSERT_LE(test::largest_difference(state, expected), tolerance);
    for (std::size_t b = 0; b < 3; ++b)
      for (const HandleValue& handle : request[b])
        EXPECT_EQ(scanned.body.field(int(b)).at(handle.at), float(handle.value));
    // A link compares two bounds, each added up over at most 29 rows and five other terms.
    EXPECT_LE(largest_violation(scene, limits, state), 2 * 34 * std::ldexp(1.0, -23));
  }
}

TEST(BoxBoundsOracle, EqualDijkstraByPairsAndByScans) {
  int n_few = 0, n_many = 0;
  for (unsigned seed = 1; seed <= 80; ++seed) {
    std::mt19937 random(seed);
    const Scene scene = random_box(random, 1 + below(random, 3));
    const Grid& grid = scene.specimen.grid;
    const LinkLimits limits(scene);
    std::vector<PathEnd> ends;
    std::vector<std::int64_t> nodes;
    const bool few = below(random, 2) == 0;
    (few ? n_few : n_many)++;
    for (int k = 0; k < (few ? 5 : 1000); ++k) {
      ends.push_back({grid.node(random_node(random, grid)), test::random_dyadic(random, 4)[0]});
      nodes.push_back(grid.node(random_node(random, grid)));
    }
    if (!few) // in one slab, so that scans are cheaper
      for (PathEnd& end : ends)
        end.node %= grid.nodes()[0] * grid.nodes()[1];
    const int component = below(random, grid.dimension());
    BoxBounds fast(grid, intervals_by_axis(scene, limits));
    DijkstraBounds slow(scene, limits);
    std::vector<double> values(nodes.size()), expected(nodes.size());
    for (const std::int64_t target : vector_targets()) {
      const ForcedVectors forced(target);
      for (const Side side : {Side::least, Side::greatest}) {
        fast.bounds_at(side, component, ends, nodes, values);
        slow.bounds_at(side, component, ends, nodes, expected);
        ASSERT_EQ(values, expected) << "seed " << seed << " " << hwy::TargetName(target);
      }
    }
    const Arena arena;
    const Arena::Open open(arena);
    const BoxBounds unused(grid, intervals_by_axis(scene, limits));
    EXPECT_EQ(arena.present(), 0);
  }
  EXPECT_GE(n_few, 20);
  EXPECT_GE(n_many, 20);
}

TEST(BoxBoundsContract, WithoutEndsNothingIsBounded) {
  const Scene scene = lattice_box({3, 3}, even_limits(1.5, 0.5, 0.5));
  BoxBounds bounds(scene.specimen.grid, intervals_by_axis(scene, LinkLimits(scene)));
  std::vector<double> values(2);
  const std::vector<std::int64_t> nodes{0, 5};
  bounds.bounds_at(Side::least, 0, {}, nodes, values);
  EXPECT_EQ(values, (std::vector<double>(2, -std::numeric_limits<double>::infinity())));
  bounds.bounds_at(Side::greatest, 1, {}, nodes, values);
  EXPECT_EQ(values, (std::vector<double>(2, std::numeric_limits<double>::infinity())));
}

Displacement noise(std::mt19937& random, const Scene& scene) {
  Displacement state(scene.specimen.grid);
  for (int b = 0; b < scene.dimension(); ++b)
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
      if (scene.specimen.is_node(scene.specimen.grid.node_at(node)))
        state(b, node) = test::random_dyadic(random, 2)[0];
  return state;
}

/// The obvious way: majorant and minorant over all pairs of nodes.
Displacement projected_by_pairs(const Scene& scene, const Displacement& state) {
  const LinkLimits limits(scene);
  Displacement projected = state;
  for (int b = 0; b < scene.dimension(); ++b) {
    const test::AllPaths paths(scene, limits, b);
    std::vector<Prescribed> ends;
    for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n)
      if (scene.specimen.is_node(scene.specimen.grid.node_at(n)))
        ends.push_back({n, b, state(b, n), false});
    for (const Prescribed& p : ends)
      projected(b, p.node) = 0.5 * paths.lowest(ends, p.node) + 0.5 * paths.highest(ends, p.node);
  }
  return projected;
}

TEST(ProjectionOracle, EqualsAllPairsForVectorsAndThreads) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    Scene scene = lattice_box({1}, test::random_dyadic_limits(random));
    scene.specimen.grid =
        Grid(3, {1 + below(random, 20), 1 + below(random, 9), 1 + below(random, 2)}, {1, 1, 1});
    const LinkLimits limits(scene);
    const Displacement state = noise(random, scene), expected = projected_by_pairs(scene, state);
    for (const std::int64_t target : vector_targets()) {
      const ForcedVectors forced(target);
      for (const int threads : {1, 3}) {
        Displacement projected = state;
        EXPECT_EQ(FeasibleSet(scene, limits, threads).project(projected),
                  test::largest_difference(state, expected));
        ASSERT_EQ(projected, expected) << "seed " << seed;
      }
    }
  }
}

TEST(ProjectionOracle, IsNearestOnBodiesOfAnyKind) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::random_body(random);
    const LinkLimits limits(scene);
    Displacement projected = noise(random, scene);
    const Displacement expected = projected_by_pairs(scene, projected);
    FeasibleSet(scene, limits).project(projected);
    EXPECT_LE(test::largest_difference(projected, expected), 200 * std::numeric_limits<double>::epsilon());
    EXPECT_LE(largest_violation(scene, limits, projected), 400 * std::numeric_limits<double>::epsilon());
  }
}

TEST(ProjectionAnalytic, AFeasibleStateStays) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    Scene scene = random_box(random, 1 + below(random, 3));
    for (int k = 0; k < 3; ++k)
      test::move(scene, test::random_node(random, scene.specimen.grid), test::random_dyadic(random, 4));
    const Displacement feasible = solve_limits(scene).displacement;
    Displacement state = feasible;
    EXPECT_EQ(FeasibleSet(scene, LinkLimits(scene)).project(state), 0);
    EXPECT_EQ(state, feasible) << "seed " << seed;
  }
}

TEST(ProjectionAnalytic, OneNodeThatIsTooFarMeetsItsNeighboursHalfWay) {
  // A node 2 ahead of neighbours that allow 0.5: 1.5 too far, so it goes back 0.75 and all others come 0.75
  // less what the links between take up.
  Scene scene = lattice_box({6}, even_limits(1.5, 0.5, 0));
  Displacement state(scene.specimen.grid);
  state(0, 3) = 2;
  EXPECT_EQ(FeasibleSet(scene, LinkLimits(scene)).project(state), 0.75);
  EXPECT_TRUE(
      std::ranges::equal(state.component(0), (std::vector<double>{0.25, 0.5, 0.75, 1.25, 0.75, 0.5, 0.25})));
}

TEST(ProjectionContract, SameBitsForVectorsAndThreads) {
  const Scene scene = lattice_box({41, 37, 33}, even_limits(1.23456, 0.87654, 0.1357));
  const LinkLimits limits(scene);
  std::mt19937 random(9);
  const Displacement state = noise(random, scene);
  Displacement first = state;
  FeasibleSet(scene, limits).project(first);
  // Values are below 2, where half an ulp of float64 is 2^-53; a link compares two sums of 111 steps or less.
  EXPECT_LE(largest_violation(scene, limits, first), 2 * 114 * std::ldexp(1.0, -53));
  for (const std::int64_t target : vector_targets()) {
    const ForcedVectors forced(target);
    for (const int threads : {1, 2, 3, 7}) {
      Displacement projected = state;
      FeasibleSet(scene, limits, threads).project(projected);
      ASSERT_EQ(projected, first) << hwy::TargetName(target) << " threads " << threads;
    }
  }
}

TEST(ProjectionContract, ALargeInhomogeneousBodyGoesByTheWavefront) {
  Scene scene = lattice_box({20, 15, 13}, even_limits(1.25, 0.75, 0.25));
  scene.specimen.material_id.assign(20 * 15 * 13, 0);
  for (int k = 0; k < 300; ++k)
    scene.specimen.material_id[std::size_t(k * 13)] = no_material;
  std::mt19937 random(3);
  Displacement projected = noise(random, scene), expected = projected;
  const LinkLimits limits(scene);
  const double change = FeasibleSet(scene, limits).project(projected);
  EXPECT_GT(change, 0.5);
  // Quanta are at most 2^-29 of the slack across the grid, 24.
  EXPECT_LE(largest_violation(scene, limits, projected), 3 * 24 * std::ldexp(1.0, -29));
  EXPECT_NEAR(test::largest_difference(projected, expected), change, 4 * 24 * std::ldexp(1.0, -29));
}

} // namespace
} // namespace maille::deform
