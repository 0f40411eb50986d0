// The fit of limits and weights, against families whose best numbers are known.
#include "fit/fit.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille::studies {
namespace {

const std::string tissue = "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n";

Scene bar(double pull) {
  return parse_scene("units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [8]\nspacing = 0.001\n" +
                     tissue + "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [" +
                     std::to_string(pull) + "]\n");
}

/// A sheet that is held at its lower edge and has a spot in its middle moved.
Scene sheet(double along, double across, const std::string& constants = tissue) {
  return parse_scene(
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [9, 7]\nspacing = 0.001\n" + constants +
      "[[hold]]\nwhere = \"y-\"\n[[move]]\nwhere = { box = [[0.004, 0.003], [0.005, 0.004]] }\nby = [" +
      std::to_string(along) + ", " + std::to_string(across) + "]\n");
}

FitCase answered(Scene scene, const std::vector<Material>& materials, std::string_view method) {
  Scene asked = scene;
  asked.materials = materials;
  asked.limits.from = LimitSource::material;
  Displacement reference = deform::solve(asked, method).displacement;
  return {std::move(scene), std::move(reference)};
}

double value_of(const Fit& fit, const std::string& name, const std::string& material = "specimen.material") {
  for (const FittedNumber& number : fit.numbers)
    if (number.name == name && number.material == material)
      return number.value;
  ADD_FAILURE() << "no number " << name;
  return 0;
}

// Oracle: data that limits made themselves. Every number decides some node, so all of them must come back.
TEST(FitOracle, FindsTheLimitsThatMadeTheData) {
  Material known = sheet(1e-3, 1e-3).materials[0];
  known.limits = NeighbourLimits{{1.3, 1.25, 1}, {0.8, 0.7, 1}, {{{0, 0.22, 0}, {0.18, 0, 0}, {}}}};
  const std::vector<FitCase> cases{answered(sheet(5e-4, 3e-4), {known}, "limits"),
                                   answered(sheet(3e-4, 5e-4), {known}, "limits")};
  const Fit found = fit(cases, {});
  EXPECT_EQ(found.status, Status::done);
  EXPECT_LT(mean_error(found.fitted), 1e-5);
  const double tolerance = 1e-4; // of slacks of 0.18 to 0.3; the search stops at 1e-8 of their logarithms
  EXPECT_NEAR(value_of(found, "stretch[x]"), 1.3, tolerance);
  EXPECT_NEAR(value_of(found, "stretch[y]"), 1.25, tolerance);
  EXPECT_NEAR(value_of(found, "compress[x]"), 0.8, tolerance);
  EXPECT_NEAR(value_of(found, "compress[y]"), 0.7, tolerance);
  EXPECT_NEAR(value_of(found, "shear[x][y]"), 0.22, tolerance);
  EXPECT_NEAR(value_of(found, "shear[y][x]"), 0.18, tolerance);
  for (const FittedNumber& number : found.numbers)
    EXPECT_TRUE(number.is_determined) << number.name;
}

/// The sheet, of another matter from the spot on.
Scene sheet_of_two(double along, double across) {
  Scene scene = sheet(along, across);
  scene.materials[0].name = "near";
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].name = "far";
  scene.materials[1].elasticity = ElasticConstants::isotropic(30e3, 0.3);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    scene.specimen.material_id.push_back(grid.cell_at(cell)[0] < 4 ? 0 : 1);
  return scene;
}

// Oracle: the same of two materials at once; and a scene that the fit has not seen is met as well.
TEST(FitOracle, FindsTheLimitsOfTwoMaterialsThatMadeTheData) {
  std::vector<Material> known = sheet_of_two(0, 1e-4).materials;
  known[0].limits = NeighbourLimits{{1.3, 1.25, 1}, {0.8, 0.7, 1}, {{{0, 0.22, 0}, {0.18, 0, 0}, {}}}};
  known[1].limits = NeighbourLimits{{1.12, 1.1, 1}, {0.91, 0.88, 1}, {{{0, 0.09, 0}, {0.08, 0, 0}, {}}}};
  const std::vector<FitCase> cases{answered(sheet_of_two(2.2e-4, 1.6e-4), known, "limits"),
                                   answered(sheet_of_two(-1.6e-4, -2.2e-4), known, "limits")};
  const Fit found = fit(cases, {});
  EXPECT_EQ(found.status, Status::done);
  ASSERT_EQ(found.materials.size(), 2u);
  EXPECT_EQ(found.materials[1].name, "far");
  EXPECT_LT(mean_error(found.fitted), 1e-4);
  EXPECT_LT(fit_error(answered(sheet_of_two(2e-4, -1.8e-4), known, "limits"), found.materials, "limits")
                .relative_l2,
            1e-3);
  const double tolerance = 2e-3; // of slacks of 0.08 to 0.3
  EXPECT_NEAR(value_of(found, "stretch[y]", "far"), 1.1, tolerance);
  EXPECT_NEAR(value_of(found, "shear[y][x]", "far"), 0.08, tolerance);
}

TEST(FitOracle, FindsTheWeightsOfTwoMaterialsThatMadeTheData) {
  std::vector<Material> known = sheet_of_two(0, 1e-4).materials;
  for (Material& material : known)
    material.limits = NeighbourLimits{{2, 2, 2}, {0, 0, 0}, {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}}};
  known[0].relaxed_weights = {0.4, 2.5, 1};
  known[1].relaxed_weights = {3, 0.6, 1};
  const std::vector<FitCase> cases{answered(sheet_of_two(5e-4, 3e-4), known, "relaxed"),
                                   answered(sheet_of_two(-3e-4, 5e-4), known, "relaxed")};
  const Fit found = fit(cases, {"relaxed"});
  EXPECT_LT(mean_error(found.fitted), 1e-4); // relaxed itself ends at 1e-4
  for (std::size_t m = 0; m < 2; ++m)
    for (std::size_t b = 0; b < 2; ++b)
      EXPECT_NEAR(found.materials[m].relaxed_weights[b], known[m].relaxed_weights[b],
                  2e-2 * known[m].relaxed_weights[b])
          << m << " " << b;
}

TEST(FitContract, AMaterialThatNothingWasFittedForIsRefused) {
  const FitCase one{sheet_of_two(0, 1e-4), Displacement(sheet_of_two(0, 1e-4).specimen.grid)};
  EXPECT_THROW(fit_error(one, std::vector<Material>{one.scene.materials[0]}, "limits"), std::runtime_error);
  FitCase other = one;
  other.scene.materials[0].elasticity = ElasticConstants::isotropic(1e3, 0.3);
  EXPECT_THROW(materials_of(std::vector<FitCase>{one, other}), std::runtime_error);
}

TEST(FitOracle, FindsTheWeightsThatMadeTheData) {
  Material known = sheet(1e-3, 1e-3).materials[0];
  known.limits = NeighbourLimits{{2, 2, 2}, {0, 0, 0}, {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}}};
  known.relaxed_weights = {0.4, 2.5, 1};
  const Fit found = fit(std::vector<FitCase>{answered(sheet(5e-4, 3e-4), {known}, "relaxed")}, {"relaxed"});
  EXPECT_LT(mean_error(found.fitted), 1e-4); // relaxed itself ends at 1e-4
  EXPECT_NEAR(found.materials[0].relaxed_weights[0], 0.4, 0.4e-2);
  EXPECT_NEAR(found.materials[0].relaxed_weights[1], 2.5, 2.5e-2);
}

// Analytic: a bar whose links all stretch alike, moved by A and by A/2. A link must give A/n, or the larger
// move is cut back; a larger limit leaves more nodes behind. In the smaller move the half next to the handle
// then follows, at full slack.
TEST(FitAnalytic, ABarPulledTwiceIsTautAtTheLargerPull) {
  constexpr double A = 8e-4;
  constexpr int n = 8;
  std::vector<FitCase> cases;
  double expected = 0;
  for (const double pull : {A, A / 2}) {
    FitCase one{bar(pull), Displacement(bar(pull).specimen.grid)};
    double lost = 0, whole = 0;
    for (int i = 0; i <= n; ++i) {
      const double r = pull * i / n, u = std::max(0.0, pull - A / n * (n - i));
      one.reference(0, i) = r;
      if (i != 0 && i != n) {
        lost += (u - r) * (u - r);
        whole += r * r;
      }
    }
    expected += lost / whole / 2;
    cases.push_back(std::move(one));
  }
  const Fit found = fit(cases, {});
  ASSERT_EQ(found.status, Status::done);
  EXPECT_NEAR(value_of(found, "stretch[x]"), 1 + A / n / 1e-3, 1e-6);
  EXPECT_FALSE(found.numbers[1].is_determined) << "nothing is compressed";
  EXPECT_EQ(value_of(found, "compress[x]"), 0) << "open: it must not bind where another scene compresses";
  EXPECT_NEAR(mean_error(found.fitted), std::sqrt(expected), 1e-4);
  EXPECT_EQ(found.fitted[0].cut, 0);
  ASSERT_EQ(found.alone.size(), 2u);
  EXPECT_LT(found.alone[1], 1e-5) << "alone, it is the taut bar";
}

// Analytic: a strip that narrows as it is pulled. What it narrows by is what limits cannot do.
TEST(FitAnalytic, WhatNothingMovesIsOutOfReach) {
  const Scene scene = parse_scene(
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [4, 2]\nspacing = 0.001\n" + tissue +
      "[[hold]]\nwhere = \"x-\"\naxes = \"x\"\n[[move]]\nwhere = \"x+\"\naxes = \"x\"\n"
      "by = [4e-4, 0]\n");
  FitCase one{scene, Displacement(scene.specimen.grid)};
  double narrowed = 0, whole = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Index3 at = scene.specimen.grid.node_at(node);
    one.reference(0, node) = 1e-4 * at[0];
    one.reference(1, node) = -3e-5 * (at[1] - 1);
    if (at[0] == 0 || at[0] == 4)
      continue;
    narrowed += std::pow(one.reference(1, node), 2);
    whole += std::pow(one.reference(1, node), 2) + std::pow(one.reference(0, node), 2);
  }
  const Vec3 lost = unreachable(one);
  EXPECT_EQ(lost[0], 0);
  EXPECT_NEAR(lost[1], std::sqrt(narrowed / whole), 1e-12);
  const Fit found = fit(std::vector<FitCase>{one}, {});
  EXPECT_NEAR(found.fitted[0].relative_l2, lost[1], 1e-5) << "and what is in reach is reached";
}

TEST(FitContract, TheSameInputGivesTheSameNumbersToTheBit) {
  Material known = sheet(1e-3, 1e-3).materials[0];
  known.limits = NeighbourLimits{{1.3, 1.25, 1}, {0.8, 0.7, 1}, {{{0, 0.22, 0}, {0.18, 0, 0}, {}}}};
  const std::vector<FitCase> cases{answered(sheet(5e-4, 3e-4), {known}, "limits")};
  EXPECT_EQ(fit(cases, {}).materials[0].limits, fit(cases, {}).materials[0].limits);
}

TEST(FitContract, EndsWithTheBestSoFarWhenItIsAskedTo) {
  Material known = sheet(1e-3, 1e-3).materials[0];
  known.limits = NeighbourLimits{{1.3, 1.25, 1}, {0.8, 0.7, 1}, {{{0, 0.22, 0}, {0.18, 0, 0}, {}}}};
  const std::vector<FitCase> cases{answered(sheet(5e-4, 3e-4), {known}, "limits")};
  Control control;
  int polled = 0;
  control.stop_requested = [&] { return ++polled > 300; };
  const Fit found = fit(cases, {}, control);
  EXPECT_EQ(found.status, Status::interrupted);
  EXPECT_EQ(found.fitted.size(), 1u);
  EXPECT_EQ(found.fitted[0].cut, 0);
  EXPECT_EQ(fit(cases, {"limits", 20}).status, Status::budget_reached);
}

TEST(FitContract, ScenesThatMoveNothingAreRefused) {
  const FitCase one{bar(0), Displacement(bar(0).specimen.grid)};
  EXPECT_THROW(fit(std::vector<FitCase>{one}, {}), std::runtime_error);
}

} // namespace
} // namespace maille::studies
