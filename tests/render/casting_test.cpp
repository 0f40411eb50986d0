// What single objects look like, against formulas and against the plain caster.

#include "shapes.hpp"
#include "support/vector_targets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace maille::render::test {
namespace {

double alpha_in_the_middle(const SceneObject& object, const View& view) {
  Renderer renderer;
  const Picture& picture = renderer.render(std::span(&object, 1), view);
  return picture.rgba[picture.pixel(view.width / 2, view.height / 2)][3];
}

TEST(SlabAnalytic, OpacityIsThatOfItsThicknessAtAnyStep) {
  Look look;
  look.colours = {{0, {1, 0.5f, 0.25f}}};
  look.shading.on = false;
  for (const double opacity : {0.002, 0.02, 0.1}) {
    look.opacity = {{0, opacity}};
    const SceneObject slab = cube(
        33, [](const Vec3&) { return 1.0; }, look); // 32 mm between outermost centres
    View view = view_from({0, 0, 0.1}, 3);
    view.camera.view_up = {0, 1, 0};
    view.camera.parallel = true;
    view.camera.parallel_scale = 1e-3;
    for (const double samples : {1.0, 2.0, 4.0}) {
      view.samples_per_voxel = samples;
      EXPECT_NEAR(alpha_in_the_middle(slab, view), 1 - std::pow(1 - opacity, 32), 1.0 / 255) << samples;
    }
  }
}

TEST(SlabAnalytic, ATurnedSlabIsAsOpaqueAsItsPathIsLong) {
  Look look;
  look.colours = {{0, {1, 1, 1}}};
  look.opacity = {{0, 0.02}};
  look.shading.on = false;
  SceneObject slab = cube(
      33, [](const Vec3&) { return 1.0; }, look);
  slab.pose = turned({}, 0.4);
  View view = view_from({0, 0, 0.1}, 3, 8);
  view.camera.view_up = {0, 1, 0};
  EXPECT_NEAR(alpha_in_the_middle(slab, view), 1 - std::pow(0.98, 32 / std::cos(0.4)), 1.0 / 255);
}

class OneObjectOracle : public testing::TestWithParam<LookMode> {
protected:
  SceneObject object() const {
    Look look = half_clear({0.9f, 0.4f, 0.2f}, 0.5);
    look.mode = GetParam();
    look.isovalue = 0.55;
    if (look.mode == LookMode::isosurface)
      look.opacity = {{0, 1}};
    if (look.mode == LookMode::maximum) // of one point alone: among equals a ray may choose
      return cube(
          28, [](const Vec3& x) { return 1 - 60 * std::hypot(x[0] - 1e-3, x[1], 0.7 * x[2]); }, look);
    return cube(28, ring(8e-3, 3e-3), look);
  }
};

TEST_P(OneObjectOracle, RigidInPerspectiveAndInParallel) {
  SceneObject of = object();
  of.pose = turned({1e-3, -2e-3, 0}, 0.7, 0.3);
  View view = view_from({0.03, 0.05, 0.09}, 40);
  for (const bool parallel : {false, true}) {
    view.camera.parallel = parallel;
    view.camera.parallel_scale = 0.02;
    Renderer renderer;
    EXPECT_LE(difference(renderer.render(std::span(&of, 1), view), {of}, view, 3), 1.0) << parallel;
  }
}

TEST_P(OneObjectOracle, DeformedAsItIs) {
  SceneObject of = object();
  of.deformation = bent(of, 0.8);
  of.pose = turned({1e-3, -2e-3, 0}, 0.7, 0.3);
  const View view = view_from({0.03, 0.05, 0.09}, 40);
  Renderer renderer;
  EXPECT_LE(difference(renderer.render(std::span(&of, 1), view), {of}, view, 5), 1.0);
}

// Half a turn of the ring is cut away; how a cut is lit does not depend on the step.
TEST_P(OneObjectOracle, CutOpen) {
  for (const double samples : {1.0, 2.0, 8.0})
    for (const bool is_deformed : {false, true}) {
      SceneObject of = object();
      if (is_deformed)
        of.deformation = bent(of, 0.8);
      View view = view_from({0.03, 0.05, 0.09}, 40, samples);
      view.clips = {{{0, 0, 0.5e-3}, {0.2, 0, -1}}};
      Renderer renderer;
      EXPECT_LE(difference(renderer.render(std::span(&of, 1), view), {of}, view, 5), 1.0) << samples;
    }
}

TEST_P(OneObjectOracle, ByEachKindOfVector) {
  const View view = view_from({0.03, 0.05, 0.09}, 40);
  for (const std::int64_t target : tests::vector_targets()) {
    const tests::ForcedVectors forced(target);
    for (const bool is_deformed : {false, true}) {
      SceneObject of = object();
      if (is_deformed)
        of.deformation = bent(of, 0.8);
      Renderer renderer;
      EXPECT_LE(difference(renderer.render(std::span(&of, 1), view), {of}, view, 7), 1.0)
          << hwy::TargetName(target);
    }
  }
}

// Single voxels far from each other and a block: rays begin and end anywhere, many see nothing at all.
TEST(ScatteredOracle, NothingIsLostFromAnywhereNotEvenFromWithin) {
  std::mt19937 random(5);
  const auto grain = [&](const Vec3& x) {
    const bool is_block = x[0] > 4e-3 && x[1] > 2e-3 && x[2] < -3e-3;
    return is_block || random() % 97 == 0 ? 1.0 : 0.0;
  };
  Look look = half_clear({0.9f, 0.4f, 0.2f}, 0.7);
  SceneObject of = cube(31, grain, look);
  of.pose = turned({1e-3, -2e-3, 0}, 0.7, 0.3);
  std::uniform_real_distribution<double> anywhere(-0.05, 0.05);
  int n_seen = 0;
  for (int eye = 0; eye < 24; ++eye) {
    View view = view_from({anywhere(random), anywhere(random), anywhere(random)}, 33);
    if (eye % 6 == 0)
      view.camera.position = {2e-3, 1e-3 * eye / 6, -4e-3}; // within
    view.camera.view_angle = 35;
    view.camera.parallel = eye % 4 == 1;
    view.camera.parallel_scale = 0.02;
    if (eye % 5 == 2)
      view.clips = {{{0, 0, 0}, {0.2, 0.3, -1}}};
    Renderer renderer;
    const Picture& picture = renderer.render(std::span(&of, 1), view);
    EXPECT_LE(difference(picture, {of}, view, 2), 1.0) << eye;
    n_seen += static_cast<int>(std::ranges::count_if(picture.rgba, [](const auto& c) { return c[3] > 0; }));
  }
  EXPECT_GT(n_seen, 5000);
}

TEST(CutAnalytic, ItsFaceLooksTheSameAtAnyStep) {
  // Values rise across the cut: away from it matter is lit from the side, on it as if it faced the light.
  SceneObject of = cube(
      33, [](const Vec3& x) { return 0.5 + 20 * x[0]; }, half_clear({0.9f, 0.4f, 0.2f}, 0.6));
  View view = view_from({0, 0, 0.1}, 3);
  view.camera.view_up = {0, 1, 0};
  view.light = {-1, 0, 0.2};
  view.clips = {{{0, 0, 0}, {0, 0, -1}}};
  double first = 0;
  for (const double samples : {1.0, 2.0, 8.0, 16.0}) {
    view.samples_per_voxel = samples;
    Renderer renderer;
    const Picture& picture = renderer.render(std::span(&of, 1), view);
    const double red = picture.rgba[picture.pixel(1, 1)][0];
    first = samples == 1 ? red : first;
    EXPECT_NEAR(red, first, 8.0 / 255) << samples;
  }
}

// A ray that passes a corner is inside for less than a step.
TEST(SilhouetteOracle, WhatIsInsideForLessThanAStepIsSeen) {
  Look look;
  look.mode = LookMode::isosurface;
  look.isovalue = 0.5;
  look.opacity = {{0, 1}};
  look.colours = {{0, {1, 1, 1}}};
  look.shading.on = false;
  const auto box = [](const Vec3& x) {
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}) < 6.2e-3 ? 1.0 : 0.0;
  };
  SceneObject of = cube(20, box, look);
  of.pose = turned({}, 0.7, 0.5);
  const View view = view_from({0.03, 0.05, 0.09}, 60, 1);
  Renderer renderer;
  EXPECT_LE(difference(renderer.render(std::span(&of, 1), view), {of}, view), 1.0);
}

INSTANTIATE_TEST_SUITE_P(Modes, OneObjectOracle,
                         testing::Values(LookMode::composite, LookMode::maximum, LookMode::isosurface));

TEST(UndeformedOracle, ALatticeAtRestShowsWhatARigidObjectShows) {
  SceneObject rigid = cube(28, ring(8e-3, 3e-3), half_clear({0.9f, 0.4f, 0.2f}, 0.5)), at_rest = rigid;
  at_rest.deformation = bent(rigid, 0);
  const View view = view_from({0.03, 0.05, 0.09}, 64);
  Renderer a, b;
  const Picture& one = a.render(std::span(&rigid, 1), view);
  const Picture& other = b.render(std::span(&at_rest, 1), view);
  double largest = 0;
  for (std::size_t p = 0; p < one.rgba.size(); ++p)
    for (std::size_t c = 0; c < 4; ++c)
      largest = std::max(largest, std::abs(static_cast<double>(one.rgba[p][c]) - other.rgba[p][c]));
  EXPECT_LE(255 * largest, 1);
  EXPECT_GT(one.rgba[one.pixel(32, 20)][3] + one.rgba[one.pixel(32, 14)][3], 0); // something is there
}

TEST(ClipPlanesAnalytic, HalfAThicknessIsLeft) {
  Look look;
  look.colours = {{0, {1, 1, 1}}};
  look.opacity = {{0, 0.02}};
  look.shading.on = false;
  SceneObject slab = cube(
      33, [](const Vec3&) { return 1.0; }, look);
  View view = view_from({0, 0, 0.1}, 3, 4);
  view.camera.view_up = {0, 1, 0};
  view.camera.parallel = true;
  view.camera.parallel_scale = 1e-3;
  view.clips = {{{0, 0, 0}, {0, 0, 1}}};
  EXPECT_NEAR(alpha_in_the_middle(slab, view), 1 - std::pow(0.98, 16), 1.0 / 255);
  view.clips.clear();
  slab.crop = CropBox{{-1, -1, -4e-3}, {1, 1, 4e-3}};
  EXPECT_NEAR(alpha_in_the_middle(slab, view), 1 - std::pow(0.98, 8), 1.0 / 255);
}

// A plate whose middle layer of cells is turned inside out: the layers on either side lie over it.
TEST(FoldedAnalytic, WhereACellIsFoldedItsNeighboursAreSeen) {
  Look look;
  look.colours = {{0, {1, 1, 1}}};
  look.opacity = {{0, 0.9}};
  look.shading.on = false;
  SceneObject of = cube(
      28, [](const Vec3&) { return 1.0; }, look);
  auto deformation = bent(of, 0);
  const Index3 n = deformation->lattice().nodes();
  for (std::int64_t node = 0; node < deformation->lattice().n_nodes(); ++node) {
    const std::int64_t k = node / (std::int64_t{n[0]} * n[1]);
    Vec3 x = deformation->position(node);
    x[2] -= k > n[2] / 2 ? 2.5e-3 : 0; // more than the 2 mm of a cell
    deformation->set_position(node, x);
  }
  of.deformation = deformation;
  View view = view_from({0.004, 0.003, 0.1}, 9);
  view.camera.view_angle = 4;
  view.clips = {{{0, 0, 0.8e-3}, {0, 0, -1}}}; // just above where the layers lie over each other
  Renderer renderer;
  const Picture& picture = renderer.render(std::span(&of, 1), view);
  for (std::size_t p = 0; p < picture.rgba.size(); ++p) {
    EXPECT_GT(picture.rgba[p][3], 0.99f) << p;
    EXPECT_LT(picture.depth[p], 0.1 + 1e-3) << p; // not first behind the fold
  }
}

TEST(FoldedContract, CellsThatAreTurnedInsideOutNeitherCrashNorSmear) {
  SceneObject of = cube(28, ring(8e-3, 3e-3), half_clear({0.9f, 0.4f, 0.2f}, 0.5));
  auto deformation = bent(of, 0.5);
  for (std::int64_t node = 0; node < deformation->lattice().n_nodes(); node += 7) {
    const Vec3 x = deformation->position(node);
    deformation->set_position(node, {x[0] + 5e-3, x[1] - 5e-3, -x[2]});
  }
  of.deformation = deformation;
  const View view = view_from({0.03, 0.05, 0.09}, 64);
  Renderer renderer;
  for (const auto& pixel : renderer.render(std::span(&of, 1), view).rgba)
    for (const float channel : pixel)
      ASSERT_TRUE(channel >= 0 && channel <= 1.0001f);
}

} // namespace
} // namespace maille::render::test
