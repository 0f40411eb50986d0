/// The relaxers' answers cost no more than any other answer that was found for the same question, in the
/// energy that each lowers.

#include "checks/random_scene.hpp"
#include "maille/deform/solve.hpp"
#include "support/componentwise_oracle.hpp"
#include "support/dense_program.hpp"
#include "support/fields.hpp"
#include "support/sanitized.hpp"

#include <gtest/gtest.h>

namespace maille::lab {
namespace {

constexpr double tolerance = 1e-5;

/// Random scenes that ask for a least energy: no loads (their work is another sum), no dead zone, in the
/// grid's frame.
template<class Visit>
void for_each_elastic_scene(std::uint64_t first, int n, const Visit& visit) {
  for (std::uint64_t seed = first; n > 0; ++seed) {
    Choices choices(seed);
    Scene scene = random_scene(choices);
    scene.relaxation.mode = RelaxationMode::elastic;
    scene.relaxation.extrapolation = Extrapolation::none;
    scene.relaxation.tolerance = tolerance;
    if (scene.has_loads() || object_frame(scene).is_turned)
      continue;
    visit(scene, seed);
    --n;
  }
}

double energy_of_links(const Scene& scene, const Displacement& u) {
  double sum = 0;
  const LinkLimits limits(scene);
  for (int b = 0; b < scene.dimension(); ++b)
    sum += tests::energy_of(tests::weighted_links(scene, limits, b), u.component(b));
  return sum;
}

/// What a rigid motion may cost [J] where the solve ends: every link off by the tolerance, of the largest
/// displacement.
double energy_of_tolerance(const Scene& scene, const Displacement& u) {
  double weights = 0;
  for (int b = 0; b < scene.dimension(); ++b)
    for (const tests::WeightedLink& link : tests::weighted_links(scene, LinkLimits(scene), b))
      weights += link.weight;
  return weights * std::pow(tolerance * test::largest(u), 2);
}

TEST(CoupledEnergyOracle, IsNotAboveThatOfAnyOtherMethodsAnswer) {
  int compared = 0;
  for_each_elastic_scene(1, test::cases(300, 30), [&](const Scene& scene, std::uint64_t seed) {
    const Answer coupled = deform::solve(scene, "coupled");
    if (coupled.status != Status::done)
      return;
    const double least = tests::elastic_energy(scene, coupled.displacement);
    for (const char* method : {"limits", "sweep", "relaxed"}) {
      const Answer other = deform::solve(scene, method);
      if (other.n_cut > 0 || (other.status != Status::done && other.status != Status::budget_reached))
        continue;
      const double energy = tests::elastic_energy(scene, other.displacement);
      EXPECT_LE(least, energy * (1 + 10 * tolerance) + energy_of_tolerance(scene, other.displacement))
          << "seed " << seed << " " << method << "\n"
          << in_words(scene);
      ++compared;
    }
  });
  EXPECT_GE(compared, test::cases(150, 10));
}

TEST(RelaxedEnergyOracle, IsNotAboveThatOfAnyOtherFeasibleAnswer) {
  int compared = 0;
  for_each_elastic_scene(1, test::cases(800, 80), [&](const Scene& scene, std::uint64_t seed) {
    const Answer relaxed = deform::solve(scene, "relaxed");
    if (!is_converged(relaxed.status))
      return;
    const double least = energy_of_links(scene, relaxed.displacement);
    for (const char* method : {"limits", "sweep"}) { // feasible, and cut back alike
      const Answer other = deform::solve(scene, method);
      if (other.n_cut > 0 || !has_displacement(other.status))
        continue;
      EXPECT_LE(least, energy_of_links(scene, other.displacement) * (1 + 10 * tolerance) +
                           energy_of_tolerance(scene, other.displacement))
          << "seed " << seed << " " << method << "\n"
          << in_words(scene);
      ++compared;
    }
  });
  EXPECT_GE(compared, test::cases(1000, 80));
}

} // namespace
} // namespace maille::lab
