#include "elastic/elastic_methods.hpp"
#include "feasible/bounds/clipping.hpp"
#include "feasible/limits.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene.hpp"
#include "oracle/sweep.hpp"
#include "support/bodies/holed_bodies.hpp"
#include "support/componentwise_oracle.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

namespace maille::deform {
namespace {

using test::Dice;
using test::even_limits;
using test::face;
using test::hold;
using test::largest_difference;
using test::lattice_box;
using test::move;

constexpr double wide = 1e6;

// ---- analytic ----

TEST(RelaxedAnalytic, ABarOfTwoMaterialsSharesThePullByStiffness) {
  // 1D, unit spacing: E = 1e4 over 6 links and 4e4 over 4, pulled by 1. The force F is the same in all links,
  // F (6 / 1e4 + 4 / 4e4) = 1; energy is F / 2.
  Scene scene = lattice_box({10}, even_limits(wide, -wide, wide));
  scene.materials.push_back(scene.materials[0]);
  scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0.3);
  scene.materials[1].elasticity = ElasticConstants::isotropic(4e4, 0.3);
  scene.specimen.material_id = {0, 0, 0, 0, 0, 0, 1, 1, 1, 1};
  hold(scene, {0, 0, 0});
  move(scene, {10, 0, 0}, {1, 0, 0});
  scene.relaxation.tolerance = 1e-7;
  const Answer answer = solve_relaxed(scene);
  EXPECT_EQ(answer.status, Status::done);
  const double force = 1 / (6 / 1e4 + 4 / 4e4);
  for (int k = 0; k <= 10; ++k)
    EXPECT_NEAR(answer.displacement(0, k), force * (k <= 6 ? k / 1e4 : 6 / 1e4 + (k - 6) / 4e4), 2e-7);
  ASSERT_EQ(answer.reaction.size(), 2U);
  EXPECT_NEAR(answer.reaction[0], -force, 1e-6 * force);
  EXPECT_NEAR(answer.reaction[1], force, 1e-6 * force);
  EXPECT_NEAR(answer.strain_energy.value(), force / 2, 1e-6 * force);
}

TEST(RelaxedAnalytic, LoadsOnABarAreNodallyExact) {
  // 1D bar of length 8 held at 0, E = 1e4, cross-section 1: traction t gives u = t x / E; weight q per length
  // gives u = q (L x - x^2 / 2) / E. The hold carries both.
  Scene scene = lattice_box({8}, even_limits(wide, -wide, wide));
  hold(scene, {0, 0, 0});
  scene.materials[0].density = 100;
  scene.gravity = {2, 0, 0};
  scene.tractions.push_back({7, 0, true, {300, 0, 0}});
  scene.relaxation.tolerance = 1e-7;
  const Answer answer = solve_relaxed(scene);
  EXPECT_EQ(answer.status, Status::done);
  for (int x = 0; x <= 8; ++x)
    EXPECT_NEAR(answer.displacement(0, x), (300 * x + 200 * (8 * x - x * x / 2.0)) / 1e4, 1e-6);
  EXPECT_NEAR(answer.reaction.at(0), -(300 + 200 * 8), 1e-3);
}

TEST(RelaxedAnalytic, LoadsAloneAreElasticWithoutLimits) {
  // The bar above, whose material has limits that the scene does not use: u = q (L x - x^2 / 2) / E exceeds
  // them by far.
  Scene scene = lattice_box({8}, {});
  scene.limits = {};
  scene.materials[0].limits = even_limits(1.001, 0.999, 0.001);
  hold(scene, {0, 0, 0});
  scene.materials[0].density = 100;
  scene.gravity = {2, 0, 0};
  scene.relaxation.tolerance = 1e-7;
  for (const bool has_limits : {true, false}) { // else the ones that others take are taut
    if (!has_limits)
      scene.materials[0].limits.reset();
    const Answer answer = solve_relaxed(scene);
    EXPECT_EQ(answer.status, Status::done) << answer.message;
    for (int x = 0; x <= 8; ++x)
      EXPECT_NEAR(answer.displacement(0, x), 200 * (8 * x - x * x / 2.0) / 1e4, 1e-6);
  }
  scene.limits.from = LimitSource::taut; // asked for: nothing moves, so nothing says how much slack there is
  const Answer refused = solve_relaxed(scene);
  EXPECT_EQ(refused.status, Status::refused);
  EXPECT_NE(refused.message.find("only loads"), std::string::npos) << refused.message;
}

TEST(RelaxedContract, StaysWithinLimitsThatAreAskedForAndThoseAlone) {
  // Pulled by a half of its length; the material may stretch by a tenth.
  Scene scene = lattice_box({10}, {});
  scene.limits = {};
  scene.materials[0].limits = even_limits(1.1, 0.9, 0.1);
  hold(scene, {0, 0, 0});
  move(scene, {10, 0, 0}, {5, 0, 0});
  EXPECT_EQ(solve_relaxed(scene).status, Status::done);
  EXPECT_EQ(solve_relaxed(scene).displacement(0, 10), 5);
  scene.limits.from = LimitSource::material;
  const Answer cut = solve_relaxed(scene);
  EXPECT_EQ(cut.status, Status::clamped);
  EXPECT_NEAR(cut.displacement(0, 10), 1, 1e-9);
  EXPECT_NE(cut.message.find("cut = \"allowed\""), std::string::npos) << cut.message;
}

TEST(RelaxedAnalytic, SimpleShearAndPullAreLinear) {
  // Rows across the pull have links of half and quarter weight at the surface; a linear field is in balance
  // only if they do.
  Scene scene = lattice_box({6, 5, 7}, even_limits(wide, -wide, wide));
  for (const Index3& at : face(scene, 2, false))
    hold(scene, at);
  for (const Index3& at : face(scene, 2, true))
    move(scene, at, {0.5, -0.25, 1});
  scene.relaxation.tolerance = 1e-7;
  const Answer answer = solve_relaxed(scene);
  for (std::int64_t n = 0; n < scene.specimen.grid.n_nodes(); ++n) {
    const double t = scene.specimen.grid.node_at(n)[2] / 7.0;
    EXPECT_NEAR(answer.displacement(0, n), 0.5 * t, 2e-7);
    EXPECT_NEAR(answer.displacement(1, n), -0.25 * t, 2e-7);
    EXPECT_NEAR(answer.displacement(2, n), t, 2e-7);
  }
}

TEST(RelaxedAnalytic, RigidLinksDoNotJam) {
  // The example that jams `sweep`: at the least energy the pair in the middle goes half the way.
  Scene scene = test::pulled_chain({0, 0, 1, 0, 0}, even_limits(2, 0, 0), even_limits(1, 1, 0), 1);
  scene.relaxation.tolerance = 1e-6;
  const Answer answer = solve_relaxed(scene);
  EXPECT_EQ(answer.status, Status::done);
  EXPECT_NEAR(answer.displacement(0, 2), 0.5, 1e-5);
  EXPECT_EQ(answer.displacement(0, 3) - answer.displacement(0, 2), 0);
  // Four links of E A / h = 1e4 (1 / (1 / C) in 1D) in a row, stretched by 1 in all.
  EXPECT_NEAR(answer.reaction.at(1), 1e4 / 4, 1);
}

// ---- every body, and an end ----

TEST(RelaxedContract, IsFeasibleOnHoledBodiesWhateverTheBudget) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::holed_body(random);
    scene.relaxation.tolerance = 1e-2;
    const LinkLimits limits(scene);
    for (const int polls : {0, 1, 3, 1000000}) {
      Control control;
      int asked = 0;
      control.stop_requested = [&] { return ++asked > polls; };
      const Answer answer = solve_relaxed(scene, control);
      ASSERT_TRUE(has_displacement(answer.status)) << "seed " << seed << " " << answer.message;
      if (polls == 0) {
        EXPECT_EQ(answer.status, Status::interrupted);
      }
      // Tiles count in quanta: three of 2^-29 of what is asked for (see TiledBody), over rest lengths of 0.5
      // or more.
      EXPECT_LE(largest_violation(scene, limits, answer.displacement),
                1e-12 + 8e-8 * std::max(1.0, scene.largest_prescribed()))
          << "seed " << seed << " polls " << polls;
      const Clipping clipping = clip(scene, limits);
      for (std::size_t k = 0; k < scene.prescribed.size(); ++k)
        EXPECT_NEAR(answer.displacement(scene.prescribed[k].component, scene.prescribed[k].node),
                    clipping.prescribed[k].value, 1e-6 * (1 + scene.largest_prescribed()));
    }
  }
}

TEST(RelaxedContract, ATimeBudgetEndsItWithAFeasibleState) {
  std::mt19937 random(5);
  Scene scene = lattice_box({20, 20, 20}, even_limits(1.1, 0.9, 0.05));
  for (const Index3& at : face(scene, 2, false))
    hold(scene, at);
  move(scene, {10, 10, 20}, {0, 0, -1.5});
  scene.relaxation.tolerance = 1e-9;
  Control control;
  control.seconds_budget = 0.02;
  const Answer answer = solve_relaxed(scene, control);
  EXPECT_EQ(answer.status, Status::budget_reached);
  EXPECT_GT(answer.residual, 1e-9);
  EXPECT_TRUE(answer.reaction.empty());
  EXPECT_LE(largest_violation(scene, LinkLimits(scene), answer.displacement), 1e-13);
  EXPECT_EQ(answer.displacement(2, scene.specimen.grid.node({10, 10, 20})), -1.5);
}

TEST(RelaxedContract, ALoadOnMatterThatNothingHoldsFails) {
  Scene scene = lattice_box({3, 3}, even_limits(wide, -wide, wide));
  test::prescribe(scene, 0, 0, 0, true); // held along x only
  scene.gravity = {0, -9.81, 0};
  const Answer answer = solve_relaxed(scene);
  EXPECT_EQ(answer.status, Status::failed);
  EXPECT_NE(answer.message.find("nothing says where it ends"), std::string::npos) << answer.message;
}

// ---- accuracy and cost ----

Scene poked_box(int n, const ElasticConstants& elasticity) {
  Scene scene = lattice_box({n, n, n}, even_limits(wide, -wide, wide));
  scene.materials[0].elasticity = elasticity;
  for (const Index3& at : face(scene, 2, false))
    hold(scene, at);
  for (const Index3& at : face(scene, 2, true))
    if (std::abs(at[0] - n / 2) <= n / 8 && std::abs(at[1] - n / 2) <= n / 8)
      move(scene, at, {1, 0.5, -1});
  return scene;
}

TEST(RelaxedContract, ErrorsStayBelowTheToleranceAndIterationsDoNotGrow) {
  // Against a solve to 1e-9. The estimate is no bound: it may be off by a factor, which is 3 here. Cycles of
  // three components, the start of each included; odd numbers of intervals too.
  const ElasticConstants soft = ElasticConstants::isotropic(1e4, 0.3);
  const auto fibres = [](double ratio) {
    return ElasticConstants::transversely_isotropic(ratio * 1e4, 1e4, 4e3, 0.3, 0.3);
  };
  for (const int n : {16, 32, 33, 47}) {
    if (n > test::cases(47, 16))
      break;
    for (const auto& [elasticity, most] :
         {std::pair(soft, 12), std::pair(fibres(50), 18), std::pair(fibres(1000), 21)}) {
      Scene scene = poked_box(n, elasticity);
      scene.relaxation.tolerance = 1e-9;
      const Answer exact = solve_relaxed(scene);
      EXPECT_LE(exact.residual, 1e-9);
      for (const double tolerance : {1e-2, 1e-3, 1e-5}) {
        scene.relaxation.tolerance = tolerance;
        const Answer answer = solve_relaxed(scene);
        EXPECT_EQ(answer.status, Status::done);
        EXPECT_LE(answer.residual, tolerance);
        for (std::size_t b = 0; b < 3; ++b)
          EXPECT_LE(largest_difference(answer.displacement.component(b), exact.displacement.component(b)),
                    3 * tolerance)
              << n << " cells, tolerance " << tolerance;
        if (tolerance == 1e-3) {
          EXPECT_LE(answer.iterations, most) << n << " cells";
        }
      }
    }
  }
}

TEST(RelaxedContract, AHomogeneousBoxHoldsNothingPerLink) {
  // 24 bytes a node for the answer; 36 for the two large pages that hold u, f, r and p in float32, an eighth
  // more and a bit for coarser levels, with rows padded from 49 to 64; some 6 for what is prescribed. Weights
  // of links would be 16 more.
  const Scene scene = poked_box(48, ElasticConstants::isotropic(1e4, 0.3));
  const Answer answer = solve_relaxed(scene);
  EXPECT_LE(double(answer.bytes) / double(scene.specimen.grid.n_nodes()), 70);
}

// Truth: the limits: a chain of eight links that stretch by a tenth each grants 0.8 of a move by 2.
TEST(RelaxedContract, WhatLimitsCutIsCountedWhateverTheStatus) {
  Scene scene = lattice_box({8}, even_limits(1.1, 0.9, 1));
  hold(scene, {0, 0, 0});
  move(scene, {8, 0, 0}, {2, 0, 0});
  EXPECT_EQ(solve_relaxed(scene).n_cut, 1);
  Control control;
  control.seconds_budget = 0;
  const Answer stopped = solve_relaxed(scene, control);
  EXPECT_EQ(stopped.status, Status::budget_reached);
  EXPECT_EQ(stopped.n_cut, 1);
  EXPECT_FALSE(stopped.message.empty());
}

/// `relaxed` against obvious versions: dense matrices, sweeps, least movement.

/// A random body whose limits are far away.
Scene free_body(std::mt19937& random) {
  Scene scene = test::holed_body(random);
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
          ElasticConstants::transversely_isotropic(1e4 * double(1 + 9 * m), 1e4, 3e3, 0.3, 0.2);
    scene.relaxation.tolerance =
        2e-7; // of an energy norm, estimated: the largest difference may be some times as much
    const Answer answer = solve_relaxed(scene);
    ASSERT_EQ(answer.status, Status::done) << "seed " << seed << " " << answer.message;
    double energy = 0;
    for (int b = 0; b < scene.dimension(); ++b) {
      const auto links = test::weighted_links(scene, LinkLimits(scene), b);
      const Displacement all = test::dense_problem(scene, scene.prescribed, b).elastic();
      const std::span<const double> expected = all.component(b);
      energy += test::energy_of(links, expected);
      EXPECT_LE(largest_difference(answer.displacement.component(b), expected),
                2e-6 * scene.largest_prescribed())
          << "seed " << seed;
      for (std::size_t k = 0; k < scene.prescribed.size(); ++k) {
        const Prescribed& p = scene.prescribed[k];
        if (p.component != b)
          continue;
        double force = 0, size = 0;
        for (const test::WeightedLink& link : links)
          for (const int side : {0, 1})
            if (p.node == (side == 0 ? link.near : link.far)) {
              const double pull = (side == 0 ? -1 : 1) * link.weight *
                                  (expected[std::size_t(link.far)] - expected[std::size_t(link.near)]);
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
      scene.specimen.material_id.push_back(std::uint8_t(dice.below(2)));
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
      const Displacement expected = test::dense_problem(scene, scene.prescribed, b, forces).elastic();
      EXPECT_LE(largest_difference(answer.displacement.component(b), expected.component(b)),
                4e-6 * test::largest(expected))
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

TEST(RelaxedOracle, ActiveLimitsEqualTheDenseQuadraticProgram) {
  int active = 0;
  for (unsigned seed = 1; seed <= 80; ++seed) {
    std::mt19937 random(seed);
    Scene scene = test::random_body(random);
    scene.relaxation.tolerance = 1e-6;
    const LinkLimits limits(scene);
    const std::vector<Prescribed> clipped = clip(scene, limits).prescribed;
    const Answer answer = solve_relaxed(scene);
    ASSERT_TRUE(has_displacement(answer.status)) << answer.message;
    EXPECT_LE(largest_violation(scene, limits, answer.displacement), 1e-13) << "seed " << seed;
    double energy = 0;
    bool has_converged = is_converged(answer.status);
    for (int b = 0; b < scene.dimension(); ++b) {
      Displacement expected;
      has_converged = test::dense_problem(scene, clipped, b).solve(expected) && has_converged;
      energy += test::energy_of(test::weighted_links(scene, limits, b), expected.component(b));
      if (has_converged) {
        EXPECT_LE(largest_difference(answer.displacement.component(b), expected.component(b)),
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
    Scene scene = test::random_body(random);
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

// What relaxed_weights do, and to whom.

/// A bar of a belly between two tendons, pulled; the limits are out of the way.
Scene bar(const std::string& belly) {
  return parse_scene(R"(units = "m, rad"
[specimen]
shape = "muscle"
cells = [10]
spacing = "1 mm"
tendon = { fraction = 0.2, material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 } }
material = )" + belly +
                     R"(
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["1 mm"]
[limits]
from = "given"
stretch = 2
compress = 0
shear = 1
[relaxation]
tolerance = 1e-10
)");
}

// Springs in series: a quarter of the weight is a quarter of the modulus.
TEST(RelaxedWeightsOracle, AWeightIsAModulusOfItsOwn) {
  const Scene weighted = bar("{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3, relaxed_weights = 0.25 }");
  const Scene softer = bar("{ youngs_modulus = \"2.5 kPa\", poisson_ratio = 0.3 }");
  const Scene plain = bar("{ youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }");
  const auto at = [](const Scene& scene, const char* method) {
    return solve(scene, method).displacement(0, 2);
  };
  EXPECT_NEAR(at(weighted, "relaxed"), at(softer, "relaxed"), 1e-12);
  EXPECT_GT(at(plain, "relaxed") - at(weighted, "relaxed"), 1e-4);
  for (const char* method : {"coupled", "limits", "sweep"})
    EXPECT_EQ(at(weighted, method), at(plain, method)) << method << " knows no weights";
}

// Weights turn as slack does: by squares, so a quarter turn moves them from one axis to the other.
TEST(RelaxedWeightsOracle, TheyTurnWithTheFibre) {
  const auto sheet = [](const std::string& fibre, const std::string& weights) {
    return parse_scene(
        "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [6, 4]\nspacing = \"1 mm\"\nfibre = " +
        fibre + "\nmaterial = { youngs_modulus = 1e4, poisson_ratio = 0.3, relaxed_weights = " + weights +
        " }\n[[hold]]\nwhere = \"y-\"\n[[move]]\nwhere = { box = [[0.002, 0.004], [0.004, 0.004]] }\nby = "
        "[1e-4, "
        "-2e-4]\n");
  };
  const Displacement along = solve(sheet("[1, 0, 0]", "[0.5, 2, 1]"), "relaxed").displacement;
  const Displacement across = solve(sheet("[0, 1, 0]", "[2, 0.5, 1]"), "relaxed").displacement;
  for (std::size_t node = 0; node < along.values().size(); ++node)
    EXPECT_NEAR(along.values()[node], across.values()[node], 1e-12);
}

} // namespace
} // namespace maille::deform
