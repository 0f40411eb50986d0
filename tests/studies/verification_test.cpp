#include "bench/world/ball_on_layer.hpp"
#include "support/kit.hpp"
#include "verify/verification.hpp"

namespace maille::lab {
namespace {

VerificationRow row_with(double expected, double computed, double tolerance) {
  VerificationRow row;
  row.problem = "a problem";
  row.method = "fem_q1";
  row.expected = expected;
  row.computed = computed;
  row.tolerance = tolerance;
  return row;
}

// Truth of every number in it: the closed form that the row names.
TEST(VerificationAnalytic, EveryProblemIsWithinItsTolerance) {
  VerificationOptions options;
  options.quick = true;
  const auto rows = verify(options);
  EXPECT_GE(rows.size(), 50u);
  for (const VerificationRow& row : rows)
    EXPECT_TRUE(row.is_met()) << row.problem << ", " << row.method << ", " << row.quantity << ": expected "
                              << row.expected << ", computed " << row.computed;
}

TEST(VerificationContract, WhatIsOutOfToleranceOrNoNumberIsCounted) {
  const double nothing = std::numeric_limits<double>::quiet_NaN();
  const std::vector<VerificationRow> rows{row_with(2, 2.01, 0.01), row_with(2, 2.05, 0.01),
                                          row_with(2, 1.95, 0.01), row_with(2, nothing, 0.01)};
  const BenchReport report = verification_report(rows, 2e-6);
  ASSERT_EQ(report.checks.size(), 2u);
  EXPECT_EQ(report.checks[0].name, "verify_missed");
  EXPECT_EQ(report.checks[0].value, 3);
  EXPECT_EQ(report.checks[1].name, "ccx_worst_relative_difference");
  EXPECT_EQ(report.rows.at(1)["met"], false);
}

/// The truth that a ball on a block is held against.

constexpr double youngs_modulus = 1e4, poisson_ratio = 0.3,
                 modulus = youngs_modulus / (1 - poisson_ratio * poisson_ratio);

// Reference: Sneddon 1965, a sphere on a half-space, by its radius of contact.
TEST(BallOnLayerReference, AThickLayerIsAHalfSpace) {
  for (const double depth : {0.05, 0.1, 0.3}) {
    double low = 0, high = 0.99;
    for (int i = 0; i < 60; ++i) {
      const double a = 0.5 * (low + high);
      (0.5 * a * std::log((1 + a) / (1 - a)) < depth ? low : high) = a;
    }
    const double force = modulus / 2 * ((low * low + 1) * std::log((1 + low) / (1 - low)) - 2 * low);
    EXPECT_NEAR(ball_on_layer(1, depth, 1e3, youngs_modulus, poisson_ratio).force, force, 2e-3 * force);
  }
}

// Reference: Garcia and Garcia 2018 (Biophys. J. 114), of matter that keeps its volume: a series in the
// radius of contact over the thickness, for balls that are large against their depth.
TEST(BallOnLayerReference, AThinLayerIsStifferByTheKnownSeries) {
  for (const double part : {0.1, 0.2, 0.3}) {
    const double depth = 1e-4, hertz = 4.0 / 3 * youngs_modulus / 0.75 * std::pow(depth, 1.5);
    const double series =
        1 + 1.133 * part + 1.497 * std::pow(part, 2) + 1.469 * std::pow(part, 3) + 0.755 * std::pow(part, 4);
    const double found = ball_on_layer(1, depth, std::sqrt(depth) / part, youngs_modulus, 0.5).force;
    EXPECT_NEAR(found / hertz, series, 5e-3 * series) << part;
  }
}

} // namespace
} // namespace maille::lab
