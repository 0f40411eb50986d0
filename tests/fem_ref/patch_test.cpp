// Constant strain must come out to round-off, whatever the matter and the shape (Irons 1972).
#include "fem_ref/bodies.hpp"

#include <Eigen/LU>
#include <fmt/format.h>
#include <gtest/gtest.h>

namespace maille {
namespace {

using test::options_of;

struct Matter {
  const char* name;
  ElasticConstants constants;
  bool slanted;
};

std::vector<Matter> matters() {
  return {{"isotropic", ElasticConstants::isotropic(10e3, 0.3), false},
          {"orthotropic", test::orthotropic(), false},
          {"turned transversely isotropic", test::fibrous(), true}};
}

Scene body(int dimension, const Matter& matter, bool carved) {
  const Index3 cells = dimension == 1 ? Index3{9, 1, 1} : dimension == 2 ? Index3{7, 6, 1} : Index3{6, 5, 5};
  Scene scene = test::box_scene(dimension, cells, {2e-3, 1e-3, 1.5e-3});
  scene.specimen.origin = {0.01, -0.02, 0.03};
  scene.materials[0] = test::material_of(matter.constants);
  if (matter.slanted)
    scene.specimen.fibre = test::slanted_fibre(dimension);
  if (carved)
    test::carve(scene, 5, 0.15);
  return scene;
}

Vec3 affine(const Vec3& x) {
  return {1e-4 + 0.02 * x[0] - 0.03 * x[1] + 0.01 * x[2], 2e-4 + 0.04 * x[0] + 0.01 * x[1] - 0.02 * x[2],
          -0.01 * x[0] + 0.03 * x[1] - 0.015 * x[2]};
}

TEST(PatchTestAnalytic, LinearDisplacementOnTheBoundaryFillsTheBody) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (const Matter& matter : matters())
      for (const bool carved : {false, true})
        for (const int degree : {1, 2}) {
          SCOPED_TRACE(
              fmt::format("{}D {} {} Q{}", dimension, matter.name, carved ? "carved" : "box", degree));
          const Scene scene = body(dimension, matter, carved);
          fem_ref::Options options = options_of(degree);
          options.boundary_displacement = affine;
          options.exact = affine;
          const fem_ref::Result result = fem_ref::solve(scene, options);
          ASSERT_EQ(result.answer.status, Status::done) << result.answer.message;
          // Truth: a linear displacement has constant stress and solves the equations without load.
          const double size = test::largest(result.answer.displacement);
          EXPECT_LT(test::largest_error(scene, result.answer.displacement, affine), 1e-10 * size);
          EXPECT_LT(*result.l2_error, 1e-10 * size);
        }
}

TEST(PatchTestAnalytic, FibresGivenPerCellActAsTheOneTheyEqual) {
  for (int dimension = 2; dimension <= 3; ++dimension) {
    Scene scene = body(dimension, matters()[2], false);
    const Vec3 f = scene.specimen.fibre;
    scene.specimen.fibres.assign(
        static_cast<std::size_t>(scene.specimen.grid.n_cells()),
        {static_cast<float>(f[0]), static_cast<float>(f[1]), static_cast<float>(f[2])});
    fem_ref::Options options = options_of(1);
    options.boundary_displacement = affine;
    const fem_ref::Result result = fem_ref::solve(scene, options);
    EXPECT_LT(test::largest_error(scene, result.answer.displacement, affine),
              1e-10 * test::largest(result.answer.displacement));
  }
}

/// Prescribes the component of one node to be zero.
void pin(Scene& scene, const Index3& node, int component) {
  scene.prescribed.push_back({scene.specimen.grid.node(node), component, 0, true});
}

// Uniform tractions on all six faces, just six components held: the stress is that of the tractions
// everywhere, the strain is S sigma, and the displacement is the linear one that the supports allow.
TEST(PatchTestAnalytic, UniformTractionsGiveTheStrainOfTheCompliance) {
  Eigen::Matrix<double, 6, 1> stress; // 11 22 33 23 13 12
  stress << 100, -50, 30, 20, -40, 60;
  const int full[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
  for (const Matter& matter : matters())
    for (const int degree : {1, 2}) {
      SCOPED_TRACE(fmt::format("{} Q{}", matter.name, degree));
      Scene scene = test::box_scene(3, {4, 3, 3}, {2e-3, 1e-3, 1.5e-3});
      scene.materials[0] = test::material_of(matter.constants);
      if (matter.slanted)
        scene.specimen.fibre = test::slanted_fibre(3);
      for (int axis = 0; axis < 3; ++axis)
        for (const bool upper : {false, true}) {
          Vec3 traction{};
          for (int c = 0; c < 3; ++c)
            traction[static_cast<std::size_t>(c)] = (upper ? 1 : -1) * stress[full[c][axis]];
          test::pull_face(scene, axis, upper, traction);
        }
      for (int c = 0; c < 3; ++c)
        pin(scene, {0, 0, 0}, c);
      pin(scene, {4, 0, 0}, 1); // no turn about z
      pin(scene, {4, 0, 0}, 2); // nor about y
      pin(scene, {0, 3, 0}, 2); // nor about x
      const fem_ref::Result result = fem_ref::solve(scene, options_of(degree));
      ASSERT_EQ(result.answer.status, Status::done) << result.answer.message;

      const Eigen::Matrix<double, 6, 1> e = scene.object_stiffness(0).inverse() * stress;
      const auto exact = [&](const Vec3& x) -> Vec3 {
        return {e[0] * x[0] + e[5] * x[1] + e[4] * x[2], e[1] * x[1] + e[3] * x[2], e[2] * x[2]};
      };
      const double size = test::largest(result.answer.displacement);
      EXPECT_LT(test::largest_error(scene, result.answer.displacement, exact), 1e-10 * size);
    }
}

} // namespace
} // namespace maille
