// A displacement that is known everywhere: the error falls with the order of the element. More in
// studies/src/verify/orders.cpp.
#include "fem_ref/bodies.hpp"

#include <gtest/gtest.h>

namespace maille {
namespace {

using test::options_of;

// Truth: the cantilever of Timoshenko and Goodier 1951, article 21 (plane stress, end load P on depth D),
// which solves the equations without body force; origin in the middle of the fixed end.
TEST(ManufacturedAnalytic, PlaneStressCantileverConverges) {
  const double E = 10e3, nu = 0.3, P = 2.0, L = 4.0, D = 1.0, I = D * D * D / 12;
  const auto exact = [=](const Vec3& x) -> Vec3 {
    const double y = x[1];
    return {
        P * y / (6 * E * I) * ((6 * L - 3 * x[0]) * x[0] + (2 + nu) * (y * y - D * D / 4)),
        -P / (6 * E * I) *
            (3 * nu * y * y * (L - x[0]) + (4 + 5 * nu) * D * D * x[0] / 4 + (3 * L - x[0]) * x[0] * x[0]),
        0};
  };
  for (const int degree : {1, 2}) {
    std::vector<double> errors;
    for (const int cells : {4, 8}) {
      const double h = D / cells;
      Scene scene = test::box_scene(2, {4 * cells, cells, 1}, {h, h, h});
      scene.specimen.origin = {0, -D / 2, 0};
      scene.plane = PlaneAssumption::stress;
      fem_ref::Options options = options_of(degree);
      options.boundary_displacement = exact;
      options.exact = exact;
      errors.push_back(fem_ref::solve(scene, options).l2_error.value());
    }
    EXPECT_NEAR(std::log2(errors[0] / errors[1]), degree + 1, 0.15);
  }
}

} // namespace
} // namespace maille
