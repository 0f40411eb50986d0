#include "feasible/wavefront/wavefront.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/frame.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>
#include <cfloat>

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

/// Handles far away cost no accuracy: displacements are stored relative to where the body is.

using test::even_limits;
using test::lattice_box;

// Links are 1 m long, so an ulp of a link's length in float32 is FLT_EPSILON.
constexpr int n = 24;
constexpr double body_size = n;

Scene homogeneous() {
  return lattice_box({n, n, n}, even_limits(1.21, 0.83, 0.17));
}

/// Two kinds whose limits are the same: the wavefront must take it, and still the answer is a cone.
Scene tiled() {
  Scene scene = homogeneous();
  scene.materials.push_back(scene.materials[0]);
  for (Material& material : scene.materials)
    material.limits = scene.limits.given;
  scene.limits.from = LimitSource::material;
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (std::size_t i = 0; i < scene.specimen.material_id.size(); i += 3)
    scene.specimen.material_id[i] = 1;
  return scene;
}

/// Analytic, Theorem 2: what a node at offset o from the handle does when the handle has gone by `by`, from
/// rest.
double cone(const NeighbourLimits& limits, const Index3& o, int component, double by) {
  double length = std::abs(by);
  for (std::size_t a = 0; a < 3; ++a) {
    const auto b = static_cast<std::size_t>(component);
    const bool is_ahead = (o[a] > 0) == (by > 0);
    const double slack = a != b     ? limits.shear[a][b]
                         : is_ahead ? 1 - limits.compress[a]
                                    : limits.stretch[a] - 1;
    length -= std::abs(o[a]) * slack;
  }
  return std::copysign(std::max(0.0, length), by);
}

struct Errors {
  double against_cone = 0, violation = 0; ///< in ulps of a link's length
};

Errors errors_of(const Scene& scene, const Displacement& u, const Index3& handle, const Vec3& by) {
  const Scene cone_scene = homogeneous();
  Errors errors;
  for (int b = 0; b < 3; ++b)
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
      const Index3 at = scene.specimen.grid.node_at(node);
      const double expected =
          cone(cone_scene.limits.given, {at[0] - handle[0], at[1] - handle[1], at[2] - handle[2]}, b,
               by[static_cast<std::size_t>(b)]);
      errors.against_cone =
          std::max(errors.against_cone, std::abs(u(b, node) - expected) / double{FLT_EPSILON});
    }
  errors.violation = largest_violation(scene, LinkLimits(scene), u) / double{FLT_EPSILON};
  return errors;
}

Vec3 far_away(double times) {
  return {1.01 * times * body_size, -0.97 * times * body_size, 0.83 * times * body_size};
}

// Homogeneous drags: the offset follows when a stored number has gone 4 slack ranges (ranges_before_rebase);
// a range is the way from full compression to full stretch, 24 * (0.38 + 0.34 + 0.34) = 25.4 m. So stored
// numbers stay below 5 * 25.4 < 128, where half an ulp of float32 is 32 ulps of 1. One is a sum of two
// rounded ones; a link compares two.
constexpr double ulps_stored = 2 * 32, ulps_between = 2 * ulps_stored;

/// Tiles: within (k + 2) quanta, k <= 72 the links of a path; no link is off by more than 3 (see TiledBody).
double quanta_in_ulps(const Scene& scene, const LinkLimits& limits, double quanta) {
  const TiledBody body(scene, limits);
  return quanta * std::max({body.quantum(0), body.quantum(1), body.quantum(2)}) / double{FLT_EPSILON};
}

TEST(FarHandlesAnalytic, DragsKeepTheirAccuracyAtAnyDistance) {
  const Index3 handle{n, 3, 7};
  for (const Scene& scene : {homogeneous(), tiled()}) {
    const LinkLimits limits(scene);
    const bool is_tiled = !limits.is_homogeneous();
    const double most = is_tiled ? quanta_in_ulps(scene, limits, 74) : ulps_stored;
    const double most_between = is_tiled ? quanta_in_ulps(scene, limits, 3.001) : ulps_between;
    EXPECT_LE(most_between, 128);
    for (const double times : {1.0, 100.0, 1e4})
      for (const int steps : {1, 50}) {
        Drag drag(scene, limits);
        for (int k = 1; k <= steps; ++k)
          drag.move_to(scene.specimen.grid.node(handle), far_away(times * k / steps));
        const Errors errors = errors_of(scene, drag.displacement(), handle, far_away(times));
        EXPECT_LE(errors.against_cone, most) << drag.algorithm() << " " << times << " in " << steps;
        EXPECT_LE(errors.violation, most_between) << drag.algorithm() << " " << times << " in " << steps;
      }
  }
}

TEST(FarHandlesAnalytic, AnswersKeepTheirAccuracyAtAnyDistance) {
  const Index3 handle{n, 3, 7};
  for (Scene scene : {homogeneous(), tiled()})
    for (const double times : {1.0, 100.0, 1e4}) {
      test::move(scene, handle, far_away(times));
      const Answer answer = solve(scene, "limits");
      const Errors errors = errors_of(scene, answer.displacement, handle, far_away(times));
      // The closed form works in float64: far less than one ulp of float32.
      const LinkLimits limits(scene);
      const double most = limits.is_homogeneous() ? 0.1 : quanta_in_ulps(scene, limits, 74);
      EXPECT_LE(errors.against_cone, most) << answer.algorithm << " " << times;
      EXPECT_LE(errors.violation, 1) << answer.algorithm << " " << times;
    }
  EXPECT_EQ(plan_limits(tiled(), LinkLimits(tiled())).of_component[0], Algorithm::rest); // nothing asked yet
  Scene asked = tiled();
  test::move(asked, handle, {1, 1, 1});
  EXPECT_EQ(solve(asked, "limits").algorithm, "tiled wavefront");
}

} // namespace
} // namespace maille::deform
