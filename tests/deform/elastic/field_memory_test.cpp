#include "lattice/field_memory.hpp"

#include "maille/scene/arena.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <iterator>
#include <random>
#include <vector>

namespace maille::deform {
namespace {

// Truth: what the header promises of sizes below, in and above those that share pages.
TEST(FieldMemoryContract, IsZeroAlignedAndExclusive) {
  struct Field {
    unsigned char* data;
    std::size_t size;
  };
  for (int round = 0; round < 3; ++round) { // what was written before is gone
    std::vector<Field> fields;
    Charge charge;
    for (const std::size_t size :
         {1, 100, 16384, 16385, 700000, 700001, 900000, 1572863, 1572864, 2097152, 2200000, 4056128, 6291457})
      for (int copy = 0; copy < 3; ++copy)
        fields.push_back({static_cast<unsigned char*>(allocate_field(size, charge)), size});
    for (std::size_t i = 0; i < fields.size(); ++i) {
      ASSERT_EQ(reinterpret_cast<std::uintptr_t>(fields[i].data) % 64, 0u);
      for (std::size_t k = 0; k < fields[i].size; ++k)
        ASSERT_EQ(fields[i].data[k], 0) << fields[i].size << ' ' << k;
      std::memset(fields[i].data, static_cast<int>(i) + 1, fields[i].size);
    }
    for (std::size_t i = 0; i < fields.size(); ++i)
      for (std::size_t k = 0; k < fields[i].size; ++k)
        ASSERT_EQ(fields[i].data[k], i + 1);
    for (std::size_t i = 0; i < fields.size(); i += 2) // in another order than they came
      release_field(fields[i].data, fields[i].size);
    for (std::size_t i = 1; i < fields.size(); i += 2)
      release_field(fields[i].data, fields[i].size);
  }
  release_field(nullptr, 5000000);
}

// Truth: what arena.hpp promises of sizes below, in and above those of one region.
TEST(ArrayMemoryContract, ArraysAreAlignedAndExclusive) {
  struct Array {
    unsigned char* data;
    std::size_t size;
    unsigned char mark;
  };
  std::mt19937 random(7); // any
  std::vector<Array> arrays;
  const auto release = [&](std::size_t i) {
    const Array array = arrays[i];
    for (std::size_t k = 0; k < array.size; k += 61)
      ASSERT_EQ(array.data[k], array.mark) << array.size << ' ' << k;
    ASSERT_EQ(array.data[array.size - 1], array.mark);
    release_array(array.data, array.size, 64);
    arrays.erase(arrays.begin() + static_cast<std::ptrdiff_t>(i));
  };
  const std::size_t sizes[] = {1, 65535, 65536, 65537, 100000, 1 << 20, 3000001, 20 << 20, (32 << 20) + 1};
  for (int step = 0; step < 400; ++step) {
    if (arrays.size() < 12 && random() % 3 != 0) {
      const std::size_t size = sizes[random() % std::size(sizes)];
      const auto mark = static_cast<unsigned char>(random() % 251 + 1);
      auto* const data = static_cast<unsigned char*>(allocate_array(size, 64));
      ASSERT_EQ(reinterpret_cast<std::uintptr_t>(data) % 64, 0u);
      std::memset(data, mark, size);
      arrays.push_back({data, size, mark});
    } else if (!arrays.empty())
      release(random() % arrays.size());
  }
  while (!arrays.empty())
    release(0);
}

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) // with which arrays are the heap's
TEST(ArrayMemoryContract, WhatIsGivenBackIsThereForTheNextOne) {
  void* const kept = allocate_array(1 << 17, 64);
  void* const first = allocate_array(1 << 20, 64);
  release_array(first, 1 << 20, 64);
  EXPECT_EQ(allocate_array(1 << 20, 64), first);
  release_array(first, 1 << 20, 64);
  release_array(kept, 1 << 17, 64);
}
#endif

} // namespace
} // namespace maille::deform
