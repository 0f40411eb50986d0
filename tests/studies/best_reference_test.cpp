// The finest reference and what it says of itself.
#include "compare/comparison.hpp"
#include "compare/methods.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

Scene poked(int cells) {
  return parse_scene(
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [" + std::to_string(cells) + ", " +
          std::to_string(cells) + "]\nspacing = " + std::to_string(0.016 / cells) +
          "\nmaterial = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n[[hold]]\nwhere = \"y-\"\n"
          "[[move]]\nwhere = { box = [[0.006, 0.016], [0.010, 0.016]] }\nby = [0, \"-1 mm\"]\n",
      "poked.toml");
}

// Reference: quadratic elements on a mesh four times finer than the one that is judged. The estimate must
// cover the error, and not by more than the ratio of two meshes allows.
TEST(BestReferenceReference, ItsEstimateCoversItsError) {
  const Scene scene = poked(8);
  Methods methods;
  const auto coarse_only = [&] { return methods.answer(scene, "fem_q2"); };
  const BestReference best = best_reference(scene, 1000, {}, methods);
  ASSERT_EQ(best.answer.status, Status::done) << best.answer.message;
  EXPECT_EQ(best.answer.method, "best");
  EXPECT_EQ(best.answer.algorithm.substr(0, 34), "fem_q2 on cells halved three times");
  EXPECT_EQ(best.coarser, "fem_q2 on cells halved twice");
  ASSERT_TRUE(best.estimated_error);
  const Scene finer = refined(refined(refined(refined(scene))));
  Displacement truth = methods.answer(finer, "fem_q2").displacement;
  std::vector<Scene> lattices{scene};
  for (int i = 0; i < 4; ++i)
    lattices.push_back(refined(lattices.back()));
  for (int i = 3; i >= 0; --i)
    truth = at_coarse_nodes(lattices[std::size_t(i)], lattices[std::size_t(i) + 1], truth);
  const double error = compare(scene, best.answer.displacement, truth).relative_l2;
  EXPECT_LE(error, best.estimated_error->relative_l2);
  EXPECT_GE(error, best.estimated_error->relative_l2 / 20);
  EXPECT_LT(error, 0.2 * compare(scene, coarse_only().displacement, truth).relative_l2);
}

TEST(BestReferenceContract, WhatCannotBeAffordedIsNotTried) {
  Methods methods;
  const BestReference best = best_reference(poked(8), 1e-9, {}, methods);
  EXPECT_EQ(best.answer.algorithm.substr(0, 8), "fem_q1: ");
  EXPECT_FALSE(best.estimated_error);
  EXPECT_FALSE(best.answer.reaction.empty());
}

TEST(BestReferenceContract, TheComparisonSaysHowGoodItsReferenceIs) {
  const Scene scene = poked(8);
  const Comparison comparison = compare_methods(scene, {"limits", "fem_q1"}, "best", {});
  ASSERT_EQ(comparison.rows.size(), 3u);
  EXPECT_EQ(comparison.rows.back().answer.method, "best");
  EXPECT_FALSE(comparison.rows.back().error);
  EXPECT_TRUE(comparison.rows[1].error);
  EXPECT_FALSE(comparison.any_failed());
  const auto out = json(scene, comparison);
  EXPECT_EQ(out["reference"], "best");
  EXPECT_GT(out["reference_error"]["relative_l2"].get<double>(), 0);
  EXPECT_LT(out["reference_error"]["relative_l2"].get<double>(), 0.02);
  EXPECT_TRUE(test::has(table(scene, comparison), "best      itself some "));
}

} // namespace
} // namespace maille::studies
