/// `coupled` by several ranks, here threads: the same bits as by one process.

#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/carved.hpp"
#include "support/thread_ranks.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cstring>

namespace maille::deform {
namespace {

/// The reference is the answer of one process.
void expect_same_bits(const Scene& scene, const std::vector<int>& sizes, int threads = 1) {
  Control control;
  control.threads = threads;
  const Answer alone = solve(scene, "coupled", control);
  ASSERT_EQ(alone.status, Status::done) << alone.message;
  ASSERT_GT(alone.iterations, 3);
  for (const int size : sizes) {
    SCOPED_TRACE(testing::Message() << size << " ranks");
    ASSERT_TRUE(is_for_all_ranks(scene, "coupled", size));
    const auto answers = test::in_ranks(size, [&](Communicator& all) {
      Control of_rank = control;
      of_rank.communicator = &all;
      return solve(scene, "coupled", of_rank);
    });
    for (const Answer& answer : answers) {
      EXPECT_EQ(answer.status, alone.status);
      EXPECT_EQ(answer.iterations, alone.iterations);
      EXPECT_EQ(answer.residual, alone.residual);
      EXPECT_EQ(answer.strain_energy, alone.strain_energy);
    }
    const Answer& first = answers.front();
    EXPECT_EQ(first.reaction, alone.reaction);
    EXPECT_EQ(first.algorithm, alone.algorithm);
    EXPECT_TRUE(first.displacement == alone.displacement);
  }
}

TEST(RanksReference, BodiesOfAFewMaterials) {
  expect_same_bits(test::carved_body({9, 12, 37}, test::Fibres::none), {2, 3, 5});
  expect_same_bits(test::carved_body({14, 5, 24}, test::Fibres::slanted), {2, 6});
}

TEST(RanksReference, BodiesWhoseEveryCellIsAnother) {
  expect_same_bits(test::carved_body({9, 12, 37}, test::Fibres::turning), {2, 3, 9});
}

TEST(RanksReference, Hinges) {
  for (const int contact : {1, 2, 3})
    expect_same_bits(test::two_blocks(10, contact), {2, 4, 5});
}

} // namespace
} // namespace maille::deform
