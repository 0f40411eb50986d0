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

} // namespace
} // namespace maille::lab
