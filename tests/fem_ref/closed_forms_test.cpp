// Bars and beams whose displacement is known.
#include "fem_ref/bodies.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace maille {
namespace {

using test::options_of;

constexpr double E = 10e3, L = 0.02, h = 1e-3;

/// A bar along x of 20 cells, one cell thick, held at x = 0, without contraction.
Scene bar(int dimension) {
  Scene scene = test::box_scene(dimension, {20, 1, 1}, {h, h, h});
  scene.materials[0] = test::material_of(ElasticConstants::isotropic(E, 0));
  test::hold_face(scene, 0, false);
  return scene;
}

template<class Field>
void expect_along_the_bar(const Scene& scene, const Field& along) {
  for (const int degree : {1, 2}) {
    SCOPED_TRACE(fmt::format("{}D Q{}", scene.dimension(), degree));
    const fem_ref::Result result = fem_ref::solve(scene, options_of(degree));
    ASSERT_EQ(result.answer.status, Status::done) << result.answer.message;
    const auto exact = [&](const Vec3& x) -> Vec3 { return {along(x[0]), 0, 0}; };
    EXPECT_LT(test::largest_error(scene, result.answer.displacement, exact), 1e-10 * std::abs(along(L)));
  }
}

// Truth: u = t x / E for a traction t on the end.
TEST(BarAnalytic, EndLoad) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    Scene scene = bar(dimension);
    test::pull_face(scene, 0, true, {250, 0, 0});
    expect_along_the_bar(scene, [](double x) { return 250 * x / E; });
  }
}

// Truth: u = rho g (2 L x - x^2) / (2 E); linear elements are exact at the nodes here too, as in every 1D
// problem with constant coefficients.
TEST(BarAnalytic, OwnWeight) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    Scene scene = bar(dimension);
    scene.materials[0].density = 1060;
    scene.gravity = {9.81, 0, 0};
    expect_along_the_bar(scene, [](double x) { return 1060 * 9.81 * (2 * L * x - x * x) / (2 * E); });
  }
}

// Truth: one force runs through both parts: u = t x / E_1, then t L_1 / E_1 + t (x - L_1) / E_2.
TEST(BarAnalytic, TwoMaterialsInSeries) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    Scene scene = bar(dimension);
    scene.materials.push_back(test::material_of(ElasticConstants::isotropic(5 * E, 0)));
    scene.specimen.material_id.assign(20, 0);
    std::fill(scene.specimen.material_id.begin() + 8, scene.specimen.material_id.end(), std::uint8_t{1});
    test::pull_face(scene, 0, true, {250, 0, 0});
    expect_along_the_bar(scene, [](double x) {
      const double first = std::min(x, 8 * h), second = std::max(0.0, x - 8 * h);
      return 250 * (first / E + second / (5 * E));
    });
  }
}

// Truth: for degree 2 the mid point of a cell whose ends are both prescribed lies half way, though its own
// weight would pull it down: the documented rule, seen through the L2 norm.
TEST(BarAnalytic, MidPointsBetweenPrescribedNodesAreInterpolated) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    Scene scene = test::box_scene(dimension, {1, 1, 1});
    scene.gravity = {9.81, 0, 0};
    test::hold_face(scene, 0, false);
    test::move_face(scene, 0, true, {1e-4, 0, 0});
    fem_ref::Options options = options_of(2);
    options.exact = [](const Vec3& x) -> Vec3 { return {0.1 * x[0], 0, 0}; };
    const fem_ref::Result result = fem_ref::solve(scene, options);
    ASSERT_EQ(result.answer.status, Status::done) << result.answer.message;
    EXPECT_LT(*result.l2_error, 1e-16);
  }
}

// Truth: Hooke's law with the third strain or the third stress zero.
TEST(PlaneAnalytic, StrainAndStressDiffer) {
  const double nu = 0.3, t = 200;
  for (const PlaneAssumption plane : {PlaneAssumption::strain, PlaneAssumption::stress}) {
    Scene scene = test::box_scene(2, {6, 4, 1}, {h, h, h});
    scene.plane = plane;
    test::prescribe_face(scene, 0, false, 0, 0, true);
    test::prescribe_face(scene, 1, false, 1, 0, true);
    test::pull_face(scene, 0, true, {t, 0, 0});
    const bool strain = plane == PlaneAssumption::strain;
    const double along = strain ? t * (1 - nu * nu) / E : t / E;
    const double across = strain ? -t * nu * (1 + nu) / E : -nu * t / E;
    const auto exact = [&](const Vec3& x) -> Vec3 { return {along * x[0], across * x[1], 0}; };
    for (const int degree : {1, 2}) {
      const fem_ref::Result result = fem_ref::solve(scene, options_of(degree));
      EXPECT_LT(test::largest_error(scene, result.answer.displacement, exact), 1e-10 * along * 6 * h);
    }
  }
}

// Truth: MacNeal and Harder 1985, straight beam, unit in-plane load at the tip: P L^3 / 3 E I + 6 P L / 5 G
// A = 0.1081. Beam theory leaves out what the clamp does over a length of one depth, (depth / L)^2 = 0.1 % of
// the deflection, and quadratic elements one third of the depth long are off by about as much: 0.3 % in all.
TEST(BeamAnalytic, SlenderCantileverBendsAsBeamTheorySays) {
  const double length = 6, depth = 0.2, width = 0.1, modulus = 1e7, nu = 0.3;
  Scene scene = test::box_scene(3, {45, 2, 1}, {length / 45, depth / 2, width});
  scene.materials[0] = test::material_of(ElasticConstants::isotropic(modulus, nu));
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {0, 1 / (depth * width), 0});
  const fem_ref::Result result = fem_ref::solve(scene, options_of(2));
  ASSERT_EQ(result.answer.status, Status::done) << result.answer.message;
  const double tip = result.answer.displacement(1, scene.specimen.grid.node({45, 1, 0}));
  EXPECT_NEAR(tip, 0.1081, 0.003 * 0.1081);
}

} // namespace
} // namespace maille
