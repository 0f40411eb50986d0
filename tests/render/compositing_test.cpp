// Several objects: merged exactly, kept while they are still, the same on any number of threads.

#include "maille/render/views.hpp"
#include "shapes.hpp"

#include <gtest/gtest.h>

namespace maille::render::test {
namespace {

std::vector<SceneObject> linked_rings(double opacity) {
  std::vector<SceneObject> rings{cube(28, ring(8e-3, 2.5e-3), half_clear({0.9f, 0.4f, 0.2f}, opacity)),
                                 cube(28, ring(8e-3, 2.5e-3), half_clear({0.2f, 0.5f, 0.9f}, opacity))};
  rings[1].pose = turned({8e-3, 0, 0}, 1.5707963);
  return rings;
}

/// A letter C around a rod, and a bent block that presses against both.
std::vector<SceneObject> around_a_rod() {
  const auto c = [](const Vec3& x) {
    const double off = std::abs(std::hypot(x[0], x[1]) - 7e-3) - 2e-3;
    const double gap = 3e-3 - std::hypot(x[0] - 7e-3, x[1]);
    return std::clamp(0.5 - std::max({off, gap, std::abs(x[2]) - 6e-3}) / 2e-3, 0.0, 1.0);
  };
  const auto rod = [](const Vec3& x) {
    return std::clamp(0.5 - std::max(std::hypot(x[0], x[1]) - 4.5e-3, std::abs(x[2]) - 10e-3) / 2e-3, 0.0,
                      1.0);
  };
  std::vector<SceneObject> objects{cube(26, c, half_clear({0.9f, 0.4f, 0.2f}, 0.4)),
                                   cube(26, rod, half_clear({0.3f, 0.8f, 0.3f}, 0.9)),
                                   cube(26, rod, half_clear({0.4f, 0.4f, 0.9f}, 0.3))};
  objects[2].deformation = bent(objects[2], 0.6);
  objects[2].pose = turned({-4e-3, 3e-3, 2e-3}, 0.9, 0.4);
  return objects;
}

TEST(CompositeOracle, InterlockedRingsFromAllSides) {
  for (const double opacity : {0.15, 0.95}) {
    const auto rings = linked_rings(opacity);
    for (const Vec3& eye : {Vec3{0.02, 0.03, 0.11}, Vec3{-0.09, 0.04, 0.05}, Vec3{0.03, -0.11, 0.01}}) {
      const View view = view_from(eye, 48);
      Renderer renderer;
      EXPECT_LE(difference(renderer.render(rings, view), rings, view, 3), 1.0) << opacity;
    }
  }
}

TEST(CompositeOracle, WhatIsPressedTogetherAndOneOfThemDeformed) {
  const auto objects = around_a_rod();
  const View view = view_from({0.03, 0.05, 0.09}, 40);
  Renderer renderer;
  EXPECT_LE(difference(renderer.render(objects, view), objects, view, 5), 1.0);
  EXPECT_GT(renderer.counters().rays_again, 0);
}

TEST(RendererContract, SameBitsOnAnyNumberOfThreadsAndWhateverWasRenderedBefore) {
  auto objects = around_a_rod();
  const View view = view_from({0.03, 0.05, 0.09}, 100);
  Renderer fresh(1);
  const Picture expected = fresh.render(objects, view);
  for (const int threads : {2, 5}) {
    Renderer renderer(threads);
    auto before = objects;
    before[1].pose.position[0] += 3e-3;
    before[0].hidden = true;
    renderer.render(before, view);
    const Picture& picture = renderer.render(objects, view);
    EXPECT_EQ(picture.rgba, expected.rgba);
    EXPECT_EQ(picture.depth, expected.depth);
    EXPECT_EQ(picture.object, expected.object);
  }
}

TEST(RendererContract, NothingMovesNoRayIsCastAndWhatMovesCastsItsOwn) {
  auto objects = linked_rings(0.95);
  objects[1].pose.position = {0.03, 0, 0}; // apart, so that no ray is cast again
  const View view = view_from({0, 0, 0.15}, 64);
  Renderer renderer;
  renderer.render(objects, view);
  const Counters first = renderer.counters();
  renderer.render(objects, view);
  EXPECT_EQ(renderer.counters().rays, first.rays);
  EXPECT_EQ(renderer.counters().pixels_merged, first.pixels_merged);
  objects[1].pose.position[1] += 1e-3;
  renderer.render(objects, view);
  EXPECT_EQ(renderer.counters().objects, first.objects + 1);
  EXPECT_LT(renderer.counters().rays - first.rays, first.rays);
}

TEST(RendererContract, ADeformationThatChangesIsSeen) {
  auto object = cube(28, ring(8e-3, 3e-3), half_clear({0.9f, 0.4f, 0.2f}, 0.9));
  auto deformation = bent(object, 0.2);
  object.deformation = deformation;
  const View view = view_from({0, 0, 0.15}, 64);
  Renderer renderer;
  const auto before = renderer.render(std::span(&object, 1), view).rgba;
  for (std::int64_t node = 0; node < deformation->lattice().n_nodes(); ++node) {
    const Vec3 x = deformation->position(node);
    deformation->set_position(node, {x[0] + 1e-3, x[1], x[2]});
  }
  EXPECT_NE(renderer.render(std::span(&object, 1), view).rgba, before);
}

TEST(PickContract, LeadsBackToTheMatterAtRest) {
  auto object = cube(28, ring(8e-3, 3e-3), half_clear({0.9f, 0.4f, 0.2f}, 1));
  object.deformation = bent(object, 0.8);
  object.pose = turned({1e-3, -2e-3, 0}, 0.7, 0.3);
  const View view = view_from({0.03, 0.05, 0.09}, 64);
  Renderer renderer;
  const Picture& picture = renderer.render(std::span(&object, 1), view);
  int found = 0;
  for (int y = 0; y < 64; y += 7)
    for (int x = 0; x < 64; x += 7) {
      const auto pick = renderer.pick(x, y);
      EXPECT_EQ(pick.has_value(), picture.object[picture.pixel(x, y)] == 0);
      if (!pick)
        continue;
      ++found;
      // Where half of the light is spent values are between those of the ramp.
      const double value = object.volume->value_at(object.volume->grid().index_of(pick->rest));
      EXPECT_GT(value, 0.3);
      EXPECT_LT(value, 1.01);
    }
  EXPECT_GT(found, 5);
  EXPECT_FALSE(renderer.pick(0, 0));
  EXPECT_FALSE(renderer.pick(-1, 3));
}

TEST(RendererContract, BadInputIsRefused) {
  const auto objects = linked_rings(1);
  Renderer renderer;
  View view = view_from({0, 0, 0.15}, 0);
  EXPECT_THROW(renderer.render(objects, view), std::invalid_argument);
  view = view_from({0, 0, 0}, 64); // at its focal point
  EXPECT_THROW(renderer.render(objects, view), std::invalid_argument);
  view = view_from({0, 0, 0.15}, 64);
  view.camera.view_up = {0, 0, 2};
  EXPECT_THROW(renderer.render(objects, view), std::invalid_argument);
  view = view_from({0, 0, std::nan("")}, 64);
  EXPECT_THROW(renderer.render(objects, view), std::invalid_argument);
  EXPECT_THROW(renderer.render(std::vector<SceneObject>(1), view_from({0, 0, 0.15}, 64)),
               std::invalid_argument);
}

TEST(ViewsContract, ARingKeepsWhatStandsStillAndCastsTheToolAlone) {
  auto objects = linked_rings(0.95);
  RingOfViews views(view_from({0, 0, 0.15}, 48), 4);
  views.prepare(objects);
  const auto before = views.counters();
  views.render(2, objects);
  EXPECT_EQ(views.counters().rays, before.rays);
  objects[1].pose.position[1] += 2e-3;
  const Picture picture = views.render(2, objects);
  EXPECT_EQ(views.counters().objects, before.objects + 1);
  Renderer fresh;
  EXPECT_EQ(fresh.render(objects, views.view(2)).rgba, picture.rgba);
}

TEST(ViewsContract, StereoPairs) {
  const auto objects = linked_rings(0.95);
  StereoRenderer renderer;
  const auto eyes = renderer.render(objects, view_from({0, 0, 0.15}, 40));
  EXPECT_NE(eyes[0]->rgba, eyes[1]->rgba);
  const Picture pair = side_by_side(*eyes[0], *eyes[1]);
  EXPECT_EQ(pair.width, 80);
  EXPECT_EQ(pair.rgba[pair.pixel(50, 20)], eyes[1]->rgba[eyes[1]->pixel(10, 20)]);
  const Picture glasses = anaglyph(*eyes[0], *eyes[0], {0, 0, 0});
  for (const auto& pixel : glasses.rgba)
    ASSERT_EQ(pixel[0], pixel[1]); // two eyes that see the same see grey
}

} // namespace
} // namespace maille::render::test
