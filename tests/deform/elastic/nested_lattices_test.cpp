/// `coupled` on nested lattices: what extrapolation gains, and where it stays away.

#include "elastic/krylov/coupled_task.hpp"
#include "elastic/resample/coarser_scene.hpp"
#include "maille/deform/solve.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/scenes.hpp"
#include "support/sanitized.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille::deform {
namespace {

/// A block held at its foot, whose top is pressed down and aside in its middle half along x, and y where
/// `in_the_middle`.
Scene pressed_block(Index3 cells, bool in_the_middle, const ElasticConstants& elasticity) {
  Scene scene = test::box_scene(3, cells);
  scene.materials[0].elasticity = elasticity;
  scene.specimen.fibre = {0.8, 0, 0.6};
  test::hold_face(scene, 2, false);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y <= cells[1]; ++y)
      for (int x = 0; x <= cells[0]; ++x)
        if (!in_the_middle ||
            (4 * x >= cells[0] && 4 * x <= 3 * cells[0] && 4 * y >= cells[1] && 4 * y <= 3 * cells[1]))
          scene.prescribed.push_back(
              {scene.specimen.grid.node({x, y, cells[2]}), c, c == 2 ? -0.1e-3 : 0.02e-3 * c, false});
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  return scene;
}

Scene bent_bar(const ElasticConstants& elasticity) {
  Scene scene = test::box_scene(3, {32, 16, 16});
  scene.materials[0].elasticity = elasticity;
  scene.specimen.fibre = {0.8, 0, 0.6};
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {0, 0, 1e-3});
  return scene;
}

ElasticConstants isotropic(double poisson) {
  return ElasticConstants::isotropic(10e3, poisson);
}

ElasticConstants fibrous() {
  return ElasticConstants::transversely_isotropic(100e3, 10e3, 4e3, 0.3, 0.3);
}

Answer solved(Scene scene, Extrapolation extrapolation) {
  scene.relaxation.tolerance = 1e-4;
  scene.relaxation.extrapolation = extrapolation;
  Answer answer = solve(scene, "coupled");
  EXPECT_EQ(answer.status, Status::done) << answer.message;
  return answer;
}

/// Relative L2 errors without and with extrapolation, against the same question on cells a quarter as large.
struct Errors {
  double plain, extrapolated, share;
};
Errors errors_of(const Scene& scene) {
  const Scene finer = refined(scene), finest = refined(finer);
  const Displacement fine = at_coarse_nodes(
      scene, finer, at_coarse_nodes(finer, finest, solved(finest, Extrapolation::none).displacement));
  const Answer extrapolated = solved(scene, Extrapolation::nested);
  return {compare(scene, solved(scene, Extrapolation::none).displacement, fine).relative_l2,
          compare(scene, extrapolated.displacement, fine).relative_l2, extrapolated.extrapolated.value()};
}

TEST(ExtrapolationOracle, PokesGainAndNothingLoses) {
  struct Case {
    const char* name;
    Scene scene;
    double most; // of the error that is left
  };
  // The oracle is the lattice of a quarter of the spacing, itself off by a quarter of the plain error of a
  // poke.
  std::vector<Case> cases;
  for (const double poisson : {0.0, 0.3, 0.45, 0.49})
    cases.push_back({"poke", pressed_block({16, 16, 16}, true, isotropic(poisson)), 0.7});
  cases.push_back({"poke with fibres", pressed_block({16, 16, 16}, true, fibrous()), 0.7});
  for (const double poisson : {0.3, 0.45, 0.49}) {
    cases.push_back({"pull", pressed_block({16, 16, 16}, false, isotropic(poisson)), 1});
    cases.push_back({"bend", bent_bar(isotropic(poisson)), 1});
  }
  cases.push_back({"pull with fibres", pressed_block({16, 16, 16}, false, fibrous()), 1});
  cases.push_back({"bend with fibres", bent_bar(fibrous()), 1});
  if (test::is_sanitized)
    cases.resize(1);
  for (const Case& test_case : cases) {
    const Errors errors = errors_of(test_case.scene);
    SCOPED_TRACE(testing::Message() << test_case.name << ": " << errors.plain << " -> " << errors.extrapolated
                                    << ", share " << errors.share);
    EXPECT_LE(errors.extrapolated, test_case.most * errors.plain);
    if (test_case.most < 1) {
      EXPECT_GT(errors.share, 0.4);
    }
  }
}

/// An L of two materials in cells of 4 mm, cut twice in half along every axis.
Scene cut_twice() {
  Scene scene = test::box_scene(3, {8, 4, 8}, {4e-3, 4e-3, 4e-3});
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = isotropic(0.45);
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 8; ++x)
        scene.specimen.material_id.push_back(x >= 4 && z >= 4 ? no_material
                                                              : static_cast<std::uint8_t>(y / 2));
  test::hold_face(scene, 2, false);
  for (int c = 0; c < 3; ++c)
    for (int y = 1; y <= 3; ++y)
      for (int x = 1; x <= 3; ++x)
        scene.prescribed.push_back({scene.specimen.grid.node({x, y, 8}), c, c == 0 ? 1e-3 : 0, false});
  std::ranges::sort(scene.prescribed, {}, [](const Prescribed& p) { return std::pair(p.component, p.node); });
  return refined(refined(scene));
}

TEST(ExtrapolationOracle, ABodyOfTwoMaterialsGains) {
  const Scene scene = cut_twice();
  const Answer plain = solved(scene, Extrapolation::none),
               extrapolated = solved(scene, Extrapolation::nested);
  const Scene finer = refined(scene);
  const Displacement fine = at_coarse_nodes(scene, finer, solved(finer, Extrapolation::none).displacement);
  // The finer lattice is off by half of what the plain answer is, so no more than that half can be gained
  // against it.
  EXPECT_LE(compare(scene, extrapolated.displacement, fine).relative_l2,
            compare(scene, plain.displacement, fine).relative_l2);
  EXPECT_GT(extrapolated.extrapolated.value(), 0.4);
  EXPECT_NE(extrapolated.algorithm.find("extrapolated from three lattices"), std::string::npos);
}

TEST(ExtrapolationContract, WhatIsPrescribedStaysToTheBit) {
  const Scene scene = pressed_block({16, 16, 16}, true, isotropic(0.3));
  const Answer answer = solved(scene, Extrapolation::nested);
  for (const Prescribed& p : scene.prescribed)
    ASSERT_EQ(answer.displacement(p.component, p.node), p.value);
}

TEST(ExtrapolationContract, AnyNumberOfThreadsGivesTheSameBits) {
  Scene scene = pressed_block({32, 32, 32}, true, isotropic(0.3));
  scene.relaxation.extrapolation = Extrapolation::nested;
  const Answer one = solve(scene, "coupled");
  ASSERT_GT(one.extrapolated.value(), 0);
  Control control;
  control.threads = 3;
  EXPECT_EQ(solve(scene, "coupled", control).displacement, one.displacement);
}

TEST(ExtrapolationContract, TheSceneAsksForIt) {
  const std::string box = "[specimen]\nshape = \"box\"\ncells = 4\nspacing = \"1 mm\"\n"
                          "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
                          "[[hold]]\nwhere = \"x-\"\n";
  const auto asked = [&](const std::string& more) {
    return parse_scene(box + more, "scene.toml").relaxation.extrapolation;
  };
  EXPECT_EQ(asked(""), Extrapolation::none);
  EXPECT_EQ(asked("[relaxation]\nextrapolation = \"none\"\n"), Extrapolation::none);
  EXPECT_EQ(asked("[relaxation]\nextrapolation = \"nested\"\n"), Extrapolation::nested);
  EXPECT_THROW(asked("[relaxation]\nextrapolation = \"richardson\"\n"), InputError);
}

TEST(ExtrapolationContract, ItsMemoryIsForeseen) {
  for (Scene scene : {pressed_block({32, 32, 32}, true, isotropic(0.3)), cut_twice()}) {
    scene.relaxation.extrapolation = Extrapolation::nested;
    const Answer answer = solve(scene, "coupled");
    ASSERT_GT(answer.extrapolated.value(), 0) << answer.message;
    EXPECT_LE(answer.bytes, bytes_needed(scene, "coupled"));
  }
}

TEST(ExtrapolationContract, IsOffByDefault) {
  const Scene scene = pressed_block({16, 16, 16}, true, isotropic(0.3));
  EXPECT_FALSE(solved(scene, Extrapolation::none).extrapolated.has_value());
}

/// The answer is that of the lattice, and the message says why.
void expect_left_alone(const Scene& scene, const std::string& why) {
  SCOPED_TRACE(why);
  const Answer answer = solved(scene, Extrapolation::nested), plain = solved(scene, Extrapolation::none);
  EXPECT_EQ(answer.extrapolated.value(), 0);
  EXPECT_NE(answer.message.find("not extrapolated"), std::string::npos) << answer.message;
  EXPECT_NE(answer.message.find(why), std::string::npos) << answer.message;
  EXPECT_LE(compare(scene, answer.displacement, plain.displacement).relative_l2, 1e-4); // the tolerance
}

TEST(ExtrapolationContract, WhatCoarserLatticesCannotSayIsLeftAlone) {
  expect_left_alone(pressed_block({18, 16, 16}, false, isotropic(0.3)), "halved twice");
  Scene shifted = pressed_block({16, 16, 16}, true, isotropic(0.3));
  std::erase_if(shifted.prescribed, [&](const Prescribed& p) { // an edge of the patch between coarse nodes
    return !p.held && shifted.specimen.grid.node_at(p.node)[0] == 4;
  });
  expect_left_alone(shifted, "prescribed");
  Scene poked = test::box_scene(3, {16, 16, 16}); // a single node has no limit on ever finer lattices
  test::hold_face(poked, 2, false);
  tests::move(poked, {8, 8, 16}, {0, 0, -1e-3});
  expect_left_alone(poked, "differ by");
  Scene carved = cut_twice();
  carved.specimen.material_id[0] = no_material;
  expect_left_alone(carved, "matter");
  Scene uneven = test::box_scene(3, {16, 16, 16});
  test::hold_face(uneven, 2, false);
  uneven.tractions.push_back({uneven.specimen.grid.cell({8, 8, 15}), 2, true, {0, 0, -1e3}});
  expect_left_alone(uneven, "traction");
}

TEST(ExtrapolationAnalytic, AnExactAnswerStaysExact) {
  Scene scene = test::box_scene(
      3, {16, 16, 16}); // without Poisson effect a pull is one strain everywhere, on any lattice
  scene.materials[0].elasticity = isotropic(0);
  test::hold_face(scene, 2, false);
  test::move_face(scene, 2, true, {0, 0, 1e-3});
  const Displacement exact =
      test::affine_displacement<Displacement>(scene, {{{0, 0, 0}, {0, 0, 0}, {0, 0, 1.0 / 16}}});
  EXPECT_LE(compare(scene, solved(scene, Extrapolation::nested).displacement, exact).relative_l2, 1e-4);
}

TEST(ExtrapolationContract, LimitsAreObeyed) {
  Scene scene = pressed_block({16, 16, 16}, true, isotropic(0.3));
  scene.limits.from = LimitSource::given;
  scene.limits.given = tests::even_limits(1.2, 0.9, 0.2); // wide
  const Answer wide = solved(scene, Extrapolation::nested);
  EXPECT_GT(wide.extrapolated.value(), 0) << wide.message;
  EXPECT_LE(largest_violation(scene, LinkLimits(scene), wide.displacement), 1e-9);
  scene.limits.given = tests::even_limits(1.2, 0.994, 0.2);
  scene.relaxation.extrapolation = Extrapolation::nested;
  const Answer active = solve(scene, "coupled");
  EXPECT_LE(largest_violation(scene, LinkLimits(scene), active.displacement), 1e-9);
  EXPECT_NE(active.message.find("limits are active"), std::string::npos) << active.message;
  EXPECT_NE(active.message.find("not extrapolated, because limits are active"), std::string::npos)
      << active.message;
}

TEST(NestedLatticesOracle, AStartFromCoarserBoxesChangesNoAnswer) {
  Scene scene = pressed_block({32, 28, 30}, true, isotropic(0.45));
  scene.relaxation.tolerance = 1e-9;
  const Answer nested = solve(scene, "coupled");
  ThreadTeam team(1);
  const Control control;
  const Clock clock;
  Answer alone; // the oracle: from nothing
  ASSERT_TRUE(
      solve_coupled_box({scene, control, scene.prescribed, team, clock, [] { return false; }}, alone));
  EXPECT_LE(compare(scene, nested.displacement, alone.displacement).relative_l2, 2e-9);
  EXPECT_NEAR(*nested.strain_energy, *alone.strain_energy, 1e-10 * *alone.strain_energy);
}

TEST(CoarserSceneAnalytic, RefiningBringsBackWhatWasCoarsened) {
  const Scene scene = cut_twice();
  const std::optional<Scene> coarse = coarser_scene(scene, scene.prescribed);
  ASSERT_TRUE(coarse);
  EXPECT_EQ(what_coarsening_loses(*coarse, scene, scene.prescribed), "");
}

TEST(InterpolationAnalytic, LinearFieldsAreKept) {
  ThreadTeam team(2);
  for (const bool is_carved : {false, true}) {
    Scene coarse = test::box_scene(3, {3, 4, 5});
    if (is_carved) {
      coarse.specimen.material_id.assign(60, 0);
      coarse.specimen.material_id[59] = no_material;
    }
    const Scene fine = refined(coarse);
    const std::array<Vec3, 3> gradient{{{1, 2, 3}, {-1, 0.5, 2}, {0, 4, -2}}};
    const Displacement exact = test::affine_displacement<Displacement>(fine, gradient);
    Displacement u(fine.specimen.grid);
    interpolate(coarse.specimen, test::affine_displacement<Displacement>(coarse, gradient).values(),
                fine.specimen, u.values(), team);
    for (std::int64_t node = 0; node < fine.specimen.grid.n_nodes(); ++node) {
      if (!fine.specimen.is_node(fine.specimen.grid.node_at(node)))
        continue;
      for (int b = 0; b < 3; ++b)
        EXPECT_NEAR(u(b, node), exact(b, node), is_carved ? 1.5e-3 : 1e-15) << node; // one-sided at the notch
    }
  }
}

} // namespace
} // namespace maille::deform
