#include "feasible/limits.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/named_bodies.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"

namespace maille::deform {
namespace {

using test::below;
using test::even_limits;
using test::hold;
using test::lattice_box;
using test::random_box;
using test::random_dyadic;
using test::random_node;

/// The obvious way to do what Drag does: shortest paths in float64, all handles kept in a list.
class SlowDrag {
public:
  explicit SlowDrag(const Scene& scene) : scene_(scene), limits_(scene), state(scene.specimen.grid) {
    std::erase_if(scene_.prescribed, [](const Prescribed& p) { return !p.held; });
  }
  void move_to(const std::vector<Drag::Move>& moves) {
    Scene asked = scene_;
    for (const auto& [node, value] : handles_)
      prescribe(asked, node, value, true);
    for (const Drag::Move& move : moves)
      prescribe(asked, move.node, move.displacement, false);
    state = drag_limits(asked, limits_, state).displacement;
    for (const Drag::Move& move : moves) {
      Vec3& now = handles_[move.node];
      for (int b = 0; b < scene_.dimension(); ++b)
        now[static_cast<std::size_t>(b)] = state(b, move.node);
    }
  }
  void release(std::int64_t node) { handles_.erase(node); }

private:
  void prescribe(Scene& asked, std::int64_t node, const Vec3& value, bool held) const {
    const auto holds = [&](int b) {
      return std::ranges::any_of(scene_.prescribed,
                                 [&](const Prescribed& p) { return p.node == node && p.component == b; });
    };
    for (int b = 0; b < scene_.dimension(); ++b)
      if (!holds(b))
        test::prescribe(asked, node, b, value[static_cast<std::size_t>(b)], held);
  }

  Scene scene_;
  LinkLimits limits_;
  std::map<std::int64_t, Vec3> handles_;

public:
  Displacement state;
};

TEST(DragOracle, EqualsDijkstraToTheBitThroughAnyStory) {
  int n_cut = 0;
  for (unsigned seed = 1; seed <= test::cases(80u, 20u); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = random_box(random, 1 + below(random, 3));
    const Grid& grid = scene.specimen.grid;
    for (int k = below(random, 3); k > 0; --k)
      test::prescribe(scene, grid.node(random_node(random, grid)), below(random, grid.dimension()), 0, true);
    const LinkLimits limits(scene);
    Drag drag(scene, limits, 1 + below(random, 3), FrameRule::fixed); // as SlowDrag
    SlowDrag slow(scene);
    std::vector<std::int64_t> handles;
    for (int k = 0; k < 12; ++k) {
      if (below(random, 4) == 0 && !handles.empty()) {
        const std::int64_t node = handles[random() % handles.size()];
        drag.release(node);
        slow.release(node);
      }
      std::vector<Drag::Move> moves;
      for (int m = below(random, 3) == 0 ? 1 + below(random, 9) : 1; m > 0; --m) {
        const std::int64_t node = grid.node(random_node(random, grid));
        if (std::ranges::find(moves, node, &Drag::Move::node) == moves.end())
          moves.push_back({node, random_dyadic(random, 6)});
        handles.push_back(node);
      }
      const Drag::Step step =
          moves.size() == 1 ? drag.move_to(moves[0].node, moves[0].displacement) : drag.move_to(moves);
      n_cut += step.is_cut ? 1 : 0;
      slow.move_to(moves);
      ASSERT_EQ(drag.displacement(), slow.state) << "move " << k;
    }
  }
  EXPECT_GE(n_cut, test::cases(100, 10));
}

TEST(DragOracle, IsWithinQuantaOfDijkstraInInhomogeneousBodies) {
  for (const std::string_view name : named_bodies()) {
    Scene scene = named_body(name, 14);
    scene.prescribed.clear();
    hold(scene, {13, 13, 13});
    const LinkLimits limits(scene);
    Drag drag(scene, limits);
    SlowDrag slow(scene);
    std::mt19937 random(2);
    for (int k = 0; k < 8; ++k) {
      const std::int64_t node =
          scene.specimen.grid.node({below(random, 13), 2 + below(random, 3), below(random, 13)});
      if (!scene.specimen.is_node(scene.specimen.grid.node_at(node)))
        continue;
      const std::vector<Drag::Move> moves{{node, random_dyadic(random, 2)}};
      drag.move_to(moves);
      slow.move_to(moves);
      // Quanta are at most 2^-29 of the slack across the grid, less than 30; paths of 60 links or less.
      ASSERT_LE(test::largest_difference(drag.displacement(), slow.state),
                (k + 1) * 62 * 30 * std::ldexp(1.0, -29))
          << name << " move " << k;
    }
    EXPECT_EQ(drag.algorithm(), name == "bore" ? drag.algorithm() : "tiled wavefront");
  }
}

TEST(DragOracle, GoesOverToTheWavefrontWhereAHandleSeesNotAllMonotonely) {
  const Scene scene = test::slotted_sheet();
  const LinkLimits limits(scene);
  const Grid& grid = scene.specimen.grid;
  Drag drag(scene, limits, 1, FrameRule::fixed); // as SlowDrag
  SlowDrag slow(scene);
  drag.move_to(grid.node({4, 0, 0}), {1, 1, 0});
  slow.move_to({{grid.node({4, 0, 0}), {1, 1, 0}}});
  EXPECT_EQ(drag.algorithm(), "closed form");
  EXPECT_EQ(drag.displacement(), slow.state);
  drag.move_to(grid.node({0, 9, 0}), {-3, 3, 0});
  slow.move_to({{grid.node({0, 9, 0}), {-3, 3, 0}}});
  EXPECT_EQ(drag.algorithm(), "tiled wavefront");
  EXPECT_LE(test::largest_difference(drag.displacement(), slow.state), 40 * 5 * std::ldexp(1.0, -29));
}

Displacement dragged_in_steps(const Scene& scene, std::int64_t node, const Vec3& to, int steps) {
  const LinkLimits limits(scene);
  Drag drag(scene, limits);
  for (int k = 1; k <= steps; ++k) {
    Vec3 at{};
    for (std::size_t b = 0; b < 3; ++b)
      at[b] = to[b] * k / steps;
    drag.move_to(node, at);
  }
  return drag.displacement();
}

TEST(DragAnalytic, AMonotonePathEndsTheSameInOneOrAThousandSteps) { // Theorem 6
  Scene scene = lattice_box({40, 30, 20}, even_limits(1.25, 0.75, 0.25));
  scene.limits.given.shear[0][1] = 0.0625;
  hold(scene, {0, 0, 0});
  const std::int64_t node = scene.specimen.grid.node({33, 12, 20});
  const Displacement once = dragged_in_steps(scene, node, {6, -2, 1.5}, 1);
  EXPECT_EQ(dragged_in_steps(scene, node, {6, -2, 1.5}, 1024), once); // dyadic steps: to the bit
  EXPECT_LE(test::largest_difference(dragged_in_steps(scene, node, {6, -2, 1.5}, 1000), once),
            2 * std::ldexp(1.0, -21)); // others: to two ulps of float32 below 8
}

TEST(DragAnalytic, ARigidBodyGoesAlongForNothing) {
  Scene scene = lattice_box({30, 30, 30}, even_limits(1, 1, 0));
  const LinkLimits limits(scene);
  Drag drag(scene, limits);
  std::int64_t visited = 0;
  for (int k = 1; k <= 50; ++k)
    visited += drag.move_to(7, {0.1 * k, 1e6 * k, -0.3}).visited;
  EXPECT_EQ(visited, 0); // the offset takes it all
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); node += 1001) {
    EXPECT_DOUBLE_EQ(drag.displacement(0, node), 5.0);
    EXPECT_DOUBLE_EQ(drag.displacement(1, node), 5e7);
    EXPECT_DOUBLE_EQ(drag.displacement(2, node), -0.3);
  }
}

/// The largest error of a drag to `to` in `steps` steps, against shortest paths in float64.
double error_of_drag(const Scene& scene, const Vec3& to, int steps) {
  const std::int64_t node = 5;
  SlowDrag slow(scene);
  slow.move_to({{node, to}});
  const Displacement state = dragged_in_steps(scene, node, to, steps);
  return test::largest_difference(state, slow.state);
}

TEST(DragOracle, AHandleAHundredTimesTheBodyAwayCostsNoAccuracy) {
  Scene scene = lattice_box({30, 20, 10}, even_limits(1.21, 0.83, 0.17));
  const LinkLimits limits(scene);
  // Slack across the body is below 20; a number that small has half ulps of 2^-20 or less in float32, each
  // stored number is a sum of two rounded ones, and the offset follows within four slack ranges.
  const double tolerance = 4 * 3 * std::ldexp(1.0, -20);
  for (const double times : {1.0, 10.0, 100.0, 1e6})
    for (const int steps : {1, 37, 1000})
      EXPECT_LE(error_of_drag(scene, {30.1 * times, -19.3 * times, 7.7 * times}, steps), tolerance)
          << times << " in " << steps << " steps";
}

TEST(DragContract, HeldComponentsAndOtherHandlesStay) {
  Scene scene = lattice_box({12, 9, 7}, even_limits(1.3, 0.7, 0.2));
  for (const Index3& at : test::face(scene, 0, false))
    hold(scene, at);
  const LinkLimits limits(scene);
  const Grid& grid = scene.specimen.grid;
  Drag drag(scene, limits);
  const Drag::Step first = drag.move_to(grid.node({12, 9, 7}), {1.1, 0.3, 0.1});
  EXPECT_FALSE(first.is_cut);
  const Drag::Step second = drag.move_to(grid.node({12, 0, 0}), {100, -100, 0.1});
  EXPECT_TRUE(second.is_cut);
  // 12 links from the held face stretch by 0.3 each; the other handle, 9 and 7 links aside, lets go by 0.2
  // each
  EXPECT_DOUBLE_EQ(second.displacement[0], std::min(12 * 0.3, 1.1 + 16 * 0.2));
  for (const Index3& at : test::face(scene, 0, false))
    for (int b = 0; b < 3; ++b)
      EXPECT_EQ(drag.displacement(b, grid.node(at)), 0);
  EXPECT_FLOAT_EQ(static_cast<float>(drag.displacement(0, grid.node({12, 9, 7}))), 1.1F);
  EXPECT_EQ(drag.move_to(grid.node({0, 3, 3}), {1, 1, 1}).displacement, (Vec3{0, 0, 0})); // a held node
  const float ulps = 8 * std::ldexp(1.0F, -23);
  EXPECT_LE(largest_violation(scene, limits, drag.displacement()), ulps);
}

using test::move;

/// A box with handles and holds; half of the requests cannot be met.
Scene random_question(std::mt19937& random) {
  Scene scene = random_box(random, 1 + below(random, 3));
  const int n_moves = 1 + below(random, below(random, 2) == 0 ? 4 : 30), n_holds = below(random, 4);
  for (int k = 0; k < n_moves; ++k)
    for (int b = 0; b < scene.dimension(); ++b)
      if (below(random, 4) != 0)
        test::prescribe(scene, scene.specimen.grid.node(random_node(random, scene.specimen.grid)), b,
                        test::random_dyadic(random, 1 + below(random, 6))[0], false);
  for (int k = 0; k < n_holds; ++k)
    hold(scene, random_node(random, scene.specimen.grid));
  return scene;
}

TEST(DispatchOracle, EqualsDijkstraToTheBitInBoxes) {
  int n_done = 0, n_clamped = 0;
  std::map<std::string, int> ways;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Scene scene = random_question(random);
    const Answer expected = solve(scene, "dijkstra"), answer = solve(scene, "limits");
    ASSERT_EQ(answer.displacement, expected.displacement);
    EXPECT_EQ(answer.status, expected.status);
    EXPECT_EQ(answer.message, expected.message);
    (answer.status == Status::done ? n_done : n_clamped)++;
    ++ways[answer.algorithm];
  }
  EXPECT_GE(n_done, 50);
  EXPECT_GE(n_clamped, 50);
  EXPECT_GE(ways["closed form"], 20);
  EXPECT_GE(ways["separable scans"], 20);
  EXPECT_EQ(ways["Dijkstra per component"], 0);
}

TEST(DispatchOracle, IsWithinRoundingOfDijkstraOnAnyBody) {
  std::map<std::string, int> ways;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Scene scene = test::random_body(random); // holes, three materials, numbers that are not dyadic
    if (below(random, 2) == 0) {             // half of them of one material, a few of those without holes
      scene.limits.from = LimitSource::given;
      scene.limits.given = *scene.materials[0].limits;
      if (below(random, 2) == 0)
        scene.specimen.material_id.clear();
    }
    const Answer expected = solve_limits(scene), answer = solve(scene, "limits");
    ++ways[answer.algorithm];
    ASSERT_EQ(answer.status, expected.status);
    EXPECT_LE(test::largest_difference(answer.displacement, expected.displacement), // sums of values below 2
              100 * std::numeric_limits<double>::epsilon());
    EXPECT_LE(largest_violation(scene, LinkLimits(scene), answer.displacement),
              200 * std::numeric_limits<double>::epsilon());
  }
  EXPECT_GE(ways["Dijkstra per component"], 100);
  EXPECT_GE(ways["closed form"], 20);
}

TEST(DispatchContract, TheOrderOfRequestsAndTheNumberOfThreadsChangeNoBit) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    Scene scene = random_question(random);
    for (Prescribed& p : scene.prescribed)
      p.value *= 1.1; // no longer dyadic
    const Answer answer = solve(scene, "limits");
    for (const int threads : {1, 2, 3, 7}) {
      std::ranges::shuffle(scene.prescribed, random);
      Control control;
      control.threads = threads;
      const Answer again = solve(scene, "limits", control);
      ASSERT_EQ(again.displacement, answer.displacement) << "seed " << seed;
      EXPECT_EQ(again.iterations, answer.iterations);
    }
  }
}

TEST(DispatchContract, RequestsThatCanBeMetAreMetToTheBit) {
  for (const int n_handles : {1, 3, 30}) {
    Scene scene = lattice_box({20, 11, 7}, even_limits(1.3, 0.7, 0.3));
    std::mt19937 random(4);
    std::uniform_real_distribution<double> uniform(-0.1, 0.1); // less than any link's slack
    hold(scene, {0, 0, 0});
    for (int k = 0; k < n_handles; ++k)
      move(scene, random_node(random, scene.specimen.grid),
           {uniform(random), uniform(random), uniform(random)});
    const Answer answer = solve(scene, "limits");
    EXPECT_EQ(answer.status, Status::done);
    for (const Prescribed& p : scene.prescribed)
      EXPECT_EQ(answer.displacement(p.component, p.node), p.value);
  }
}

/// One scene for each algorithm, large enough for bytes to be worth counting.
Scene scene_for(Algorithm algorithm) {
  const int n = algorithm == Algorithm::dijkstra ? 9 : 40; // small bodies take Dijkstra
  Scene scene = lattice_box({n, n, n}, even_limits(1.25, 0.75, 0.25));
  move(scene, {3, 4, 5}, {2, 1, -1});
  if (algorithm == Algorithm::separable_scans)
    for (int k = 0; k < 200; ++k)
      move(scene, {k % 41, 7 * k % 41, 0}, {0.125, 0.125, 0.125});
  if (algorithm == Algorithm::dijkstra || algorithm == Algorithm::wavefront) {
    scene.materials.push_back(scene.materials[0]);
    scene.materials[0].limits = even_limits(1.25, 0.75, 0.25);
    scene.materials[1].limits = even_limits(1.5, 0.75, 0.25);
    scene.limits.from = LimitSource::material;
    scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
    scene.specimen.material_id[5] = 1;
  }
  return scene;
}

TEST(DispatchContract, ThePlanNamesTheWayThatIsTakenAndItsBytes) {
  for (const Algorithm algorithm :
       {Algorithm::closed_form, Algorithm::separable_scans, Algorithm::wavefront, Algorithm::dijkstra})
    for (const int threads : {1, 3}) {
      const Scene scene = scene_for(algorithm);
      const Plan plan = plan_limits(scene, LinkLimits(scene), threads);
      EXPECT_EQ(plan.of_component, (std::array{algorithm, algorithm, algorithm}));
      EXPECT_EQ(plan.algorithm, to_string(algorithm));
      Control control;
      control.threads = threads;
      const Answer answer = solve_by_cheapest_way(scene, control);
      EXPECT_EQ(answer.algorithm, plan.algorithm);
      EXPECT_LE(answer.bytes, plan.bytes) << plan.algorithm;
      // The plan of the wavefront assumes all tiles at the surface; here a third are: see docs/limits.md.
      EXPECT_GE((algorithm == Algorithm::wavefront ? 5 : 2) * answer.bytes, plan.bytes) << plan.algorithm;
    }
}

TEST(DispatchOracle, TheWavefrontAgreesWithDijkstraWithinItsQuanta) {
  for (const std::string_view name : named_bodies()) {
    const Scene scene = named_body(name, 20);
    const Answer expected = solve(scene, "dijkstra"), answer = solve(scene, "limits");
    EXPECT_EQ(answer.algorithm, "tiled wavefront");
    EXPECT_EQ(answer.status, expected.status);
    // TiledBody: within (k + 2) quanta, which are at most 2^-29 of the largest difference; a path of 100
    // links
    const double tolerance = 102 * std::ldexp(scene.largest_prescribed(), -29);
    EXPECT_LE(test::largest_difference(answer.displacement, expected.displacement), tolerance) << name;
  }
}

TEST(DispatchContract, ComponentsMayGoDifferentWays) {
  Scene scene = lattice_box({9, 9, 9}, even_limits(1.25, 0.75, 0.25));
  test::prescribe(scene, 3, 0, 0.5, false);
  for (int node = 0; node < 20; ++node)
    test::prescribe(scene, 10 + node, 2, 0.125, false);
  EXPECT_EQ(plan_limits(scene, LinkLimits(scene)).algorithm, "closed form (x), separable scans (z)");
  const Answer answer = solve(scene, "limits");
  EXPECT_EQ(answer.displacement, solve_limits(scene).displacement);
  for (Prescribed& p : scene.prescribed)
    p.value = 0;
  EXPECT_EQ(solve(scene, "limits").algorithm, "nothing moves");
}

TEST(DispatchContract, AHandleThatReachesNotAllMonotonelyTakesShortestPaths) {
  Scene slotted = test::slotted_sheet(), above = slotted;
  move(slotted, {0, 9, 0}, {-3, 3, 0}); // beside the slot: the far side is reached around its foot
  move(above, {4, 0, 0}, {1, 1, 0});    // below it: everything is straight ahead
  EXPECT_EQ(solve(slotted, "limits").algorithm, "Dijkstra per component");
  EXPECT_EQ(solve(above, "limits").algorithm, "closed form");
  for (const Scene* scene : {&slotted, &above})
    EXPECT_EQ(solve(*scene, "limits").displacement, solve_limits(*scene).displacement);
}

} // namespace
} // namespace maille::deform
