#include "maille/scene/link_limits.hpp"

#include "maille/scene/answer.hpp"
#include "support/bodies/scenes.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

NeighbourLimits given_limits() {
  NeighbourLimits limits;
  limits.stretch = {1.3, 1.1, 1.2};
  limits.compress = {0.8, 0.95, 0.9};
  limits.shear = {{{0, 0.1, 0.2}, {0.3, 0, 0.4}, {0.5, 0.6, 0}}};
  return limits;
}

TEST(LinkLimitsAnalytic, GivenRatiosBecomeMetresAlongEachAxis) {
  Scene scene = test::box_scene(3, {2, 2, 2}, {1e-3, 2e-3, 4e-3});
  scene.limits = {LimitSource::given, given_limits(), {}};
  const LinkLimits limits(scene);
  EXPECT_TRUE(limits.is_homogeneous());
  const auto y = limits.intervals({1, 1, 1}, 1);
  ASSERT_TRUE(y);
  EXPECT_NEAR(y->high[1], 0.1 * 2e-3, 1e-18); // (stretch - 1) h
  EXPECT_NEAR(y->low[1], -0.05 * 2e-3, 1e-18);
  EXPECT_NEAR(y->high[0], 0.3 * 2e-3, 1e-18); // shear[y][x] h
  EXPECT_NEAR(y->low[2], -0.4 * 2e-3, 1e-18);
}

TEST(LinkLimitsAnalytic, LinksExistOnlyBesideMatter) {
  Scene scene = test::box_scene(2, {2, 2, 1});
  scene.specimen.material_id = {0, no_material, no_material, no_material};
  scene.limits = {LimitSource::given, given_limits(), {}};
  const LinkLimits limits(scene);
  EXPECT_TRUE(limits.intervals({0, 1, 0}, 0).has_value());  // upper edge of the one cell
  EXPECT_FALSE(limits.intervals({1, 0, 0}, 0).has_value()); // beyond it
  EXPECT_FALSE(limits.intervals({0, 2, 0}, 0).has_value());
}

TEST(LinkLimitsAnalytic, LinkBetweenTwoMaterialsObeysBoth) {
  Scene scene = test::box_scene(2, {1, 2, 1}, {1, 1, 1});
  Material stiff = scene.materials[0], soft = scene.materials[0];
  NeighbourLimits tight, loose;
  tight.stretch = {1.1, 1.1, 1.1};
  tight.compress = {0.5, 0.5, 0.5};
  loose.stretch = {1.5, 1.5, 1.5};
  loose.compress = {0.9, 0.9, 0.9};
  stiff.limits = tight;
  soft.limits = loose;
  scene.materials = {stiff, soft};
  scene.specimen.material_id = {0, 1};
  scene.limits.from = LimitSource::material;
  const auto between = LinkLimits(scene).intervals({0, 1, 0}, 0).value();
  EXPECT_NEAR(between.high[0], 0.1, 1e-15); // of the first
  EXPECT_NEAR(between.low[0], -0.1, 1e-15); // of the second
}

// Truth: 1 / 1.25^2 = 0.64, 1.25 - 1 / 1.25 = 0.45; turned by a quarter, axes change places.
TEST(LinkLimitsAnalytic, LimitsOfFailureAreThoseOfTheMatterAlongItsFibres) {
  Scene scene = test::box_scene(2, {1, 1, 1}, {1, 1, 1});
  scene.materials[0].damage.emplace();
  scene.materials[0].damage->stretch = {1.25, 2, 2};
  scene.limits.from = LimitSource::failure;
  for (const bool is_turned : {false, true}) {
    scene.specimen.fibre = is_turned ? Vec3{0, 1, 0} : Vec3{1, 0, 0};
    const LinkLimits limits(scene);
    const int along = is_turned ? 1 : 0, across = 1 - along;
    const auto fibre = limits.intervals({0, 0, 0}, along).value(),
               other = limits.intervals({0, 0, 0}, across).value();
    EXPECT_NEAR(fibre.high[static_cast<std::size_t>(along)], 0.25, 1e-14);
    EXPECT_NEAR(fibre.low[static_cast<std::size_t>(along)], 0.25 - 1,
                1e-14); // 1 / 2^2: by what it bears across
    EXPECT_NEAR(fibre.high[static_cast<std::size_t>(across)], 0.45, 1e-14);
    EXPECT_NEAR(other.high[static_cast<std::size_t>(across)], 1, 1e-14);
    EXPECT_NEAR(other.low[static_cast<std::size_t>(across)], 0.64 - 1, 1e-14);
    EXPECT_NEAR(other.high[static_cast<std::size_t>(along)], 0.45, 1e-14);
  }
}

TEST(LinkLimitsAnalytic, TautScaleIsTheStressOfTheBar) {
  // A bar of two materials in series: stress = displacement / sum(h / E).
  Scene scene = test::box_scene(1, {4, 1, 1}, {0.5, 1, 1});
  Material stiff = scene.materials[0];
  stiff.elasticity = ElasticConstants::isotropic(40e3, 0.3);
  scene.materials.push_back(stiff);
  scene.specimen.material_id = {0, 0, 1, 1};
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0.1, 0, 0});
  const double stress = 0.1 / (2 * 0.5 / 10e3 + 2 * 0.5 / 40e3);
  const LinkLimits limits(scene);
  EXPECT_NEAR(limits.taut_scale(), stress, 1e-12 * stress);
  EXPECT_NEAR(limits.intervals({0, 0, 0}, 0)->high[0], 0.5 * stress / 10e3, 1e-15);
  EXPECT_NEAR(limits.intervals({3, 0, 0}, 0)->high[0], 0.5 * stress / 40e3, 1e-15);
}

TEST(LinkLimitsAnalytic, StepsOfASeriesKeepTheLimitsOfTheWhole) {
  Scene scene = test::box_scene(1, {4, 1, 1});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-3, 0, 0});
  scene.limits.from = LimitSource::taut;
  const Scene half = scaled(scene, 0.5);
  EXPECT_DOUBLE_EQ(half.prescribed.back().value, 0.5e-3);
  EXPECT_EQ(LinkLimits(half).taut_scale(), LinkLimits(scene).taut_scale());
}

TEST(LinkLimitsAnalytic, ViolationIsCountedInRestLengths) {
  Scene scene = test::box_scene(1, {2, 1, 1}, {2, 1, 1});
  scene.limits = {LimitSource::given, given_limits(), {}};
  const LinkLimits limits(scene);
  Displacement u(scene.specimen.grid);
  u(0, 2) = 2 * 0.3 + 2 * 0.25; // the second link may stretch by 0.6
  EXPECT_NEAR(largest_violation(scene, limits, u), 0.25, 1e-15);
  u(0, 2) = 0.6;
  EXPECT_NEAR(largest_violation(scene, limits, u), 0, 1e-15);
}

} // namespace
} // namespace maille
