/// Many random pushes of several bodies: what no frame may do.

#include "support/kit.hpp"
#include "support/worlds/random_worlds.hpp"

namespace maille::deform {
namespace {

using test::RandomPushes;

struct Kind {
  int dimension;
  const char* method;
  unsigned worlds;
  int pushes;
};

bool is_finite(const World& world) {
  for (int object = 0; object < world.n_objects(); ++object) {
    if (world.kind(object) != ObjectKind::deformable)
      continue;
    const auto values = world.displacement(object).values();
    if (!std::ranges::all_of(values, [](double value) { return std::isfinite(value); }))
      return false;
  }
  return true;
}

class RandomWorldsContract : public testing::TestWithParam<Kind> {};

// Contract: no voxel in a cell of another object, no limit broken; no matter in matter, by geometry, where
// methods keep links within a cell (what `coupled` stretches without limits has room for a node of another
// between its own: docs/contact.md); nothing but numbers; whatever is pushed, and whenever a frame ends.
TEST_P(RandomWorldsContract, NoPushEverPenetratesOrBreaksALimit) {
  const auto& [dimension, method, all_worlds, pushes] = GetParam();
  const unsigned worlds = test::cases(all_worlds, std::max(2u, all_worlds / 10)); // in one, nothing may meet
  std::size_t contacts = 0, handed_on = 0;
  int n_deep = 0;
  for (unsigned seed = 0; seed < worlds; ++seed) {
    RandomPushes pushed(seed, dimension, method);
    World& world = pushed.world();
    ASSERT_EQ(world.n_penetrations(), 0);
    ASSERT_EQ(world.n_shared_cells(), 0);
    for (int push = 0; push < pushes; ++push) {
      FrameBudget budget;
      budget.rounds = pushed.below(3) == 0 ? 1 + pushed.below(10) : 60;
      const FrameResult result = pushed.push(budget);
      contacts += result.contacts.size();
      handed_on += result.handed_on.size();
      ASSERT_EQ(world.n_shared_cells(), 0) << "world " << seed << ", push " << push;
      n_deep += world.n_penetrations() > 0;
      ASSERT_LT(world.largest_violation(), 1e-9) << "world " << seed << ", push " << push;
      ASSERT_TRUE(is_finite(world)) << "world " << seed << ", push " << push;
      for (const HandOver& hand_over : result.handed_on)
        ASSERT_TRUE(std::isfinite(hand_over.moved));
    }
  }
  EXPECT_LE(n_deep,
            std::string(method) == "coupled" && dimension == 2 ? static_cast<int>(worlds) * pushes / 100 : 0);
  EXPECT_GT(contacts, worlds * static_cast<unsigned>(pushes) / 20); // else nothing was tested
  EXPECT_GT(handed_on, worlds * static_cast<unsigned>(pushes) / 20);
}

INSTANTIATE_TEST_SUITE_P(Worlds, RandomWorldsContract,
                         testing::Values(Kind{1, "limits", 20, 200}, Kind{2, "limits", 20, 200},
                                         Kind{3, "limits", 10, 100}, Kind{2, "relaxed", 10, 60},
                                         Kind{2, "coupled", 20, 60}, Kind{3, "coupled", 6, 40}),
                         [](const auto& kind) {
                           return std::string(kind.param.method) + "_in_" +
                                  std::to_string(kind.param.dimension) + "d";
                         });

// Contract: frames of bodies that slide off edges with friction settle, and those after them.
TEST(CrowdsContract, WhatSlidesOffAnEdgeAndComesBackEnds) {
  for (const unsigned seed :
       {17u, 37u, 71u, 145u, 197u}) { // seeds that once released and met nodes endlessly
    RandomPushes pushed(seed, 2, "coupled");
    for (int push = 0; push < 40; ++push) {
      FrameBudget budget;
      budget.rounds = 300;
      const FrameResult result = pushed.push(budget);
      ASSERT_NE(result.status, Status::budget_reached) << "world " << seed << ", push " << push;
      ASSERT_EQ(pushed.world().n_shared_cells(), 0);
    }
  }
}

// Contract: same input, same bits, at any number of threads.
TEST(ThreadsOfWorldsContract, AnyNumberOfThreadsGivesTheSameBits) {
  for (const char* method : {"limits", "coupled"}) {
    RandomPushes one(3, 2, method), several(3, 2, method);
    for (int push = 0; push < 30; ++push) {
      FrameBudget alone, together;
      alone.rounds = together.rounds = 200;
      together.threads = 5;
      const FrameResult a = one.push(alone), b = several.push(together);
      ASSERT_EQ(a.rounds, b.rounds);
      ASSERT_EQ(a.contacts.size(), b.contacts.size());
      for (int object = 0; object < one.world().n_objects(); ++object)
        if (one.world().kind(object) == ObjectKind::deformable) {
          ASSERT_EQ(one.world().displacement(object), several.world().displacement(object));
        } else {
          ASSERT_EQ(one.world().pose(object).position, several.world().pose(object).position);
        }
    }
  }
}

} // namespace
} // namespace maille::deform
