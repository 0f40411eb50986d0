#include "maille/deform/probe/servo_loop.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace maille::deform {
namespace {

// Oracle: all durations, sorted.
TEST(LatencyHistogramOracle, QuantilesAreThoseOfTheSortedList) {
  std::mt19937_64 random(3);
  LatencyHistogram histogram;
  std::vector<std::int64_t> all;
  std::lognormal_distribution<double> some(10, 3); // tens of microseconds, with a long tail
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(static_cast<std::int64_t>(some(random)));
    histogram.add(all.back());
  }
  std::ranges::sort(all);
  EXPECT_EQ(histogram.n(), 20'000);
  EXPECT_EQ(histogram.largest(), all.back());
  for (const double share : {0.001, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const std::int64_t exact = all[static_cast<std::size_t>(std::max(share * 20'000 - 1, 0.0))];
    EXPECT_GE(histogram.quantile(share), exact) << share;
    EXPECT_LE(static_cast<double>(histogram.quantile(share)), static_cast<double>(exact) * (1 + 1.0 / 32))
        << share;
  }
  std::int64_t sum = 0, end = -1;
  for (const auto& bin : histogram.bins()) {
    EXPECT_GT(bin.from, end); // bins follow one another and do not overlap
    end = bin.to;
    sum += bin.count;
    const auto inside =
        std::ranges::count_if(all, [&](std::int64_t t) { return t >= bin.from && t <= bin.to; });
    EXPECT_EQ(inside, bin.count);
  }
  EXPECT_EQ(sum, 20'000);
}

TEST(LatencyHistogramAnalytic, ShortDurationsAreKeptExactly) {
  LatencyHistogram histogram, other;
  for (int t = 0; t < 40; ++t)
    (t % 2 == 0 ? histogram : other).add(t);
  histogram.add(other);
  EXPECT_EQ(histogram.n(), 40);
  EXPECT_DOUBLE_EQ(histogram.mean(), 19.5); // analytic: the mean of 0 ... 39
  EXPECT_EQ(histogram.quantile(0.5), 19);
  EXPECT_EQ(histogram.quantile(1), 39);
  EXPECT_EQ(LatencyHistogram().quantile(0.5), 0);
}

} // namespace
} // namespace maille::deform
