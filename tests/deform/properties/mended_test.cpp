/// What random scenes and the extremes once broke, one test each.

#include "feasible/bounds/clipping.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/carved.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/dense_program.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

namespace maille::deform {
namespace {

using test::even_limits;
using test::lattice_box;

/// A bar that taut limits make a ramp of: every sum along it is rounded.
Scene taut_bar(int cells, double by) {
  Scene scene = test::box_scene(3, {cells, 2, 2});
  test::hold_face(scene, 0, true);
  test::move_face(scene, 0, false, {by, 0, 0});
  return scene;
}

TEST(HeldNodesContract, StayAtRestToTheBitAndHandlesWhereTheyWereAsked) {
  // Truth: what the scene asks. By closed form (one handle) and by scans (a face), along paths that are not
  // dyadic.
  for (int cells = 2; cells < 30; ++cells) {
    const Scene scene = taut_bar(cells, 1e-9 / cells);
    for (const char* method : {"limits", "dijkstra", "relaxed", "sweep"}) {
      const Answer answer = test::solved(scene, method);
      for (const Prescribed& p : scene.prescribed)
        EXPECT_EQ(answer.displacement(p.component, p.node), p.value) << method << ", " << cells << " cells";
    }
  }
}

TEST(WideLimitsOracle, SlackThatNeverBindsCostsNoDigits) {
  // Shear along z is a million spacings wide, all else is narrow; moved by a billionth. Truth: shortest
  // paths, and the limits themselves.
  NeighbourLimits limits = even_limits(1.0, 0.99, 1e-7);
  limits.shear[2] = {1e6, 1e6, 1e6};
  limits.stretch[2] = 1e6;
  Scene scene = lattice_box({3, 3, 4}, limits);
  for (const Index3& at : test::face(scene, 0, false))
    test::move(scene, at, {1e-9, -0.7e-9, 0.3e-9});
  const LinkLimits links(scene);
  const Answer paths = solve(scene, "dijkstra");
  const double rounding = 4 * rounding_tolerance(scene.specimen.grid, scene.largest_prescribed());
  for (const char* method : {"limits", "relaxed"}) {
    const Answer answer = solve(scene, method);
    EXPECT_LE(largest_violation(scene, links, answer.displacement), rounding) << method;
    for (std::size_t b = 0; b < 3 && std::string_view(method) == "limits"; ++b)
      for (std::size_t i = 0; i < paths.displacement.n_nodes(); ++i)
        EXPECT_NEAR(answer.displacement(b, i), paths.displacement(b, i), rounding);
  }
}

/// Soft, soft with fibres, and a cap a billion times as stiff, held and moved at single nodes.
Scene capped_column() {
  Scene scene = test::box_scene(3, {1, 1, 3});
  scene.materials.assign(3, scene.materials[0]);
  scene.materials[0].elasticity = ElasticConstants::isotropic(10, 0.499);
  scene.materials[1].elasticity = ElasticConstants::transversely_isotropic(20, 10, 0.5, 0, 0.2);
  scene.materials[2].elasticity = ElasticConstants::isotropic(1e10, 0);
  scene.specimen.material_id = {0, 1, 2};
  const auto put = [&](const Index3& at, const Vec3& by, bool held) {
    for (int b = 0; b < 3; ++b)
      scene.prescribed.push_back({scene.specimen.grid.node(at), b, by[static_cast<std::size_t>(b)], held});
  };
  put({0, 1, 0}, {4.6e-4, -4.0e-4, 3.8e-5}, false);
  put({0, 1, 1}, {0, 0, 0}, true);
  put({0, 0, 2}, {1.1e-4, -3.7e-4, -3.4e-4}, false);
  test::sort_prescribed(scene);
  return scene;
}

TEST(CoupledContrastOracle, AStiffCapOnASoftBodyIsTheDenseSolution) {
  // Once: status done with a billion times the energy, as residuals in float32 no longer fell.
  Scene scene = capped_column();
  scene.relaxation.tolerance = 1e-5;
  const Answer answer = test::solved(scene, "coupled");
  const test::QuadraticProgram program = test::dense_program(scene, scene.prescribed);
  const Displacement truth = program.spread(program.K.ldlt().solve(program.force));
  EXPECT_LE(test::elastic_energy(scene, answer.displacement),
            test::elastic_energy(scene, truth) * (1 + 1e-4));
}

TEST(RelaxedNumbersContract, MovesNearTheEndsOfFloat32AreAnswered) {
  // Truth: a ramp, however long.
  for (const double by : {1e-38, 3e38, 1e-50}) {
    Scene scene = test::box_scene(3, {4, 4, 4});
    test::hold_face(scene, 0, false);
    test::move_face(scene, 0, true, {by, 0, 0});
    const Answer answer = solve(scene, "relaxed");
    ASSERT_EQ(answer.status, Status::done) << by << " " << answer.message;
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
      EXPECT_NEAR(answer.displacement(0, node) / by, scene.specimen.grid.node_at(node)[0] / 4.0, 1e-4);
  }
}

} // namespace
} // namespace maille::deform
