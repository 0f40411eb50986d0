/// Random choices, and how they are made smaller.

#include "checks/random_scene.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace maille::lab {
namespace {

TEST(ChoicesContract, AReplayGivesTheSameNumbersAndThenZeros) {
  Choices choices(7);
  std::vector<int> first;
  for (int n = 1; n < 40; ++n)
    first.push_back(choices.below(n));
  Choices replay(choices.made());
  for (int n = 1; n < 40; ++n)
    EXPECT_EQ(replay.below(n), first[static_cast<std::size_t>(n - 1)]);
  EXPECT_EQ(replay.below(1000), 0);
}

TEST(ChoicesContract, NumbersStayBelowWhatIsAskedHoweverTheyAreReplayed) {
  Choices choices(std::vector<std::uint32_t>{900, 3, 0});
  EXPECT_EQ(choices.below(5), 4) << "the largest that there is";
  EXPECT_EQ(choices.below(5), 3);
}

TEST(ChoicesAnalytic, EveryNumberIsAsLikely) {
  // Truth: 60,000 throws of a die; the standard deviation of a count is 91, five of them are 456.
  Choices choices(1);
  std::array<int, 6> counts{};
  for (int i = 0; i < 60000; ++i)
    ++counts[static_cast<std::size_t>(choices.below(6))];
  for (const int count : counts)
    EXPECT_NEAR(count, 10000, 456);
}

TEST(ShrunkAnalytic, FindsTheSmallestListThatFails) {
  // Fails where the sum of the first ten is 100 or more: the smallest such list that halving leads to has
  // nothing beyond what it needs.
  const auto fails = [](const std::vector<std::uint32_t>& list) {
    return std::accumulate(list.begin(), list.begin() + std::min<std::ptrdiff_t>(10, std::ssize(list)),
                           std::uint32_t{0}) >= 100;
  };
  const std::vector<std::uint32_t> result = shrunk(std::vector<std::uint32_t>(64, 90), fails, 10000);
  EXPECT_TRUE(fails(result));
  EXPECT_LE(result.size(), 10u);
  for (std::size_t i = 0; i < result.size(); ++i) { // nothing can be left out or halved any more
    std::vector<std::uint32_t> smaller = result;
    smaller[i] /= 2;
    EXPECT_TRUE(result[i] == 0 || !fails(smaller)) << i;
  }
}

TEST(ShrunkContract, AsksNoMoreOftenThanItMay) {
  int asked = 0;
  shrunk(
      std::vector<std::uint32_t>(100, 1000), [&](const auto&) { return ++asked > 1000; }, 17);
  EXPECT_EQ(asked, 17);
}

} // namespace
} // namespace maille::lab
