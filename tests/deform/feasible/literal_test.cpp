#include "oracle/literal.hpp"

#include "feasible/limits.hpp"
#include "support/bodies/lattice_scenes.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::even_limits;
using tests::hold;
using tests::lattice_box;
using tests::move;

/// A box of random size and dimension with random dyadic limits, one node dragged by multiples of 1/16.
Scene random_drag(std::mt19937& random, int dimension) {
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  NeighbourLimits given;
  for (std::size_t a = 0; a < 3; ++a) {
    given.stretch[a] = 1 + below(9) / 16.0;
    given.compress[a] = 1 - below(9) / 16.0;
    for (std::size_t b = 0; b < 3; ++b)
      given.shear[a][b] = below(9) / 16.0;
  }
  Scene scene = lattice_box({1}, given);
  Index3 cells{1, 1, 1}, handle{0, 0, 0};
  Vec3 by{};
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension); ++a) {
    cells[a] = 1 + below(dimension == 1 ? 40 : dimension == 2 ? 20 : 9);
    handle[a] = below(cells[a] + 1);
    by[a] = (below(161) - 80) / 16.0;
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
  Scene slotted = lattice_box({9, 9}, even_limits(1.125, 0.875, 0.125));
  slotted.specimen.material_id.assign(81, 0);
  for (int y = 2; y < 9; ++y)
    slotted.specimen.material_id[static_cast<std::size_t>(4 + 9 * y)] = no_material;
  move(slotted, {0, 9, 0}, {-3, 3, 0});
  const Answer answer = solve_literal(slotted);
  EXPECT_EQ(answer.status, Status::done);
  const LinkLimits limits(slotted);
  const double worst = largest_violation(slotted, limits, answer.displacement);
  EXPECT_GT(worst, 0.1);
  EXPECT_NE(answer.message.find("links are outside their limits"), std::string::npos) << answer.message;
  EXPECT_LE(largest_violation(slotted, limits, solve_limits(slotted).displacement), 1e-15);
}

TEST(LiteralContract, PrescribedComponentsStayWhereTheyWerePut) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    const Scene scene = tests::random_body(random);
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
