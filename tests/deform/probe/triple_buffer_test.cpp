#include "maille/deform/probe/probe.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace maille::deform {
namespace {

TEST(TripleBufferContract, TheReaderGetsTheNewestAndNothingTwice) {
  TripleBuffer<int> buffer(7);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.front(), 7);
  buffer.publish(1);
  buffer.publish(2);
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.front(), 2);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.front(), 2);
  buffer.publish(3);
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.front(), 3);
}

// Contract: what is read is whole, and never older than what was read before, while the other thread writes.
TEST(TripleBufferContract, NothingIsTornBetweenTwoThreads) {
  struct Value {
    std::int64_t numbers[32] = {};
  };
  TripleBuffer<Value> buffer;
  constexpr std::int64_t last = 200'000;
  std::thread writer([&] {
    for (std::int64_t i = 1; i <= last; ++i) {
      for (auto& number : buffer.back().numbers)
        number = i;
      buffer.publish();
    }
  });
  std::int64_t seen = 0, torn = 0, backwards = 0;
  while (seen < last) {
    buffer.update();
    const Value& value = buffer.front();
    for (const std::int64_t number : value.numbers)
      torn += number != value.numbers[0];
    backwards += value.numbers[0] < seen;
    seen = value.numbers[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(backwards, 0);
}

} // namespace
} // namespace maille::deform
