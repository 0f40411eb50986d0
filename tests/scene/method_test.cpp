#include "maille/scene/answer.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

TEST(MethodContract, NamesAreThoseOfTheCommandLine) {
  // Truth: the names as README.md has them, in its order.
  const std::array<std::string_view, 9> names{"limits",  "dijkstra", "literal", "sweep",   "relaxed",
                                              "coupled", "fem_q1",   "fem_q2",  "calculix"};
  ASSERT_EQ(every_method.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(every_method[i]), i);
    EXPECT_EQ(to_string(every_method[i]), names[i]);
    EXPECT_EQ(method_from_string(names[i]), every_method[i]);
  }
}

TEST(MethodContract, OtherNamesAreNone) {
  for (const char* name : {"", "magic", "Coupled", "coupled ", "fem_q3", "limit"})
    EXPECT_FALSE(method_from_string(name)) << name;
}

} // namespace
} // namespace maille
