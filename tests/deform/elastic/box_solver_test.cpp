/// `coupled` on boxes of one material against `coupled` on any body.

#include "maille/deform/solve.hpp"
#include "support/bodies/scenes.hpp"
#include "support/coupled_algorithms.hpp"
#include "support/vector_targets.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille::deform {
namespace {

using test::solve_by;

/// A block held at its foot, pressed and pushed in the middle of its top.
Scene poked_block(Index3 cells, Vec3 spacing = {1e-3, 1e-3, 1e-3}) {
  Scene scene = test::box_scene(3, cells, spacing);
  test::hold_face(scene, 2, false);
  const Index3 top{0, 0, cells[2]};
  for (int c = 0; c < 3; ++c)
    for (int y = cells[1] / 4; y <= (3 * cells[1] + 3) / 4; ++y)
      for (int x = cells[0] / 4; x <= (3 * cells[0] + 3) / 4; ++x)
        scene.prescribed.push_back(
            {scene.specimen.grid.node({x, y, top[2]}), c, c == 2 ? -0.2e-3 : 0.05e-3 * c, false});
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  return scene;
}

void expect_same_answer(const Answer& box, const Answer& body) {
  test::expect_same_answer(box, body, 1e-9, 1e-8);
}

TEST(BoxSolverOracle, AwkwardSizesAreAnsweredAsByTheGeneralWay) {
  for (const Index3& cells :
       {Index3{7, 12, 33}, {2, 20, 9}, {19, 2, 6}, {12, 9, 2}, {1, 1, 30}, {1, 1, 1}, {34, 3, 5}}) {
    Scene scene = poked_block(cells, {1e-3, 1.3e-3, 0.8e-3});
    scene.relaxation.tolerance = 1e-11;
    SCOPED_TRACE(testing::Message() << cells[0] << ' ' << cells[1] << ' ' << cells[2]);
    expect_same_answer(solve_by(solve_coupled_box, scene), solve_by(solve_coupled_body, scene));
  }
}

TEST(BoxSolverOracle, FibresAndLoadsAreAnsweredAsByTheGeneralWay) {
  Scene scene = poked_block({12, 10, 9});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 6e3, 0.3, 0.4);
  scene.materials[0].density = 1000;
  scene.gravity = {1, -2, -9};
  scene.specimen.fibre = {0.48, 0.6, 0.64};
  scene.relaxation.tolerance = 1e-10;
  expect_same_answer(solve_by(solve_coupled_box, scene), solve_by(solve_coupled_body, scene));
  scene.prescribed.clear();
  test::hold_face(scene, 0, true); // loads alone
  expect_same_answer(solve_by(solve_coupled_box, scene), solve_by(solve_coupled_body, scene));
}

TEST(BoxSolverOracle, TheErrorIsBelowTheToleranceThatWasAsked) {
  for (const double poisson : {0.0, 0.3, 0.45, 0.49}) {
    Scene scene = poked_block({20, 20, 20});
    scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson);
    scene.relaxation.tolerance = 1e-11;
    const Answer exact = solve(scene, "coupled"); // the oracle: the same, converged
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6, 1e-8}) {
      scene.relaxation.tolerance = tolerance;
      const Answer answer = solve(scene, "coupled");
      ASSERT_EQ(answer.status, Status::done);
      EXPECT_LE(answer.residual, tolerance);
      EXPECT_LE(test::relative_difference(answer.displacement, exact.displacement), tolerance) << poisson;
      // The energy is off by the square of the error in its norm, and by 1e-12 for rounding.
      EXPECT_LE(std::sqrt(std::abs(*answer.strain_energy / *exact.strain_energy - 1)),
                std::max(tolerance, 1e-6))
          << poisson;
      EXPECT_TRUE(tolerance < 1e-3 || answer.iterations <= 13) << poisson << ' ' << answer.iterations;
    }
  }
}

TEST(BoxSolverContract, AnyNumberOfThreadsGivesTheSameBits) {
  Scene scene = poked_block({30, 31, 37});
  scene.relaxation.tolerance = 1e-6; // more than one round
  const Answer one = solve_by(solve_coupled_box, scene);
  for (const int threads : {2, 3}) {
    const Answer several = solve_by(solve_coupled_box, scene, threads);
    EXPECT_EQ(several.displacement, one.displacement) << threads;
    EXPECT_EQ(several.reaction, one.reaction) << threads;
    EXPECT_EQ(several.strain_energy, one.strain_energy) << threads;
  }
}

TEST(BoxSolverContract, VectorsOfAnyLengthGiveTheSameBits) {
  const Scene scene = poked_block({21, 18, 17});
  std::vector<Answer> found;
  for (const std::int64_t target : tests::vector_targets()) {
    const tests::ForcedVectors forced(target);
    const Answer answer = solve_by(solve_coupled_box, scene);
    if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) != 0) { // those that fuse products with sums
      found.push_back(answer);
      EXPECT_EQ(found.back().displacement, found.front().displacement);
    } else if (!found.empty()) {
      EXPECT_LE(test::relative_difference(answer.displacement, found.front().displacement), 1e-5);
    }
  }
}

TEST(BoxSolverContract, OnlyBoxesOfOneMatterTakeThisWay) {
  Scene scene = poked_block({6, 5, 4});
  EXPECT_TRUE(is_uniform_box(scene));
  EXPECT_EQ(solve(scene, "coupled").algorithm,
            "lattice elasticity, conjugate gradients around lattice multigrid");
  scene.specimen.material_id.assign(120, 0);
  EXPECT_TRUE(is_uniform_box(scene));
  scene.specimen.material_id[60] = no_material;
  EXPECT_FALSE(is_uniform_box(scene));
  EXPECT_EQ(solve(scene, "coupled").algorithm,
            "lattice elasticity, conjugate gradients around multigrid of the body's pieces");
  scene.specimen.material_id.clear();
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  scene.specimen.fibres.assign(120, {1, 0, 0});
  EXPECT_TRUE(is_uniform_box(scene));
  scene.specimen.fibres[3] = {0, 1, 0};
  EXPECT_FALSE(is_uniform_box(scene));
  EXPECT_FALSE(is_uniform_box(test::box_scene(2, {3, 3, 1})));
}

TEST(BoxSolverContract, MemoryIsSmallAndForeseen) {
  Scene scene = poked_block({64, 64, 64});
  const Answer answer = solve(scene, "coupled");
  const double nodes = 65 * 65 * 65;
  EXPECT_LE(static_cast<double>(answer.bytes) / nodes, 24 + 100); // the answer, and all else
  EXPECT_LE(answer.bytes, bytes_needed(scene, "coupled"));
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(200e3, 10e3, 6e3, 0.3, 0.4);
  EXPECT_LE(solve(scene, "coupled").bytes, bytes_needed(scene, "coupled")); // coarsened along one axis first
}

TEST(BoxSolverContract, AnInterruptedSolveLeavesAUsableState) {
  Scene scene = poked_block({20, 20, 20});
  scene.relaxation.tolerance = 1e-12;
  int asked = 0;
  Control control;
  control.stop_requested = [&] { return ++asked > 3; };
  const Answer answer = solve(scene, "coupled", control);
  EXPECT_EQ(answer.status, Status::interrupted);
  EXPECT_TRUE(answer.reaction.empty());
  for (const Prescribed& p : scene.prescribed)
    EXPECT_EQ(answer.displacement(p.component, p.node), p.value);
}

} // namespace
} // namespace maille::deform
