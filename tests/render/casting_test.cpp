// What single objects look like, against formulas and against the plain caster.

#include "maille/render/shared.hpp"
#include "maille/render/views.hpp"
#include "shapes.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"

#include <memory>

namespace maille::render::test {
namespace {

double alpha_in_the_middle(const SceneObject& object, const View& view) {
  Renderer renderer;
  const Picture& picture = renderer.render(std::span(&object, 1), view);
  return picture.rgba[picture.pixel(view.width / 2, view.height / 2)][3];
}

/// One colour, unlit.
Look plain_look(double opacity, const Rgb& colour = {1, 1, 1}) {
  Look look;
  look.colours = {{0, colour}};
  look.opacity = {{0, opacity}};
  look.shading.on = false;
  return look;
}

/// Full of matter: 32 mm between outermost centres.
SceneObject slab_of(const Look& look) {
  return cube(
      33, [](const Vec3&) { return 1.0; }, look);
}

/// How far a new picture is from the oracle's.
double error_of(const std::vector<SceneObject>& objects, const View& view, int every) {
  Renderer renderer;
  return difference(renderer.render(objects, view), objects, view, every);
}

TEST(SlabAnalytic, OpacityIsThatOfItsThicknessAtAnyStep) {
  for (const double opacity : {0.002, 0.02, 0.1}) {
    const SceneObject slab = slab_of(plain_look(opacity, {1, 0.5f, 0.25f}));
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
  SceneObject slab = slab_of(plain_look(0.02));
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
    EXPECT_LE(error_of({of}, view, 3), 1.0) << parallel;
  }
}

TEST_P(OneObjectOracle, DeformedAsItIs) {
  SceneObject of = object();
  of.deformation = bent(of, 0.8);
  of.pose = turned({1e-3, -2e-3, 0}, 0.7, 0.3);
  const View view = view_from({0.03, 0.05, 0.09}, 40);
  EXPECT_LE(error_of({of}, view, 5), 1.0);
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
      EXPECT_LE(error_of({of}, view, 5), 1.0) << samples;
    }
}

TEST_P(OneObjectOracle, ByEachKindOfVector) {
  const View view = view_from({0.03, 0.05, 0.09}, 40);
  for (const std::int64_t target : maille::test::vector_targets()) {
    const maille::test::ForcedVectors forced(target);
    for (const bool is_deformed : {false, true}) {
      SceneObject of = object();
      if (is_deformed)
        of.deformation = bent(of, 0.8);
      EXPECT_LE(error_of({of}, view, 7), 1.0) << hwy::TargetName(target);
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
  Look look = plain_look(1);
  look.mode = LookMode::isosurface;
  look.isovalue = 0.5;
  const auto box = [](const Vec3& x) {
    return std::max({std::abs(x[0]), std::abs(x[1]), std::abs(x[2])}) < 6.2e-3 ? 1.0 : 0.0;
  };
  SceneObject of = cube(20, box, look);
  of.pose = turned({}, 0.7, 0.5);
  const View view = view_from({0.03, 0.05, 0.09}, 60, 1);
  EXPECT_LE(error_of({of}, view, 1), 1.0);
}

INSTANTIATE_TEST_SUITE_P(Modes, OneObjectOracle,
                         testing::Values(LookMode::composite, LookMode::maximum, LookMode::isosurface));

TEST(UndeformedConsistent, ALatticeAtRestShowsWhatARigidObjectShows) {
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
  SceneObject slab = slab_of(plain_look(0.02));
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
  SceneObject of = cube(
      28, [](const Vec3&) { return 1.0; }, plain_look(0.9));
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

// Several objects: merged exactly, kept while they are still, the same on any number of threads.

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
      EXPECT_LE(error_of(rings, view, 3), 1.0) << opacity;
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

TEST(RendererContract, SameBitsForThreadsAndHistory) {
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

// Truth: a quarter of the circle.
TEST(ViewsAnalytic, ARingGoesAroundTheFocalPoint) {
  View first = view_from({0, 0, 0.15}, 48);
  first.camera.view_up = {0, 1, 0};
  EXPECT_EQ(view_of_ring(first, 0, 4), first);
  const Vec3 at = view_of_ring(first, 1, 4).camera.position, middle = first.camera.focal_point;
  EXPECT_NEAR(std::abs(at[0] - middle[0]), std::abs(first.camera.position[2] - middle[2]), 1e-9);
  EXPECT_NEAR(at[2], middle[2], 1e-9);
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

// Several processes in one: what they send each other goes from list to list.

/// Interlocked and deformed objects, and one that is hidden.
std::vector<SceneObject> objects_of_all_kinds() {
  std::vector<SceneObject> objects{cube(28, ring(8e-3, 2.5e-3), half_clear({0.9f, 0.4f, 0.2f}, 0.4)),
                                   cube(28, ring(8e-3, 2.5e-3), half_clear({0.2f, 0.5f, 0.9f}, 0.9)),
                                   cube(28, ring(6e-3, 3e-3), half_clear({0.2f, 0.8f, 0.3f}, 0.5)),
                                   cube(28, ring(6e-3, 3e-3), half_clear({0.2f, 0.8f, 0.3f}, 0.5))};
  objects[1].pose = turned({8e-3, 0, 0}, 1.5707963);
  objects[2].deformation = bent(objects[2], 0.6);
  objects[2].pose = turned({-4e-3, 3e-3, 2e-3}, 0.9, 0.4);
  objects[3].hidden = true;
  return objects;
}

using Bytes = SharedRenderer::Bytes;

Picture by_processes(int size, const std::vector<SceneObject>& objects, const View& view, Counters& sum) {
  std::vector<std::unique_ptr<SharedRenderer>> all;
  std::vector<std::vector<Bytes>> sent;
  for (int rank = 0; rank < size; ++rank) {
    all.push_back(std::make_unique<SharedRenderer>(rank, size, 1 + rank % 2));
    sent.push_back(all.back()->cast(objects, view));
  }
  std::vector<Bytes> pixels;
  for (std::size_t rank = 0; rank < all.size(); ++rank) {
    std::vector<Bytes> received;
    for (const auto& of : sent)
      received.push_back(of[rank]);
    pixels.push_back(all[rank]->compose(received));
    sum.rays += all[rank]->counters().rays;
    sum.rays_again += all[rank]->counters().rays_again;
    sum.objects += all[rank]->counters().objects;
  }
  return all.front()->assemble(pixels);
}

TEST(SharedContract, SameBitsByAnyNumberOfProcesses) {
  const auto objects = objects_of_all_kinds();
  const View view = view_from({0.03, 0.05, 0.09}, 75); // tiles that the picture's edge cuts
  Renderer alone;
  const Picture& expected = alone.render(objects, view);
  EXPECT_GT(alone.counters().rays_again, 0);
  for (const int size : {1, 2, 3, 7}) {
    Counters sum;
    const Picture picture = by_processes(size, objects, view, sum);
    EXPECT_EQ(picture.rgba, expected.rgba) << size;
    EXPECT_EQ(picture.depth, expected.depth) << size;
    EXPECT_EQ(picture.object, expected.object) << size;
    EXPECT_EQ(sum.rays, alone.counters().rays) << size; // no ray is cast twice
    EXPECT_EQ(sum.objects, alone.counters().objects) << size;
  }
}

TEST(SharedContract, WhatBreaksOffIsRefused) {
  const auto objects = objects_of_all_kinds();
  SharedRenderer renderer(0, 1);
  auto sent = renderer.cast(objects, view_from({0.03, 0.05, 0.09}, 40));
  sent[0].pop_back();
  EXPECT_THROW(renderer.compose(sent), std::invalid_argument);
  EXPECT_THROW(SharedRenderer(2, 2), std::invalid_argument);
}

} // namespace
} // namespace maille::render::test
