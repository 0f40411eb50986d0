#include "maille/deform/drag.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/frame.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>

namespace maille::deform {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d vector(const Vec3& v) {
  return {v[0], v[1], v[2]};
}
Vec3 vec3(const Vector3d& v) {
  return {v[0], v[1], v[2]};
}

Scene bar() {
  return test::lattice_box({8, 4, 3}, test::even_limits(1.25, 0.75, 0.25));
}

const std::vector<Index3> handles{{0, 0, 0}, {8, 0, 0}, {8, 4, 0}, {0, 4, 3}, {4, 2, 3}};

/// Where a rotation about the origin and a shift put what rests at x, as a displacement.
Vec3 carried(const Matrix3d& rotation, const Vector3d& shift, const Vec3& x, const Vec3& u = {}) {
  return vec3(rotation * (vector(x) + vector(u)) + shift - vector(x));
}

Matrix3d random_turn(std::mt19937& random) {
  const auto number = [&] { return 2 * static_cast<double>(random()) / std::mt19937::max() - 1; };
  return AngleAxisd(3.1 * number(), Vector3d(number(), number(), number()).normalized()).toRotationMatrix();
}

/// The largest difference of a displacement from another one that is rotated and shifted.
double difference(const Scene& scene, const Displacement& found, const Matrix3d& rotation,
                  const Vector3d& shift, const Displacement& before) {
  const Grid& grid = scene.specimen.grid;
  double largest = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Vec3 expected = carried(rotation, shift, scene.specimen.position(grid.node_at(node)),
                                  {before(0, node), before(1, node), before(2, node)});
    for (int b = 0; b < 3; ++b)
      largest = std::max(largest, std::abs(found(b, node) - expected[static_cast<std::size_t>(b)]));
  }
  return largest;
}

TEST(ObjectFrameAnalytic, ARigidTurnOfAllHandlesTurnsTheBody) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    const Matrix3d rotation = random_turn(random);
    const Vector3d shift = (seed % 2 == 0 ? 800.0 : 1.0) * Vector3d(1, -0.5, 0.25); // to 100 body lengths
    Scene scene = bar();
    for (const Index3& at : handles)
      test::move(scene, at, carried(rotation, shift, scene.specimen.position(at)));
    const LinkLimits limits(scene);
    for (const std::string_view method : {"limits", "dijkstra", "literal", "sweep"}) {
      const Answer answer = solve(scene, method);
      ASSERT_EQ(answer.status, Status::done) << method << answer.message;
      // Truth: the body at rest, carried along.
      const double rounding = 1e-13 * (10 + shift.norm());
      EXPECT_LE(difference(scene, answer.displacement, rotation, shift, Displacement(scene.specimen.grid)),
                rounding)
          << method << " seed " << seed;
      EXPECT_LE(largest_violation(scene, limits, answer.displacement, object_frame(scene)), rounding)
          << method;
      for (const Prescribed& p : scene.prescribed)
        EXPECT_NEAR(answer.displacement(p.component, p.node), p.value, rounding);
      EXPECT_TRUE(test::has(answer.algorithm, "turned by"));
    }
  }
}

TEST(ObjectFrameConsistent, ADeformationThatIsTurnedIsTheTurnOfTheAnswer) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    Scene plain = bar();
    for (std::size_t i = 0; i < handles.size(); ++i) {
      const auto number = [&] { return static_cast<double>(random()) / std::mt19937::max() - 0.5; };
      test::move(plain, handles[i], {number(), number(), number()});
    }
    const Matrix3d rotation = random_turn(random);
    const Vector3d shift(3, 2, -1);
    Scene turned = bar();
    const auto of = [&](const Index3& at, int b) {
      const std::int64_t node = plain.specimen.grid.node(at);
      return std::ranges::find_if(plain.prescribed,
                                  [&](const Prescribed& p) { return p.node == node && p.component == b; })
          ->value;
    };
    for (const Index3& at : handles)
      test::move(turned, at,
                 carried(rotation, shift, plain.specimen.position(at), {of(at, 0), of(at, 1), of(at, 2)}));
    for (const std::string_view method : {"limits", "dijkstra"}) {
      const Answer before = solve(plain, method), after = solve(turned, method);
      EXPECT_EQ(before.status, after.status);
      EXPECT_LE(difference(plain, after.displacement, rotation, shift, before.displacement), 1e-12)
          << method << " seed " << seed;
    }
    Control several;
    several.threads = 7;
    EXPECT_EQ(solve(turned, "limits", several).displacement, solve(turned, "limits").displacement);
  }
}

TEST(ObjectFrameAnalytic, ADraggedBodyTurnsWithItsHandlesAndNothingIsLeftBehind) {
  Scene scene = bar();
  const LinkLimits limits(scene);
  for (const bool has_two_materials : {false, true}) {
    if (has_two_materials)
      scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
    Drag drag(scene, limits);
    // Two full turns about a skew axis while it travels, in steps of 18 degrees, and back.
    for (int i = 1; i <= 80; ++i) {
      const int step = i <= 40 ? i : 80 - i;
      const Matrix3d rotation =
          AngleAxisd(step * std::numbers::pi / 10, Vector3d(1, 2, 2) / 3).toRotationMatrix();
      const Vector3d shift = step * Vector3d(0.5, 0.25, -1);
      std::vector<Drag::Move> moves;
      for (const Index3& at : handles)
        moves.push_back(
            {scene.specimen.grid.node(at), carried(rotation, shift, scene.specimen.position(at))});
      EXPECT_FALSE(drag.move_to(moves).is_cut) << step;
      // Truth: the body at rest, carried along; float32 holds no more than rounding of nothing
      EXPECT_LE(difference(scene, drag.displacement(), rotation, shift, Displacement(scene.specimen.grid)),
                1e-11);
    }
    EXPECT_LE(drag.residue().largest, 1e-11);
  }
}

TEST(ObjectFrameConsistent, ADeformedBodyTurnsWithItsHandles) {
  const Scene scene = bar();
  const LinkLimits limits(scene);
  Drag plain(scene, limits, 1, FrameRule::fixed), turned(scene, limits);
  const Matrix3d rotation = AngleAxisd(2.2, Vector3d(2, -1, 2) / 3).toRotationMatrix();
  const Vector3d shift(5, 0, 1);
  // A stretch along x by half the slack: symmetric, so that the frame of the plain drag would not turn.
  std::vector<Drag::Move> stretch, stretch_and_turn;
  for (const Index3& at : std::vector<Index3>{
           {0, 0, 0}, {0, 4, 0}, {0, 0, 3}, {0, 4, 3}, {8, 0, 0}, {8, 4, 0}, {8, 0, 3}, {8, 4, 3}}) {
    const Vec3 u{at[0] == 0 ? -0.5 : 0.5, 0, 0};
    stretch.push_back({scene.specimen.grid.node(at), u});
    stretch_and_turn.push_back(
        {scene.specimen.grid.node(at), carried(rotation, shift, scene.specimen.position(at), u)});
  }
  plain.move_to(stretch);
  turned.move_to(stretch_and_turn);
  EXPECT_LE(difference(scene, turned.displacement(), rotation, shift, plain.displacement()),
            4 * std::ldexp(1.0, -23));
}

TEST(ObjectFrameContract, AHeldBodyKeepsItsFrameWhileItIsDragged) {
  Scene scene = bar();
  test::hold(scene, {4, 0, 0});
  const LinkLimits limits(scene);
  Drag follows(scene, limits), fixed(scene, limits, 1, FrameRule::fixed);
  std::vector<Drag::Move> moves;
  const Matrix3d rotation = AngleAxisd(0.2, Vector3d::UnitZ()).toRotationMatrix();
  for (const Index3& at : handles)
    moves.push_back(
        {scene.specimen.grid.node(at), carried(rotation, {0, 0, 0}, scene.specimen.position(at))});
  follows.move_to(moves);
  fixed.move_to(moves);
  EXPECT_EQ(follows.displacement(), fixed.displacement());
}

// Truth: a foundation under a turned bar gives way by what it and the bar hold against the turn, as in
// blocks.
TEST(ObjectFrameAnalytic, ASpringTiesTheBodyToTheWorld) {
  Scene scene = test::box_scene(3, {8, 4, 4}, {1e-3, 1e-3, 1e-3});
  for (int z = 0; z <= 4; ++z)
    for (int y = 0; y <= 4; ++y)
      for (int b = 0; b < 3; ++b)
        test::add_prescribed(scene, {0, y, z}, b, b == 0 ? -y * 1e-5 : 0, false);
  test::sort_prescribed(scene);
  EXPECT_TRUE(object_frame(scene).is_turned);
  scene.springs.push_back({scene.specimen.grid.cell({7, 0, 0}), 0, true, 1e6, {1, 0, 0}});
  EXPECT_FALSE(object_frame(scene).is_turned);
}

} // namespace
} // namespace maille::deform
