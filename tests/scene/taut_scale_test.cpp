/// The scale of taut limits against all pairs of prescribed nodes.

#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "support/bodies/carved.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace maille {
namespace {

/// Oracle: a search from every prescribed node, and the largest ratio to every other.
double scale_over_all_pairs(Scene scene) {
  scene.limits.taut_scale = 1;
  const LinkLimits unit(scene);
  const std::vector<Prescribed> prescribed = prescribed_in_object(scene, object_frame(scene));
  double scale = 0;
  for (const Prescribed& p : prescribed) {
    const PathEnd end{p.node, 0};
    const auto length = shortest_paths(scene, unit, p.component, {&end, 1}, PathDirection::from_ends);
    for (const Prescribed& q : prescribed)
      if (q.component == p.component && q.value != p.value)
        scale = std::max(scale, std::abs(q.value - p.value) / length[static_cast<std::size_t>(q.node)]);
  }
  return scale;
}

/// Sums along a path in the other direction differ in their last digits.
void expect_the_same(const Scene& scene) {
  const double oracle = scale_over_all_pairs(scene);
  EXPECT_NEAR(LinkLimits(scene).taut_scale(), oracle, 1e-14 * oracle);
}

/// Every prescribed value anew, from -1 to 1 mm.
void prescribe_at_random(Scene& scene, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(-1e-3, 1e-3);
  for (Prescribed& p : scene.prescribed)
    p = {p.node, p.component, value(random), false};
}

TEST(TautScaleOracle, HandlesThatMoveAndTurn) {
  Scene scene = test::box_scene(3, {6, 5, 7});
  test::hold_face(scene, 2, false);
  test::move_face(scene, 2, true, {});
  for (Prescribed& p : scene.prescribed)
    if (!p.held) {
      const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(p.node));
      p.value = p.component == 0 ? -0.1 * x[1] : p.component == 1 ? 0.1 * x[0] : 1e-4;
    }
  expect_the_same(scene);
}

TEST(TautScaleOracle, BoxesThatAreHeldAndPoked) {
  for (const Index3& cells : {Index3{5, 4, 3}, {1, 6, 2}, {7, 1, 1}}) {
    Scene scene = test::box_scene(3, cells, {1e-3, 0.7e-3, 1.9e-3});
    scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
    test::hold_face(scene, 2, false);
    for (const int component : {0, 2})
      scene.prescribed.push_back(
          {scene.specimen.grid.node({cells[0], 0, cells[2]}), component, -2e-4, false});
    std::ranges::sort(scene.prescribed, {},
                      [](const Prescribed& p) { return std::pair(p.component, p.node); });
    expect_the_same(scene);
    prescribe_at_random(scene, 7);
    expect_the_same(scene);
  }
}

TEST(TautScaleOracle, AnyValuesOnBodiesWithHoles) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Scene scene = test::carved_body({4, 5, 4}, seed % 2 == 0 ? test::Fibres::none : test::Fibres::turning);
    prescribe_at_random(scene, seed);
    SCOPED_TRACE(seed);
    expect_the_same(scene);
  }
}

TEST(TautScaleOracle, PiecesThatAreNotJoined) {
  Scene scene = test::box_scene(2, {5, 2, 1});
  scene.specimen.material_id = {0, 0, no_material, 0, 0, 0, 0, no_material, 0, 0};
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {-1e-3, 0, 0});
  expect_the_same(scene);
  EXPECT_EQ(LinkLimits(scene).taut_scale(), 0) << "no move uses slack up";
  // The lowest value stands alone on its piece's end; the others differ on theirs.
  const std::int64_t near = scene.specimen.grid.node({4, 0, 0});
  scene.prescribed.push_back({near, 0, -0.8e-3, false});
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  for (Prescribed& p : scene.prescribed)
    if (p.held && p.component == 0)
      p.value = -2e-3;
  expect_the_same(scene);
  EXPECT_GT(LinkLimits(scene).taut_scale(), 0);
}

} // namespace
} // namespace maille
