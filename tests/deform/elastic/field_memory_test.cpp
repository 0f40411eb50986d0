#include "lattice/field_memory.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <vector>

namespace maille::deform {
namespace {

// Truth: what the header promises of sizes below, in and above those that share pages.
TEST(FieldMemoryContract, IsZeroAlignedAndNobodyElses) {
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

} // namespace
} // namespace maille::deform
