#include "oracle/error_estimate.hpp"

#include <cmath>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

TEST(ErrorEstimateAnalytic, IsTheSumOfAGeometricSeries) {
  for (const double rho : {0.5, 0.99, 0.99999}) {
    ErrorEstimate estimate(0);
    double change = 1;
    for (int k = 0; k < 400; ++k, change *= rho)
      estimate.add(change);
    const double rest = change / (1 - rho); // change * (1 + rho + rho^2 + ...)
    EXPECT_NEAR(estimate.remaining() / rest, 1, 1e-9) << rho;
  }
}

TEST(ErrorEstimateAnalytic, NothingCanBeSaidWhileChangesDoNotShrink) {
  ErrorEstimate estimate(0);
  for (int k = 0; k < 100; ++k)
    estimate.add(1.0);
  EXPECT_TRUE(std::isinf(estimate.remaining()));
  estimate.add(0);
  EXPECT_EQ(estimate.remaining(), 0);
}

TEST(ErrorEstimateAnalytic, SlowModesCountMoreThanFastOnes) {
  // 0.5^k + 1e-6 0.999^k: after the fast mode has gone the slow one has 1e-3 left to go.
  ErrorEstimate estimate(0);
  for (int k = 0; k < 300; ++k)
    estimate.add(std::pow(0.5, k) + 1e-6 * std::pow(0.999, k));
  EXPECT_NEAR(estimate.remaining() / (1e-6 * std::pow(0.999, 300) / 0.001), 1, 0.01);
}

TEST(ErrorEstimateAnalytic, RoundingNoiseDoesNotUndoWhatWasKnown) {
  ErrorEstimate estimate(1e-15);
  for (double change = 1; change > 1e-15; change *= 0.9)
    estimate.add(change);
  const double known = estimate.remaining();
  for (int k = 0; k < 50; ++k)
    estimate.add(k % 2 == 0 ? 1e-16 : 2e-16);
  EXPECT_LE(estimate.remaining(), known);
}

} // namespace
} // namespace maille::deform
