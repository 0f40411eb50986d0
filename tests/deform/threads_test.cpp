/// Every way to answer that uses threads, on bodies large enough for it: as many threads, the same bits.
/// Under the thread sanitizer (preset tsan) the same says that none reads what another writes.

#include "feasible/feasible_set.hpp"
#include "maille/deform/drag.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/link_limits.hpp"
#include "support/bodies/carved.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/kit.hpp"

namespace maille::deform {
namespace {

/// 33 x 33 x 33 nodes, from which on every loop is shared.
Scene box() {
  Scene scene = test::box_scene(3, {32, 32, 32});
  test::hold_and_move_ends(scene, {1e-3, 0, 0.5e-3});
  return scene;
}

Scene with_slack(const Scene& scene, double slack) {
  return test::with_limits(scene, test::even_limits(1 + slack, 1 - slack, slack));
}

struct Case {
  std::string name, method;
  Scene scene;
};

std::vector<Case> cases() {
  Scene blocks = test::box_scene(3, {16, 16, 16});
  test::hold_and_move_ends(blocks, {1e-3, 0, 0.5e-3});
  blocks.strain = Strain::finite;
  Scene nested = box();
  nested.relaxation.extrapolation = Extrapolation::nested;
  const Scene carved = test::carved_body({32, 32, 36}, test::Fibres::turning);
  std::vector<Case> list{{"closed_form", "limits", box()},
                         {"scans", "limits", with_slack(box(), 0.05)},
                         {"wavefront", "limits", with_slack(carved, 0.05)},
                         {"relaxed_box", "relaxed", with_slack(box(), 0.05)},
                         {"relaxed_body", "relaxed", with_slack(carved, 0.05)},
                         {"coupled_box", "coupled", box()},
                         {"coupled_within_limits", "coupled", with_slack(box(), 0.05)},
                         {"coupled_body", "coupled", carved},
                         {"coupled_blocks", "coupled", blocks},
                         {"coupled_nested", "coupled", nested}};
  for (Case& one : list)
    one.scene.relaxation.tolerance = 3e-2; // the loops are the same, and fewer
  return list;
}

class ThreadsConsistent : public testing::TestWithParam<Case> {};

TEST_P(ThreadsConsistent, ThreadsGiveTheBitsOfOne) {
  const Scene& scene = GetParam().scene;
  Control control;
  const Answer one = solve(scene, GetParam().method, control);
  ASSERT_TRUE(has_displacement(one.status)) << one.message;
  for (const int threads : {2, 4}) {
    control.threads = threads;
    const Answer several = solve(scene, GetParam().method, control);
    EXPECT_EQ(several.status, one.status);
    EXPECT_EQ(several.displacement, one.displacement) << threads;
    EXPECT_EQ(several.reaction, one.reaction) << threads;
  }
}

INSTANTIATE_TEST_SUITE_P(Ways, ThreadsConsistent, testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param.name; });

TEST(ThreadsInHandConsistent, DragsAndProjectionsGiveTheBitsOfOne) {
  for (const Scene& scene :
       {with_slack(box(), 0.05), with_slack(test::carved_body({32, 32, 36}, test::Fibres::none), 0.05)}) {
    const LinkLimits limits(scene);
    Drag one(scene, limits, 1), several(scene, limits, 4);
    const std::int64_t first = scene.specimen.grid.node({30, 30, 20}),
                       second = scene.specimen.grid.node({3, 3, 20});
    for (const double by : {0.5e-3, 3e-3, -2e-3}) {
      const std::vector<Drag::Move> moves{{first, {by, 0, by / 2}}, {second, {0, by, 0}}};
      one.move_to(moves);
      several.move_to(moves);
    }
    Displacement u = one.displacement(), v = several.displacement();
    EXPECT_EQ(u, v);
    for (std::size_t i = 0; i < u.n_nodes(); i += 7) // no longer within the limits
      if (u(0, i) != 0)
        u(0, i) = v(0, i) = 1.5 * u(0, i);
    EXPECT_EQ(FeasibleSet(scene, limits, 1).project(u), FeasibleSet(scene, limits, 4).project(v));
    EXPECT_EQ(u, v);
  }
}

} // namespace
} // namespace maille::deform
