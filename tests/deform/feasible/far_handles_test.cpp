/// Handles far away cost no accuracy: displacements are stored relative to where the body is.

#include "feasible/wavefront/wavefront.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/plan.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/lattice_scenes.hpp"

#include <cfloat>
#include <cmath>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

using tests::even_limits;
using tests::lattice_box;

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
      tests::move(scene, handle, far_away(times));
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
  tests::move(asked, handle, {1, 1, 1});
  EXPECT_EQ(solve(asked, "limits").algorithm, "tiled wavefront");
}

} // namespace
} // namespace maille::deform
