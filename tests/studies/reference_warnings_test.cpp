/// Whether a comparison says so where the reference that it trusts is the one that is off. The truth is a
/// finer mesh.

#include "compare/comparison.hpp"
#include "compare/methods.hpp"

#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

namespace maille::studies {
namespace {

/// A beam held at one end, its other moved along an axis.
Scene beam(double nu, int axis, const Index3& cells = {10, 4, 4}) {
  Scene scene = test::box_scene(3, cells);
  scene.materials.front().elasticity = ElasticConstants::isotropic(10e3, nu);
  scene.limits.from = LimitSource::taut;
  test::hold_face(scene, 0, false);
  for (int component = 0; component < 3; ++component)
    test::prescribe_face(scene, 0, true, component, component == axis ? 5e-4 : 0, false);
  return scene;
}

std::vector<std::string> warnings_of(const Scene& scene, const std::vector<std::string>& methods,
                                     const std::string& reference) {
  return reference_warnings(scene, compare_methods(scene, methods, reference, {}), {});
}

TEST(ReferenceWarningsReference, ALockingReferenceIsNamedWithARangeThatHoldsTheTruth) {
  const Scene scene = beam(0.499, 2);
  const Comparison comparison = compare_methods(scene, {"coupled"}, "fem_q1", {});
  const auto warnings = reference_warnings(scene, comparison, {});
  ASSERT_EQ(warnings.size(), 1u);
  const std::string& text = warnings.front();
  EXPECT_TRUE(text.starts_with("coupled is ")) << text;
  EXPECT_TRUE(test::has(text, "fem_q1 itself may be off by"));
  double least = 0, most = 0;
  ASSERT_EQ(std::sscanf(text.c_str() + text.find("off by"), "off by %lf %% to %lf %%", &least, &most), 2)
      << text;
  Methods methods;
  const BestReference truth = best_reference(scene, 2, {}, methods);
  ASSERT_TRUE(is_converged(truth.answer.status)) << truth.answer.message;
  const double error =
      100 *
      compare(scene, comparison.reference_row()->answer.displacement, truth.answer.displacement).relative_l2;
  EXPECT_LT(least, error) << text;
  EXPECT_LT(error, most) << text;
}

TEST(ReferenceWarningsReference, AGoodReferenceIsNotBlamed) {
  EXPECT_TRUE(warnings_of(beam(0.3, 0), {"coupled", "relaxed"}, "fem_q2").empty());
  EXPECT_TRUE(warnings_of(beam(0.499, 2), {"coupled"}, "fem_q2").empty());
  EXPECT_TRUE(warnings_of(beam(0.3, 0), {"relaxed"}, "fem_q1").empty());
}

TEST(ReferenceWarningsContract, LockingLinearElementsAreNamed) {
  const auto incompressible = warnings_of(beam(0.49, 2), {"limits"}, "fem_q1");
  ASSERT_EQ(incompressible.size(), 1u);
  EXPECT_TRUE(test::has(incompressible.front(), "Poisson ratio of 0.49"));
  const auto thin = warnings_of(beam(0.3, 2, {12, 12, 2}), {"limits"}, "fem_q1");
  ASSERT_EQ(thin.size(), 1u);
  EXPECT_TRUE(test::has(thin.front(), "2 cells across"));
  EXPECT_TRUE(warnings_of(beam(0.49, 2), {"limits"}, "fem_q2").empty());
}

} // namespace
} // namespace maille::studies
