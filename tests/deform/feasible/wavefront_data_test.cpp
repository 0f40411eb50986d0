// Calves from MRI: bodies of many materials, with surfaces that no box has.
#include "feasible/limits.hpp"
#include "feasible/wavefront/wavefront.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/quanta.hpp"

#include <cstdlib>
#include <gtest/gtest.h>

namespace maille::deform {
namespace {

void expect_agreement(const char* file) {
  if (!std::getenv("MAILLE_DATA"))
    GTEST_SKIP() << "MAILLE_DATA is not set: no real volumes to read";
  const Scene scene = read_scene(std::string(MAILLE_SCENES) + "/" + file);
  const LinkLimits limits(scene);
  TiledBody body(scene, limits);
  const std::vector<Prescribed> clipped = body.move(scene.prescribed);
  Displacement u(scene.specimen.grid);
  body.copy_to(u);
  const Answer by_dijkstra = solve_limits(scene);
  ASSERT_EQ(by_dijkstra.status, Status::done) << by_dijkstra.message;
  const Index3 n = scene.specimen.grid.nodes();
  for (std::size_t i = 0; i < clipped.size(); ++i)
    ASSERT_EQ(clipped[i].value, scene.prescribed[i].value); // all that Dijkstra permits
  for (int b = 0; b < 3; ++b) {
    // Within (k + 2) quanta; a path through a muscle has no more links than twice the sum of the box's edges.
    const double bound = (2 * (n[0] + n[1] + n[2]) + 2) * body.quantum(b);
    for (std::int64_t i = 0; i < scene.specimen.grid.n_nodes(); ++i)
      ASSERT_NEAR(u(b, i), by_dijkstra.displacement(b, i), bound) << "node " << i << " component " << b;
    if (b == 2) { // the one that moves
      EXPECT_LE(bound, 2e-6 * scene.largest_prescribed()) << "the comparison would say nothing";
    }
  }
  double q = 0;
  for (int b = 0; b < 3; ++b)
    q = std::max(q, body.quantum(b));
  EXPECT_LE(tests::worst_violation(scene, limits, u, q), 3.001);
}

TEST(WavefrontCalfData, TheSoleusAgreesWithDijkstra) {
  expect_agreement("calf_soleus.toml");
}
TEST(WavefrontCalfData, BothLegsAgreeWithDijkstra) {
  expect_agreement("calf_both_legs.toml");
}

} // namespace
} // namespace maille::deform
