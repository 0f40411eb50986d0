/// Promises of worlds after every frame, checked on random worlds. A failure prints its seed and the smallest
/// play that breaks a promise; MAILLE_SEED=N begins at another seed.

#include "checks/promises.hpp"
#include "checks/world_promises.hpp"

#include "support/sanitized.hpp"
#include "support/worlds/worlds.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>

namespace maille::lab {
namespace {

TEST(RandomPlaysContract, KeepEveryPromise) {
  const char* const given = std::getenv("MAILLE_SEED");
  const std::uint64_t first = given != nullptr ? std::strtoull(given, nullptr, 10) : 1;
  const std::uint64_t n = test::cases(60, 12);
  for (std::uint64_t seed = first; seed < first + n; ++seed)
    if (const std::string broken = broken_promise_of_world_seed(seed); !broken.empty())
      ADD_FAILURE() << broken;
}

TEST(RandomPlaysOfOneSeedContract, AreTheSame) {
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    Choices one(seed), two(seed);
    EXPECT_EQ(in_words(random_world(one)), in_words(random_world(two)));
    EXPECT_EQ(one.made(), two.made());
  }
}

TEST(RandomPlaysSpreadContract, EveryKindOfWorldIsAmongThem) {
  std::map<std::string, int> seen;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Choices choices(seed);
    const WorldPlay play = random_world(choices);
    ++seen["dimension " + std::to_string(play.scene.dimension)];
    ++seen["contact " + std::to_string(static_cast<int>(play.scene.contact))];
    ++seen[play.scene.method];
    seen["dynamics"] += play.scene.dynamics ? 1 : 0;
    seen["friction"] += play.scene.friction > 1 ? 1 : 0;
    for (const WorldObject& object : play.scene.objects) {
      ++seen["kind " + std::to_string(static_cast<int>(object.kind))];
      const double ratio = object.scene.specimen.grid.spacing()[0] / play.scene.spacing[0];
      seen["finer"] += ratio < 0.3 ? 1 : 0;
      seen["coarser"] += ratio > 3 ? 1 : 0;
      seen["turned"] += object.turn_angle != 0 ? 1 : 0;
    }
  }
  for (const char* kind : {"dimension 1", "dimension 2", "dimension 3", "contact 0", "contact 1", "contact 2",
                           "limits", "relaxed", "coupled", "sweep", "dynamics", "friction", "kind 0",
                           "kind 1", "kind 2", "finer", "coarser", "turned"})
    EXPECT_GE(seen[kind], 8) << kind;
}

// Two boxes that meet with their surfaces, the lower one fixed; then the frame's result is falsified.
TEST(BrokenWorldPromiseContract, IsFoundWhereThereIsOne) {
  WorldScene scene = tests::empty_world({12, 12}, "coupled");
  scene.contact = ContactLaw::surfaces;
  scene.objects = {tests::box_object("floor", ObjectKind::fixed, {8, 2}, {2, 2, 0}),
                   tests::box_object("tool", ObjectKind::rigid, {2, 2}, {5, 4.5, 0})};
  deform::World world(scene);
  deform::Drive drive;
  drive.object = 1;
  drive.motion.by = {0, -1, 0};
  const deform::FrameResult result = world.advance({&drive, 1});
  const std::vector<bool> in_hand{false, true}, free{false, false};
  ASSERT_GT(result.contacts.size(), 0u);
  EXPECT_EQ(broken_promise(world, result, in_hand), "");
  EXPECT_NE(broken_promise(world, result, free), "") << "the floor presses, and nothing presses back";
  const auto with = [&](const auto& change) {
    deform::FrameResult other = result;
    change(other);
    return broken_promise(world, other, in_hand);
  };
  EXPECT_NE(with([](auto& r) { r.status = Status::failed; }), "");
  EXPECT_NE(with([](auto& r) {
              r.status = Status::clamped;
              r.message.clear();
            }),
            "");
  EXPECT_NE(with([](auto& r) { r.contacts[0].force[0] = NAN; }), "");
  EXPECT_NE(with([](auto& r) { r.drives[0].fraction = INFINITY; }), "");
  EXPECT_NE(with([](auto& r) { r.contacts[0].force *= 2; }), "") << "action is not reaction";
}

} // namespace
} // namespace maille::lab
