/// Methods refuse what does not fit before they allocate it.

#include "lattice/field_memory.hpp"
#include "maille/base/arena.hpp"
#include "maille/deform/solve.hpp"
#include "oracle/literal.hpp"
#include "parallel/thread_team.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/named_bodies.hpp"
#include "support/heap_meter.hpp"
#include "support/kit.hpp"

namespace maille::deform {
namespace {

Answer solve_within(const Scene& scene, std::string_view method, std::int64_t bytes) {
  Control control;
  control.bytes_budget = bytes;
  return solve(scene, method, control);
}

TEST(HeapMeterContract, SeesFieldsWhateverTheirPages) {
  if (!test::heap_is_counted())
    GTEST_SKIP() << "allocations cannot be counted here";
  constexpr std::int64_t mib = 1 << 20;
  for (const std::int64_t size : {mib / 4, mib, 2 * mib, 9 * mib}) {
    const test::HeapMeter heap;
    Charge charge;
    const auto bytes = static_cast<std::size_t>(size);
    void* const field = allocate_zeroed(bytes, charge);
    EXPECT_GE(heap.live(), size); // so an upper bound below that would fail
    EXPECT_GE(heap.allocations(), 1);
    EXPECT_LE(heap.peak(), size + 3 * mib); // of a large page that fields are aligned to
    release_zeroed(field, bytes);
    EXPECT_LE(heap.live(), 4096);
  }
}

// Truth: the arrays' sizes.
TEST(ArenaContract, CountsArraysThatAreMadeWhileItIsOpenUntilTheyAreGone) {
  const AlignedArray<double> before(1000);
  const Arena arena;
  AlignedArray<double> kept;
  {
    const Arena::Open open(arena);
    kept = AlignedArray<double>(1000);
    const List<int> list(5000);
    EXPECT_EQ(arena.present(), 8000 + 20000 + 16); // a list has a head of 16 bytes
    const Arena within;
    const Arena::Open open_within(within);
    const AlignedArray<float> inner(300);
    EXPECT_EQ(within.present(), 1200);
    EXPECT_EQ(arena.present(), 8000 + 20016 + 1200);
  }
  const AlignedArray<double> after(1000);
  EXPECT_EQ(arena.present(), 8000);
  EXPECT_EQ(arena.peak(), 8000 + 20016 + 1200);
  kept = {};
  EXPECT_EQ(arena.present(), 0);
}

TEST(ArenaContract, ArraysMayOutliveIt) {
  List<double> list;
  AlignedArray<double> field;
  {
    const Arena arena;
    const Arena::Open open(arena);
    list.assign(100, 1.0);
    field = AlignedArray<double>(600000);
  }
  list.resize(100000, 2.0);
  EXPECT_EQ(list.front() + list.back(), 3.0);
}

// Truth: the limit, and as many bytes as four threads take.
TEST(ArenaContract, RefusesWhatWouldPassItsLimitButNotToThreadsThatHelp) {
  const Arena arena(100000);
  const Arena::Open open(arena);
  AlignedArray<double> half(6250);
  EXPECT_THROW(AlignedArray<double>(6251), ArenaIsFull);
  EXPECT_THROW(List<char>(50000), std::bad_alloc); // its head is too much
  EXPECT_EQ(arena.present(), 50000);
  EXPECT_EQ(arena.peak(), 50000);
  std::vector<AlignedArray<float>> of_threads(64);
  ThreadTeam team(4);
  team.run(64, [&](int i, int) { of_threads[static_cast<std::size_t>(i)] = AlignedArray<float>(1000); });
  EXPECT_EQ(arena.present(), 50000 + 64 * 4000);
  of_threads.clear();
  half = {};
  EXPECT_EQ(arena.present(), 0);
  EXPECT_NO_THROW(List<char>(50000));
}

TEST(ArenaContract, AMethodWhoseForecastWasTooLowEndsAsRefused) {
  Scene scene = test::lattice_box({12, 10, 8}, test::even_limits(1.25, 0.75, 0.25));
  test::move(scene, {3, 4, 5}, {1, 1, -1});
  Control control;
  control.bytes_budget = 20000;
  const Answer answer = solve_literal(scene, control); // asks for no forecast
  EXPECT_EQ(answer.status, Status::refused);
  EXPECT_EQ(answer.message, "literal needs more memory than the 19.5 KiB that are available");
  EXPECT_TRUE(answer.displacement.empty());
}

TEST(MemoryBudgetContract, TheForecastIsTheRefusal) {
  Scene box = test::lattice_box({12, 10, 8}, test::even_limits(1.25, 0.75, 0.25));
  test::move(box, {3, 4, 5}, {1, 1, -1});
  for (const Scene& free :
       {box, named_body("random", test::cases(8, 5)), named_body("bore", test::cases(8, 5))})
    for (const std::string_view method : methods()) {
      Scene scene = free;
      if (method == "coupled") // forces want something to hold against
        for (const Index3& at : test::face(scene, 2, true))
          test::hold(scene, at);
      SCOPED_TRACE(std::string(method) + " on " + scene.name);
      const std::int64_t needed = bytes_needed(scene, method);
      const Answer refused = solve_within(scene, method, needed - 1);
      EXPECT_EQ(refused.status, Status::refused);
      EXPECT_EQ(refused.method, method);
      EXPECT_TRUE(refused.displacement.empty());
      EXPECT_TRUE(
          test::has(refused.message, " needs about " + bytes_in_words(static_cast<double>(needed)) + ", "));
      EXPECT_TRUE(has_displacement(solve_within(scene, method, needed).status));
    }
}

TEST(MemoryBudgetContract, ABoxOf512CubedNodesIsRefusedBeforeAnythingIsAllocated) {
  Scene scene = test::lattice_box({511, 511, 511}, test::even_limits(1.25, 0.75, 0.25));
  test::move(scene, {0, 0, 0}, {300, 0, 0});
  for (const std::string_view method : methods()) {
    const test::HeapMeter heap;
    const Answer answer = solve_within(scene, method, std::int64_t{2} << 30);
    EXPECT_EQ(answer.status, Status::refused);
    EXPECT_LE(heap.peak(), 65536); // a message
  }
  EXPECT_EQ(solve_within(scene, "limits", std::int64_t{2} << 30).message, // 3 * 8 * 512^3 bytes
            "limits needs about 3 GiB, 2 GiB are available");
}

TEST(MemoryBudgetContract, LoadsAreRefusedAsLoadsHoweverLittleMemoryThereIs) {
  Scene scene = test::lattice_box({4, 4, 4}, test::even_limits(1.25, 0.75, 0.25));
  scene.gravity = {0, 0, -9.81};
  EXPECT_TRUE(test::has(solve_within(scene, "limits", 0).message, "loads"));
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
