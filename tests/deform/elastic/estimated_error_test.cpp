/// Errors that are known, estimated.

#include "maille/deform/estimated_error.hpp"

#include "maille/deform/solve.hpp"
#include "maille/scene/frame.hpp"
#include "maille/scene/refined.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"
#include "support/sanitized.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace maille::deform {
namespace {

/// Held at its foot, its top pushed aside and down.
Scene pushed(int dimension, Index3 cells) {
  Scene scene = test::box_scene(dimension, cells);
  test::hold_face(scene, dimension - 1, false);
  test::move_face(scene, dimension - 1, true, {0.3e-3, dimension == 2 ? -0.2e-3 : 0.1e-3, -0.4e-3});
  return scene;
}

/// Two kinds of matter, and a corner that is not there.
Scene pushed_body(Index3 cells) {
  Scene scene = pushed(3, cells);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(50e3, 0.4);
  auto& kinds = scene.specimen.material_id;
  kinds.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const Index3 at = scene.specimen.grid.cell_at(static_cast<std::int64_t>(i));
    if (at[0] > cells[0] / 2 && at[2] > 2 && at[2] < 6)
      kinds[i] = at[1] > cells[1] / 2 ? no_material : 1;
  }
  return scene;
}

/// A bump of 0.02 mm, below small_model_error; zero at everything that is prescribed, at all nodes of the
/// body.
Displacement bump(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  Displacement u(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    if (!scene.specimen.is_node(at))
      continue;
    double value = 0.02e-3;
    for (int a = 0; a < scene.dimension(); ++a)
      value *= std::sin(std::numbers::pi * (at[static_cast<std::size_t>(a)] + 0.2) /
                        grid.nodes()[static_cast<std::size_t>(a)]);
    for (int c = 0; c < scene.dimension(); ++c)
      u(c, node) = c == 1 ? -0.5 * value : value;
  }
  for (const Prescribed& p : scene.prescribed)
    u(p.component, p.node) = 0;
  return u;
}

Displacement sum(Displacement a, const Displacement& b, double factor = 1) {
  for (std::size_t i = 0; i < a.values().size(); ++i)
    a.values()[i] += factor * b.values()[i];
  return a;
}

/// What the estimate says more of a converged answer with a bump than of it alone is the bump.
void expect_bump_is_found(Scene scene) {
  scene.relaxation.tolerance = 1e-10;
  const Answer converged = solve(scene, "coupled");
  ASSERT_EQ(converged.status, Status::done);
  scene.relaxation.tolerance = 1e-4;
  const Displacement wrong = bump(scene);
  const ErrorEstimation alone = estimate_error(scene, converged.displacement),
                        bumped = estimate_error(scene, sum(converged.displacement, wrong));
  ASSERT_TRUE(alone.estimate) << alone.reason;
  ASSERT_TRUE(bumped.estimate) << bumped.reason;
  ASSERT_EQ(alone.estimate->lattice, bumped.estimate->lattice); // the same of the lattice in both
  const Displacement found = sum(bumped.estimate->error, alone.estimate->error, -1);
  // A step of less than 5 % ends the correction; what is left of it then is of that size.
  EXPECT_LE(test::norm(sum(found, wrong, -1)), 0.05 * test::norm(wrong));
}

TEST(EstimatedErrorOracle, ABumpOnAConvergedAnswerIsFound) {
  expect_bump_is_found(pushed(3, {8, 8, 8}));    // a box that can be halved
  expect_bump_is_found(pushed(3, {7, 9, 8}));    // and one that cannot
  expect_bump_is_found(pushed_body({8, 9, 10})); // a body of two kinds of matter
  expect_bump_is_found(pushed(2, {16, 12, 1}));
}

TEST(EstimatedErrorOracle, ThePartOfTheLatticeIsThatOfAnswersOnFinerLattices) {
  // The truth: coupled on eight times as many cells an axis, of which 1 / 8 of the error is left.
  const auto cube = [](int n) {
    Scene scene = test::box_scene(3, {n, n, n}, Vec3{8e-3 / n, 8e-3 / n, 8e-3 / n});
    test::hold_face(scene, 2, false);
    test::move_face(scene, 2, true, {0.3e-3, 0, -0.4e-3});
    scene.relaxation.tolerance = 1e-6;
    return scene;
  };
  const Scene scene = cube(8), fine = cube(64);
  const Displacement answer = solve(scene, "coupled").displacement,
                     best = solve(fine, "coupled").displacement;
  Displacement truth(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Index3 at = scene.specimen.grid.node_at(node);
    for (int c = 0; c < 3; ++c)
      truth(c, node) = best(c, fine.specimen.grid.node({8 * at[0], 8 * at[1], 8 * at[2]}));
  }
  const ErrorEstimation found = estimate_error(scene, answer);
  ASSERT_TRUE(found.estimate) << found.reason;
  EXPECT_EQ(found.estimate->lattice, OtherLattice::finer);
  const double true_error = compare(scene, answer, truth).relative_l2;
  EXPECT_GT(true_error, 1e-3) << "something to be found";
  EXPECT_GT(found.estimate->norms.relative_l2, true_error);
  EXPECT_LT(found.estimate->norms.relative_l2, true_error * 2);
}

/// Held at one end, the other one moved along and across.
Scene bent(Index3 cells, double poisson_ratio) {
  Scene scene = test::box_scene(3, cells);
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson_ratio);
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.2e-3, 0, 0.4e-3});
  return scene;
}

// The truth: coupled on a quarter of the spacing, which has a sixteenth to a quarter of the error. From twice
// the spacing the estimate was six to thirty-five times too large where matter is nearly incompressible, and
// a third of the error on plates one cell thick.
TEST(EstimatedErrorOracle, HardBodiesAreEstimatedToo) {
  for (const Scene& scene : {bent({12, 8, 8}, 0.499), bent({8, 6, 6}, 0.4999), bent({12, 10, 1}, 0.45)}) {
    if (test::is_sanitized && scene.specimen.grid.cells()[2] > 1)
      continue;
    Scene half = refined(scene), quarter = refined(half);
    quarter.relaxation.tolerance = 1e-6;
    const Displacement truth =
        at_coarse_nodes(scene, half, at_coarse_nodes(half, quarter, solve(quarter, "coupled").displacement));
    const Displacement answer = solve(scene, "coupled").displacement;
    const double true_error = compare(scene, answer, truth).relative_l2;
    const ErrorEstimation found = estimate_error(scene, answer);
    ASSERT_TRUE(found.estimate) << found.reason;
    EXPECT_GT(found.estimate->norms.relative_l2, true_error);
    EXPECT_LT(found.estimate->norms.relative_l2, true_error * 2);
  }
}

TEST(EstimatedErrorAnalytic, AUniformStretchHasNoErrorAndABumpOnItIsAllOfTheError) {
  Scene scene = test::box_scene(3, {8, 10, 8});
  const Displacement exact = test::affine_displacement<Displacement>(
      scene, {{{0.02, 0.01, 0}, {0, -0.01, 0.005}, {0.004, 0, -0.006}}});
  const Grid& grid = scene.specimen.grid;
  for (int c = 0; c < 3; ++c)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      const Index3 at = grid.node_at(node);
      bool is_outer = false;
      for (std::size_t a = 0; a < 3; ++a)
        is_outer = is_outer || at[a] == 0 || at[a] == grid.nodes()[a] - 1;
      if (is_outer)
        scene.prescribed.push_back({node, c, exact(c, node), false});
    }
  const ErrorEstimation none = estimate_error(scene, exact);
  ASSERT_TRUE(none.estimate) << none.reason;
  EXPECT_LE(none.estimate->norms.relative_l2, 1e-6); // float32 inside the cycles
  const Displacement wrong = bump(scene);
  const ErrorEstimation found = estimate_error(scene, sum(exact, wrong));
  ASSERT_TRUE(found.estimate) << found.reason;
  EXPECT_LE(test::norm(sum(found.estimate->error, wrong, -1)), 0.05 * test::norm(wrong));
  EXPECT_NEAR(found.estimate->norms.relative_l2, compare(scene, sum(exact, wrong), exact).relative_l2,
              0.05 * found.estimate->norms.relative_l2);
}

TEST(EstimatedErrorAnalytic, TheEstimateTurnsWithTheBody) {
  const auto turned_by = [](double angle) {
    Scene scene = test::box_scene(3, {8, 6, 6});
    for (const bool upper : {false, true})
      test::move_face(scene, 0, upper, {});
    const double c = std::cos(angle), s = std::sin(angle);
    for (Prescribed& p : scene.prescribed) {
      Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(p.node)), y = x;
      y[0] = 1.05 * x[0];
      const Vec3 z{c * y[0] - s * y[1], s * y[0] + c * y[1], y[2]};
      const auto b = static_cast<std::size_t>(p.component);
      p.value = z[b] - x[b];
    }
    return scene;
  };
  const Scene straight = turned_by(0), turned = turned_by(0.5);
  ASSERT_TRUE(object_frame(turned).is_turned);
  const ErrorEstimation a = estimate_error(straight, solve(straight, "limits").displacement),
                        b = estimate_error(turned, solve(turned, "limits").displacement);
  ASSERT_TRUE(a.estimate && b.estimate) << a.reason << b.reason;
  EXPECT_NEAR(a.estimate->norms.rms, b.estimate->norms.rms, 1e-3 * a.estimate->norms.rms);
  for (std::int64_t node = 0; node < straight.specimen.grid.n_nodes(); ++node) {
    const double c = std::cos(0.5), s = std::sin(0.5), x = a.estimate->error(0, node),
                 y = a.estimate->error(1, node);
    EXPECT_NEAR(b.estimate->error(0, node), c * x - s * y, 0.01 * a.estimate->norms.rms);
    EXPECT_NEAR(b.estimate->error(1, node), s * x + c * y, 0.01 * a.estimate->norms.rms);
  }
}

TEST(EstimatedErrorContract, SaysWhichOtherLatticeItLookedAt) {
  const auto lattice = [](const Scene& scene, const char* method) {
    const ErrorEstimation found = estimate_error(scene, solve(scene, method).displacement);
    EXPECT_TRUE(found.estimate) << found.reason;
    return found.estimate ? found.estimate->lattice : OtherLattice::none;
  };
  EXPECT_EQ(lattice(pushed(3, {8, 8, 8}), "coupled"), OtherLattice::finer);
  EXPECT_EQ(lattice(pushed(3, {8, 8, 8}), "limits"), OtherLattice::coarser) << "some 20 % off";
  EXPECT_EQ(lattice(pushed(3, {7, 8, 8}), "coupled"), OtherLattice::finer);
  EXPECT_EQ(lattice(pushed(3, {7, 8, 8}), "limits"), OtherLattice::none) << "some 20 % off";
  Scene odd = pushed(3, {8, 8, 8}); // where one node more is held the coarser body is not held alike
  odd.prescribed.push_back({odd.specimen.grid.node({3, 3, 3}), 2, 0, true});
  EXPECT_EQ(lattice(odd, "limits"), OtherLattice::none);
}

TEST(EstimatedErrorContract, SameBitsForAnyNumberOfThreads) {
  const Scene scene = pushed(3, {24, 24, 24});
  const Displacement limits = solve(scene, "limits").displacement;
  Control two;
  two.threads = 2;
  const ErrorEstimation a = estimate_error(scene, limits), b = estimate_error(scene, limits, two);
  ASSERT_TRUE(a.estimate && b.estimate);
  EXPECT_EQ(a.estimate->error, b.estimate->error);
}

TEST(EstimatedErrorContract, ThereIsNoneAgainstABodyThatBends) {
  Scene scene = pushed(3, {8, 8, 8});
  scene.relaxation.frame = StrainFrame::blocks;
  const ErrorEstimation estimation = estimate_error(scene, Displacement(scene.specimen.grid));
  EXPECT_FALSE(estimation.estimate);
  EXPECT_NE(estimation.reason.find("blocks"), std::string::npos);
}

TEST(EstimatedErrorContract, SaysWhyThereIsNone) {
  Scene scene = pushed(3, {7, 8, 8});
  const Displacement answer = solve(scene, "coupled").displacement;
  Control control;
  control.bytes_budget = 1000;
  EXPECT_NE(estimate_error(scene, answer, control).reason.find("needs about"), std::string::npos);
  control.bytes_budget = bytes_needed(scene, "coupled") * 2; // not enough for half the spacing
  EXPECT_NE(estimate_error(scene, answer, control).reason.find("no memory"), std::string::npos);
  control = {};
  control.stop_requested = [] { return true; };
  EXPECT_NE(estimate_error(scene, answer, control).reason.find("stopped"), std::string::npos);
  scene.prescribed.resize(1);
  const ErrorEstimation loose = estimate_error(scene, answer);
  EXPECT_FALSE(loose.estimate);
  EXPECT_FALSE(loose.reason.empty());
}

} // namespace
} // namespace maille::deform
