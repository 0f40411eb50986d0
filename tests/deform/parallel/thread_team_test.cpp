/// Threads that stay, and the walk over planes on them. Small, so that the thread sanitizer sees them at
/// every run of scripts/test.

#include "parallel/thread_team.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace maille::deform {
namespace {

// Loops of microseconds, one right after the other: threads that come late to one are there for the next.
TEST(ThreadTeamOracle, EveryItemOfEveryLoopIsDoneOnce) {
  for (const int threads : {1, 2, 3, 8}) {
    ThreadTeam team(threads);
    ASSERT_LE(team.threads(), threads);
    std::vector<int> done(100); // not atomic: no item is two threads'
    std::vector<int> of_thread(std::size_t(team.threads()) * 64);
    constexpr int n_loops = 3000;
    for (int loop = 0; loop < n_loops; ++loop) {
      const int n_items = 1 + loop % 100;
      team.run(n_items, [&](int item, int thread) {
        ++done[std::size_t(item)];
        ++of_thread[std::size_t(thread) * 64];
      });
      // What others wrote is seen as soon as the loop has ended.
      ASSERT_EQ(done[0], loop + 1) << threads << " threads";
    }
    EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), 30 * 5050);
    EXPECT_EQ(std::accumulate(of_thread.begin(), of_thread.end(), 0), 30 * 5050);
  }
}

TEST(ThreadTeamOracle, TeamsComeAndGo) {
  int sum = 0;
  for (int round = 0; round < 200; ++round) {
    ThreadTeam team(4);
    std::vector<int> items(7);
    if (round % 3 != 0) // some never do anything
      team.run(7, [&](int item, int) { items[std::size_t(item)] = item; });
    sum += std::accumulate(items.begin(), items.end(), 0);
  }
  EXPECT_EQ(sum, 133 * 21);
}

// Even slabs share nothing with one another, the others with the two beside them.
TEST(SlabsContract, EverySlabIsDoneOnceAndOddOnesAfterTheirNeighbours) {
  for (const int threads : {1, 2, 3}) {
    ThreadTeam team(threads);
    for (int n = 0; n < 300; ++n) {
      std::vector<int> done(std::size_t(n % 13));
      run_slabs(team, n % 13, [&](int slab) {
        const auto at = std::size_t(slab);
        if (slab % 2 != 0) {
          EXPECT_EQ(done[at - 1], 1);
          EXPECT_TRUE(at + 1 == done.size() || done[at + 1] == 1);
        }
        ++done[at];
      });
      EXPECT_EQ(std::accumulate(done.begin(), done.end(), 0), n % 13);
    }
  }
}

// Every stage of a plane reads the stage before of the plane and of its neighbours.
TEST(PlanePipelineOracle, AsStageByStage) {
  constexpr int n_planes = 90, n_stages = 4;
  const auto walk = [](ThreadTeam& team) {
    std::vector<std::vector<std::uint64_t>> value(n_stages + 1, std::vector<std::uint64_t>(n_planes));
    for (int z = 0; z < n_planes; ++z)
      value[0][std::size_t(z)] = std::uint64_t(z) * 2654435761U;
    run_stages(team, n_planes, n_stages, [&](int s, int z) {
      const auto& before = value[std::size_t(s)];
      const auto at = [&](int plane) {
        return plane < 0 || plane >= n_planes ? 7 : before[std::size_t(plane)];
      };
      value[std::size_t(s) + 1][std::size_t(z)] = 3 * at(z - 1) + 5 * at(z) + 11 * at(z + 1);
    });
    return value.back();
  };
  ThreadTeam one(1);
  const auto expected = walk(one);
  for (const int threads : {2, 3, 5}) {
    ThreadTeam team(threads);
    for (int round = 0; round < 100; ++round)
      ASSERT_EQ(walk(team), expected) << threads;
  }
}

} // namespace
} // namespace maille::deform
