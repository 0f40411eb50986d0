/// `relaxed` against obvious versions: dense matrices, sweeps, least movement.

#include "elastic/elastic_methods.hpp"

#include "feasible/bounds/clipping.hpp"
#include "feasible/limits.hpp"
#include "maille/scene/scene.hpp"
#include "oracle/sweep.hpp"
#include "support/bodies/holed_bodies.hpp"
#include "support/componentwise_oracle.hpp"
#include "support/fields.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using test::largest_difference;
using tests::Dice;
using tests::even_limits;
using tests::face;
using tests::hold;
using tests::lattice_box;
using tests::move;

constexpr double wide = 1e6;

/// A random body whose limits are far away.
Scene free_body(std::mt19937& random) {
  Scene scene = tests::holed_body(random);
  scene.limits.from = LimitSource::given;
  scene.limits.given = even_limits(wide, -wide, wide);
  return scene;
}

TEST(RelaxedOracle, EqualsTheDenseAssembly) {
  int compared = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 random(seed);
    Scene scene = free_body(random);
    if (scene.specimen.grid.n_nodes() > 1500)
      continue; // dense
    for (std::size_t m = 0; m < scene.materials.size(); ++m)
      scene.materials[m].elasticity =
          ElasticConstants::transversely_isotropic(1e4 * static_cast<double>(1 + 9 * m), 1e4, 3e3, 0.3, 0.2);
    scene.relaxation.tolerance =
        2e-7; // of an energy norm, estimated: the largest difference may be some times as much
    const Answer answer = solve_relaxed(scene);
    ASSERT_EQ(answer.status, Status::done) << "seed " << seed << " " << answer.message;
    double energy = 0;
    for (int b = 0; b < scene.dimension(); ++b) {
      const tests::DenseProblem problem = tests::dense_problem(scene, scene.prescribed, b);
      const std::vector<double> expected = tests::spread(problem, problem.A.llt().solve(problem.b));
      energy += tests::energy_of(problem.links, expected);
      const std::span<const double> u = answer.displacement.component(b);
      EXPECT_LE(largest_difference(u, expected), 2e-6 * scene.largest_prescribed()) << "seed " << seed;
      for (std::size_t k = 0; k < scene.prescribed.size(); ++k) {
        const Prescribed& p = scene.prescribed[k];
        if (p.component != b)
          continue;
        double force = 0, size = 0;
        for (const tests::WeightedLink& link : problem.links)
          for (const int side : {0, 1})
            if (p.node == (side == 0 ? link.near : link.far)) {
              const double pull = (side == 0 ? -1 : 1) * link.weight *
                                  (expected[static_cast<std::size_t>(link.far)] -
                                   expected[static_cast<std::size_t>(link.near)]);
              force += pull;
              size += link.weight * scene.largest_prescribed();
            }
        EXPECT_NEAR(answer.reaction[k], force, 1e-5 * size) << "seed " << seed;
      }
    }
    EXPECT_NEAR(answer.strain_energy.value(), energy,
                1e-5 * energy + 1e-7 * scene.largest_prescribed() * scene.largest_prescribed())
        << "seed " << seed;
    ++compared;
  }
  EXPECT_GE(compared, 30);
}

TEST(RelaxedOracle, LoadsEqualTheDenseAssembly) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    Dice dice{random};
    Scene scene = lattice_box({5, 4, 3}, even_limits(wide, -wide, wide));
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].elasticity = ElasticConstants::isotropic(1e5, 0.2);
    for (int cell = 0; cell < 60; ++cell)
      scene.specimen.material_id.push_back(static_cast<std::uint8_t>(dice.below(2)));
    for (const Index3& at : face(scene, 0, false))
      hold(scene, at);
    scene.gravity = {9.81 * dice.uniform(), 0, -9.81};
    scene.tractions.push_back({59, 1, true, {50, -20, 10}});
    scene.relaxation.tolerance = 1e-6;
    const Answer answer = solve_relaxed(scene);
    ASSERT_EQ(answer.status, Status::done);
    double total = 0, size = 0;
    for (int b = 0; b < 3; ++b) {
      const List<double> forces = nodal_forces(scene, b);
      const tests::DenseProblem problem = tests::dense_problem(scene, scene.prescribed, b, forces);
      const std::vector<double> expected = tests::spread(problem, problem.A.llt().solve(problem.b));
      const double largest =
          std::abs(*std::ranges::max_element(expected, {}, [](double value) { return std::abs(value); }));
      EXPECT_LE(largest_difference(answer.displacement.component(b), expected), 4e-6 * largest)
          << "seed " << seed;
      for (const double force : forces) {
        total += force;
        size += std::abs(force);
      }
    }
    for (const double reaction : answer.reaction) // what pulls is held against
      total += reaction;
    EXPECT_NEAR(total, 0, 1e-6 * size);
  }
}

TEST(RelaxedOracle, IsWhatWeightedSweepsTendTo) {
  Scene scene = lattice_box({7, 5, 4}, even_limits(wide, -wide, wide));
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(5e4, 1e4, 8e3, 0.3, 0.3);
  for (const Index3& at : face(scene, 0, false))
    hold(scene, at);
  move(scene, {7, 2, 2}, {0.5, -0.25, 0.125});
  scene.relaxation.tolerance = 1e-6;
  const Answer answer = solve_relaxed(scene);
  for (int b = 0; b < 3; ++b) // 3000 sweeps: converged to rounding at seven links along the body
    EXPECT_LE(
        largest_difference(answer.displacement.component(b),
                           tests::weighted_sweeps(tests::dense_problem(scene, scene.prescribed, b), 3000)),
        1e-6);
}

TEST(RelaxedOracle, EqualsSweepWhereAllWeightsAreEqual) {
  // E = G and nu = 0 give every link inside the same weight; links of the surface have less, but all nodes of
  // the surface are prescribed.
  Scene scene = lattice_box({9, 8, 7}, even_limits(wide, -wide, wide));
  scene.materials[0].elasticity = {{1e4, 1e4, 1e4}, 0, 0, 0, 1e4, 1e4, 1e4};
  std::mt19937 random(3);
  Dice dice{random};
  for (int axis = 0; axis < 3; ++axis)
    for (const bool upper : {false, true})
      for (const Index3& at : face(scene, axis, upper))
        move(scene, at, {dice.uniform(), dice.uniform(), dice.uniform()});
  scene.relaxation.tolerance = 1e-7;
  const Answer answer = solve_relaxed(scene), expected = solve_sweep(scene);
  ASSERT_EQ(expected.status, Status::done);
  for (std::size_t b = 0; b < 3; ++b)
    EXPECT_LE(largest_difference(answer.displacement.component(b), expected.displacement.component(b)), 5e-7);
}

TEST(RelaxedOracle, ActiveLimitsEqualTheDenseQuadraticProgram) {
  int active = 0;
  for (unsigned seed = 1; seed <= 80; ++seed) {
    std::mt19937 random(seed);
    Scene scene = tests::random_body(random);
    scene.relaxation.tolerance = 1e-6;
    const LinkLimits limits(scene);
    const std::vector<Prescribed> clipped = clip(scene, limits).prescribed;
    const Answer answer = solve_relaxed(scene);
    ASSERT_TRUE(has_displacement(answer.status)) << answer.message;
    EXPECT_LE(largest_violation(scene, limits, answer.displacement), 1e-13) << "seed " << seed;
    double energy = 0;
    bool has_converged = is_converged(answer.status);
    for (int b = 0; b < scene.dimension(); ++b) {
      const tests::DenseProblem problem = tests::dense_problem(scene, clipped, b);
      double broken = 0;
      const std::vector<double> expected = tests::constrained_minimum(problem, broken);
      has_converged = has_converged && broken < 1e-9;
      energy += tests::energy_of(problem.links, expected);
      if (has_converged) {
        EXPECT_LE(largest_difference(answer.displacement.component(b), expected),
                  1e-3 * std::max(0.1, scene.largest_prescribed()))
            << "seed " << seed << " component " << b;
      }
    }
    if (!has_converged)
      continue;
    EXPECT_NEAR(answer.strain_energy.value(), energy, 2e-4 * energy + 1e-20) << "seed " << seed;
    active += answer.algorithm.find("multipliers") != std::string::npos ? 1 : 0;
  }
  EXPECT_GE(active, 15);
}

TEST(RelaxedOracle, TheDeadZoneIsTheLeastMovement) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    Scene scene = tests::random_body(random);
    scene.relaxation.mode = RelaxationMode::deformable;
    scene.relaxation.tolerance = 1e-6;
    const Answer answer = solve_relaxed(scene);
    const Answer limits = solve_limits(scene), sweep = solve_sweep(scene);
    EXPECT_EQ(answer.status, limits.status);
    const double tolerance = 1e-5 * scene.largest_prescribed() + 1e-12;
    for (std::size_t b = 0; b < answer.displacement.n_components(); ++b) {
      const auto u = answer.displacement.component(b), l = limits.displacement.component(b),
                 s = sweep.displacement.component(b);
      EXPECT_LE(largest_difference(u, l), 1e-12) << "seed " << seed;
      for (std::size_t i = 0; i < u.size(); ++i) // no feasible state moves any component less
        EXPECT_LE(std::abs(u[i]), std::abs(s[i]) + tolerance) << "seed " << seed;
    }
  }
}

} // namespace
} // namespace maille::deform
