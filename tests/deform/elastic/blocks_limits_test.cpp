/// Limits where strains are measured cell by cell.

#include "maille/deform/solve.hpp"
#include "maille/scene/block_frames.hpp"
#include "support/bodies/bent_bar.hpp"
#include "support/bodies/lattice_scenes.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using std::numbers::pi;
using test::bent_bar;

/// Stretch and compression up to `strain`.
Scene with_strains(const Scene& scene, double strain, double shear) {
  return tests::with_limits(scene, tests::even_limits(1 + strain, 1 - strain, shear));
}

// Truth: largest_violation_in_blocks, which knows nothing of how limits are enforced.
TEST(BlocksContract, EveryAnswerIsWithinTheLimits) {
  for (const int dimension : {2, 3})
    for (const auto& [strain, shear] : {std::pair(0.15, 0.5), std::pair(0.02, 0.5), std::pair(0.02, 0.02)}) {
      const Scene scene = with_strains(bent_bar(dimension, 3, pi / 2), strain, shear);
      const Answer answer = solve(scene, "coupled");
      SCOPED_TRACE(answer.message);
      ASSERT_TRUE(is_converged(answer.status));
      EXPECT_LE(largest_violation_in_blocks(scene, LinkLimits(scene), answer.displacement), 1e-9);
      EXPECT_NE(answer.message.find("limits"), std::string::npos); // the surface would be strained by 0.196
      const bool is_cut = answer.status == Status::clamped;
      EXPECT_EQ(is_cut, answer.message.find("limits grant") != std::string::npos);
      double off = 0;
      for (const Prescribed& p : scene.prescribed)
        off = std::max(off, std::abs(answer.displacement(p.component, p.node) - p.value));
      EXPECT_EQ(off > 0, is_cut);
      EXPECT_GT(answer.residual, scene.relaxation.tolerance); // it is not the state of least energy
    }
}

// Truth: the elastic answer, which none of the limits touches.
TEST(BlocksContract, WideLimitsChangeNothing) {
  const Scene free = bent_bar(3, 2, pi / 2), limited = with_strains(free, 0.5, 1);
  const Answer expected = solve(free, "coupled"), answer = solve(limited, "coupled");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  EXPECT_EQ(answer.displacement, expected.displacement);
  EXPECT_EQ(answer.reaction, expected.reaction);
  EXPECT_EQ(answer.message, expected.message);
}

TEST(BlocksContract, ItIsWithinTheLimitsWheneverItIsStopped) {
  const Scene scene = with_strains(bent_bar(3, 2, pi / 2), 0.1, 0.1);
  for (const int polls : {0, 3, 15, 40}) {
    Control control;
    int left = polls;
    control.stop_requested = [&left] { return left-- <= 0; };
    const Answer answer = solve(scene, "coupled", control);
    EXPECT_EQ(answer.status, Status::interrupted) << answer.message;
    EXPECT_LE(largest_violation_in_blocks(scene, LinkLimits(scene), answer.displacement), 1e-9) << polls;
  }
}

} // namespace
} // namespace maille::deform
