#pragma once
/// Answers of single algorithms of `coupled`, and comparison of two answers.

#include "elastic/ladder/ladder.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

namespace maille::test {

inline Answer solve_by(deform::CoupledAlgorithm& algorithm, const Scene& scene, int threads = 1) {
  deform::ThreadTeam team(threads);
  const Control control;
  const deform::Clock clock;
  Answer answer;
  EXPECT_TRUE(algorithm({scene, control, scene.prescribed, team, clock, [] { return false; }}, answer));
  return answer;
}

/// @param of_displacement tolerance, relative, Euclidean; @param of_reaction tolerance relative to the
/// largest reaction; energies may differ by 1e-10 of themselves
inline void expect_same_answer(const Answer& found, const Answer& oracle, double of_displacement,
                               double of_reaction) {
  EXPECT_LE(relative_difference(found.displacement, oracle.displacement), of_displacement);
  EXPECT_NEAR(*found.strain_energy, *oracle.strain_energy, 1e-10 * *oracle.strain_energy);
  ASSERT_EQ(found.reaction.size(), oracle.reaction.size());
  double most = 0;
  for (const double force : oracle.reaction)
    most = std::max(most, std::abs(force));
  for (std::size_t i = 0; i < oracle.reaction.size(); ++i)
    EXPECT_NEAR(found.reaction[i], oracle.reaction[i], of_reaction * most);
}

} // namespace maille::test
