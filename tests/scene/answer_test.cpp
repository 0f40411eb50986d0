#include "maille/scene/answer.hpp"

#include "support/bodies/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille {

namespace {

/// A chain of four nodes whose first is held and whose last is moved; errors count over the two between.
Scene chain() {
  Scene scene = test::box_scene(1, {3, 1, 1});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {3e-3, 0, 0});
  return scene;
}

TEST(CompareAnalytic, NormsAreThoseOfTheDefinition) {
  const Scene scene = chain();
  Displacement u(scene.specimen.grid), r(scene.specimen.grid);
  std::ranges::copy(std::vector<double>{9, 3, 4, 9}, r.component(0).begin());
  std::ranges::copy(std::vector<double>{0, 3, 1, 0}, u.component(0).begin());
  // By hand: u - r = (0, -3) over the free nodes, |r| = 5, max |r| = 4, mean square = 9 / 2.
  const ErrorNorms norms = compare(scene, u, r);
  EXPECT_DOUBLE_EQ(norms.relative_l2, 3.0 / 5.0);
  EXPECT_DOUBLE_EQ(norms.relative_max, 3.0 / 4.0);
  EXPECT_DOUBLE_EQ(norms.rms, std::sqrt(4.5));
}

TEST(CompareAnalytic, NumbersOfAnySizeHaveTheirNorms) {
  // Truth: those of the test above, times a power of two that squares of doubles do not hold.
  const Scene scene = chain();
  for (const double unit : {0x1p900, 0x1p-900}) {
    Displacement u(scene.specimen.grid), r(scene.specimen.grid);
    std::ranges::copy(std::vector<double>{9 * unit, 3 * unit, 4 * unit, 9 * unit}, r.component(0).begin());
    std::ranges::copy(std::vector<double>{0, 3 * unit, 1 * unit, 0}, u.component(0).begin());
    const ErrorNorms norms = compare(scene, u, r);
    EXPECT_DOUBLE_EQ(norms.relative_l2, 3.0 / 5.0);
    EXPECT_DOUBLE_EQ(norms.relative_max, 3.0 / 4.0);
    EXPECT_DOUBLE_EQ(norms.rms / unit, std::sqrt(4.5));
  }
}

TEST(CompareAnalytic, LeavesOutNodesHeldInOneComponentOnly) {
  Scene scene = test::box_scene(2, {1, 1, 1});
  scene.prescribed = {{0, 1, 0.0, true}}; // y of node 0
  Displacement u(scene.specimen.grid), r(scene.specimen.grid);
  std::ranges::copy(std::vector<double>{1, 1, 1, 1}, r.component(0).begin());
  std::ranges::copy(std::vector<double>{7, 1, 1, 1}, u.component(0).begin());
  EXPECT_EQ(compare(scene, u, r).relative_l2, 0); // the only difference is at the held node
}

TEST(CompareAnalytic, RelativeErrorWithoutReferenceIsInfinite) {
  const Scene scene = chain();
  Displacement u(scene.specimen.grid), zero(scene.specimen.grid);
  EXPECT_EQ(compare(scene, zero, zero).relative_l2, 0);
  u(0, 1) = 1;
  EXPECT_TRUE(std::isinf(compare(scene, u, zero).relative_l2));
}

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
