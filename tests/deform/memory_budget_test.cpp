/// Methods refuse what does not fit before they allocate it.

#include "lattice/field_memory.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/memory.hpp"
#include "maille/scene/named_bodies.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/heap_meter.hpp"
#include "support/sanitized.hpp"

#include <gtest/gtest.h>

namespace maille::deform {
namespace {

Answer solve_within(const Scene& scene, std::string_view method, std::int64_t bytes) {
  Control control;
  control.bytes_budget = bytes;
  return solve(scene, method, control);
}

TEST(HeapMeterContract, SeesFieldsWhateverTheirPages) {
  if (!tests::heap_is_counted())
    GTEST_SKIP() << "allocations cannot be counted here";
  constexpr std::int64_t mib = 1 << 20;
  struct Way {
    void* (*allocate)(std::size_t);
    void (*release)(void*, std::size_t) noexcept;
  };
  for (const Way& way : {Way{allocate_field, release_field}, Way{allocate_zeroed, release_zeroed}})
    for (const std::int64_t size : {mib / 4, mib, 2 * mib, 9 * mib}) {
      const tests::HeapMeter heap;
      const auto bytes = static_cast<std::size_t>(size);
      void* const field = way.allocate(bytes);
      EXPECT_GE(heap.live(), size); // so an upper bound below that would fail
      EXPECT_GE(heap.allocations(), 1);
      EXPECT_LE(heap.peak(), size + 3 * mib); // of a large page that fields share, or are aligned to
      way.release(field, bytes);
      EXPECT_GE(heap.peak(), size);
      EXPECT_LE(heap.live(), 4096); // a list of shared pages stays
    }
}

TEST(MemoryBudgetContract, EveryMethodRefusesOneByteBelowWhatItNeedsAndAnswersWithIt) {
  Scene box = tests::lattice_box({12, 10, 8}, tests::even_limits(1.25, 0.75, 0.25));
  tests::move(box, {3, 4, 5}, {1, 1, -1});
  for (const Scene& free :
       {box, named_body("random", test::cases(8, 5)), named_body("bore", test::cases(8, 5))})
    for (const std::string_view method : methods()) {
      Scene scene = free;
      if (method == "coupled") // forces want something to hold against
        for (const Index3& at : tests::face(scene, 2, true))
          tests::hold(scene, at);
      SCOPED_TRACE(std::string(method) + " on " + scene.name);
      const std::int64_t needed = bytes_needed(scene, method);
      const Answer refused = solve_within(scene, method, needed - 1);
      EXPECT_EQ(refused.status, Status::refused);
      EXPECT_EQ(refused.method, method);
      EXPECT_TRUE(refused.displacement.empty());
      EXPECT_NE(refused.message.find(" needs about " + bytes_in_words(static_cast<double>(needed)) + ", "),
                std::string::npos)
          << refused.message;
      EXPECT_TRUE(has_displacement(solve_within(scene, method, needed).status));
    }
}

TEST(MemoryBudgetContract, ABoxOf512CubedNodesIsRefusedBeforeAnythingIsAllocated) {
  Scene scene = tests::lattice_box({511, 511, 511}, tests::even_limits(1.25, 0.75, 0.25));
  tests::move(scene, {0, 0, 0}, {300, 0, 0});
  for (const std::string_view method : methods()) {
    const tests::HeapMeter heap;
    const Answer answer = solve_within(scene, method, std::int64_t{2} << 30);
    EXPECT_EQ(answer.status, Status::refused);
    EXPECT_LE(heap.peak(), 65536); // a message
  }
  EXPECT_EQ(solve_within(scene, "limits", std::int64_t{2} << 30).message, // 3 * 8 * 512^3 bytes
            "limits needs about 3 GiB, 2 GiB are available");
}

TEST(MemoryBudgetContract, LoadsAreRefusedAsLoadsHoweverLittleMemoryThereIs) {
  Scene scene = tests::lattice_box({4, 4, 4}, tests::even_limits(1.25, 0.75, 0.25));
  scene.gravity = {0, 0, -9.81};
  EXPECT_NE(solve_within(scene, "limits", 0).message.find("loads"), std::string::npos);
}

TEST(BytesInWordsContract, HaveAUnitThatSuitsThem) {
  EXPECT_EQ(bytes_in_words(0), "0 bytes");
  EXPECT_EQ(bytes_in_words(1), "1 byte");
  EXPECT_EQ(bytes_in_words(384), "384 bytes"); // was once 0.000384 MB
  EXPECT_EQ(bytes_in_words(999), "999 bytes");
  EXPECT_EQ(bytes_in_words(1023), "0.999 KiB");
  EXPECT_EQ(bytes_in_words(1536), "1.5 KiB");
  EXPECT_EQ(bytes_in_words(130 * 1048576.0), "130 MiB");
  EXPECT_EQ(bytes_in_words(1048575), "1 MiB");
  EXPECT_EQ(bytes_in_words(5.2 * 1073741824), "5.2 GiB");
  EXPECT_EQ(bytes_in_words(3e15), "2728 TiB");
}

} // namespace
} // namespace maille::deform
