/// `coupled` on boxes of one material against `coupled` on any body.

#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/carved.hpp"
#include "support/bodies/layers.hpp"
#include "support/bodies/scenes.hpp"
#include "support/coupled_algorithms.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"

namespace maille::deform {
namespace {

using test::solve_by;

/// A block held at its foot, pressed and pushed in the middle of its top.
Scene poked_block(Index3 cells, Vec3 spacing = {1e-3, 1e-3, 1e-3}) {
  Scene scene = test::box_scene(3, cells, spacing);
  test::hold_face(scene, 2, false);
  test::move_patch(scene, {cells[0] / 4, cells[1] / 4, cells[2]},
                   {(3 * cells[0] + 3) / 4, (3 * cells[1] + 3) / 4, cells[2]}, {0, 0.05e-3, -0.2e-3});
  return scene;
}

/// What both algorithms promise, each on bodies of its own kind.
struct Way {
  const char* name;
  Scene (*body)(Index3 cells);
  std::vector<double> poisson_ratios, tolerances;
  double of_other_vectors;      ///< relative difference where products are not fused with sums
  std::int64_t most_iterations; ///< to 1e-3
};

Scene carved(Index3 cells) {
  return test::carved_body(cells, test::Fibres::none);
}

Scene turning(Index3 cells) {
  return test::carved_body(cells, test::Fibres::turning);
}

Scene slanted(Index3 cells) {
  return test::carved_body(cells, test::Fibres::slanted);
}

/// Two labels that slide along an oblique plane, the lower one held, the upper one moved.
Scene gliding(Index3 cells) {
  const auto label = [&](const Vec3& at) {
    return std::floor(at[2]) * 2 < cells[2] + std::floor(at[0]) - std::floor(at[1]) ? 1 : 2;
  };
  Scene scene = test::labelled(cells, 1e-3, label, test::isotropic(20e3, 0.3), test::isotropic(10e3, 0.3))
                    .hold("z-")
                    .move("z+", {0.5e-3, 0, -0.2e-3})
                    .build();
  scene.sliding = {{1, 2}};
  return scene;
}

const std::vector<Way> ways{{"box",
                             [](Index3 cells) { return poked_block(cells); },
                             {0, 0.3, 0.45, 0.49},
                             {1e-2, 1e-3, 1e-4, 1e-6, 1e-8},
                             1e-5,
                             13},
                            {"masked", carved, {0.3, 0.49}, {1e-2, 1e-3, 1e-4, 1e-6}, 1e-4, 13},
                            {"turning", turning, {}, {}, 1e-4, 13},
                            {"slanted", slanted, {}, {}, 1e-4, 13},
                            {"tied", gliding, {0.3, 0.49}, {1e-2, 1e-3, 1e-4, 1e-6}, 1e-4, 40}};

// Truth: the same solver, converged.
TEST(CoupledSolversConsistent, ErrorIsBelowTheTolerance) {
  for (const Way& way : ways)
    for (const double poisson : way.poisson_ratios) {
      SCOPED_TRACE(testing::Message() << way.name << ' ' << poisson);
      Scene scene = way.body({20, 19, 18});
      scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson);
      scene.relaxation.tolerance = 1e-11;
      const Answer exact = test::solved(scene, "coupled");
      for (const double tolerance : way.tolerances) {
        scene.relaxation.tolerance = tolerance;
        const Answer answer = test::solved(scene, "coupled");
        EXPECT_LE(answer.residual, tolerance);
        EXPECT_LE(test::relative_difference(answer.displacement, exact.displacement), tolerance);
        // The energy is off by the square of the error in its norm, and by 1e-12 for rounding.
        EXPECT_LE(std::sqrt(std::abs(*answer.strain_energy / *exact.strain_energy - 1)),
                  std::max(tolerance, 1e-6));
        EXPECT_LE(answer.iterations, tolerance < 1e-3 ? 1000 : way.most_iterations);
      }
    }
}

TEST(CoupledSolversContract, SameBitsForAnyNumberOfThreads) {
  for (const Way& way : ways) {
    SCOPED_TRACE(way.name);
    Scene scene = way.body({30, 31, 37});
    scene.relaxation.tolerance = 1e-6; // more than one round
    test::expect_bits_of_any_threads([&](int threads) {
      Control control;
      control.threads = threads;
      return solve(scene, "coupled", control);
    });
  }
}

TEST(CoupledSolversContract, SameBitsForVectorsOfAnyLength) {
  for (const Way& way : ways) {
    const Scene scene = way.body({21, 18, 17});
    std::vector<Answer> found;
    for (const std::int64_t target : test::vector_targets()) {
      const test::ForcedVectors forced(target);
      const Answer answer = solve(scene, "coupled");
      if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) != 0) { // those that fuse products with sums
        found.push_back(answer);
        EXPECT_EQ(found.back().displacement, found.front().displacement) << way.name;
      } else if (!found.empty()) {
        EXPECT_LE(test::relative_difference(answer.displacement, found.front().displacement),
                  way.of_other_vectors);
      }
    }
  }
}

TEST(CoupledSolversContract, InterruptionLeavesAUsableState) {
  for (const Way& way : ways) {
    Scene scene = way.body({20, 20, 20});
    scene.relaxation.tolerance = 1e-12;
    int asked = 0;
    Control control;
    control.stop_requested = [&] { return ++asked > 3; };
    const Answer answer = solve(scene, "coupled", control);
    EXPECT_EQ(answer.status, Status::interrupted) << way.name;
    EXPECT_TRUE(answer.reaction.empty());
    for (const Prescribed& p : scene.prescribed)
      EXPECT_EQ(answer.displacement(p.component, p.node), p.value);
  }
}

TEST(BoxSolverContract, OnlyBoxesOfOneMatterTakeThisWay) {
  Scene scene = poked_block({6, 5, 4});
  EXPECT_TRUE(is_uniform_box(scene));
  EXPECT_EQ(solve(scene, "coupled").algorithm,
            "lattice elasticity, conjugate gradients around lattice multigrid");
  scene.specimen.material_id.assign(120, 0);
  EXPECT_TRUE(is_uniform_box(scene));
  scene.specimen.material_id[60] = no_material;
  EXPECT_FALSE(is_uniform_box(scene));
  EXPECT_EQ(solve(scene, "coupled").algorithm,
            "lattice elasticity, conjugate gradients around multigrid of the body's pieces");
  scene.specimen.material_id.clear();
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  scene.specimen.fibres.assign(120, {1, 0, 0});
  EXPECT_TRUE(is_uniform_box(scene));
  scene.specimen.fibres[3] = {0, 1, 0};
  EXPECT_FALSE(is_uniform_box(scene));
  EXPECT_FALSE(is_uniform_box(test::box_scene(2, {3, 3, 1})));
}

TEST(BoxSolverContract, MemoryIsSmallAndForeseen) {
  Scene scene = poked_block({64, 64, 64});
  const Answer answer = solve(scene, "coupled");
  const double nodes = 65 * 65 * 65;
  EXPECT_LE(static_cast<double>(answer.bytes) / nodes, 24 + 100); // the answer, and all else
  EXPECT_LE(answer.bytes, bytes_needed(scene, "coupled"));
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(200e3, 10e3, 6e3, 0.3, 0.4);
  EXPECT_LE(solve(scene, "coupled").bytes, bytes_needed(scene, "coupled")); // coarsened along one axis first
}

/// The ladder's answer is that of the general way, both converged to 1e-11.
void expect_answer_of_general_way(Scene scene) {
  const Index3& cells = scene.specimen.grid.cells();
  SCOPED_TRACE(testing::Message() << cells[0] << ' ' << cells[1] << ' ' << cells[2]);
  scene.relaxation.tolerance = 1e-11;
  const double tolerance = is_uniform_box(scene) ? 1e-9 : 1e-8;
  test::expect_same_answer(solve_by(solve_on_ladder, scene), solve_by(solve_coupled_body, scene), tolerance,
                           10 * tolerance);
}

/// With a weight, and then the weight alone, held at one face.
void expect_answers_with_loads(Scene scene, int held_axis) {
  for (Material& material : scene.materials)
    material.density = 1000;
  scene.gravity = {1, -2, -9};
  expect_answer_of_general_way(scene);
  scene.prescribed.clear();
  test::hold_face(scene, held_axis, held_axis == 0);
  expect_answer_of_general_way(scene);
}

TEST(CoupledSolversConsistent, BoxesAreAnsweredAsByTheGeneralWay) {
  for (const Index3& cells :
       {Index3{7, 12, 33}, {2, 20, 9}, {19, 2, 6}, {12, 9, 2}, {1, 1, 30}, {1, 1, 1}, {34, 3, 5}})
    expect_answer_of_general_way(poked_block(cells, {1e-3, 1.3e-3, 0.8e-3}));
  Scene fibrous = poked_block({12, 10, 9});
  fibrous.materials[0].elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 6e3, 0.3, 0.4);
  fibrous.specimen.fibre = {0.48, 0.6, 0.64};
  expect_answers_with_loads(fibrous, 0);
}

TEST(CoupledSolversConsistent, BodiesAreAnsweredAsByTheGeneralWay) {
  for (const auto fibres : {test::Fibres::none, test::Fibres::slanted, test::Fibres::turning})
    for (const Index3& cells : {Index3{9, 12, 13}, {17, 3, 8}, {2, 2, 9}, {1, 1, 1}})
      expect_answer_of_general_way(test::carved_body(cells, fibres));
  expect_answers_with_loads(test::carved_body({9, 8, 12}, test::Fibres::turning), 2);
  for (const int contact : {1, 2, 3}) // hinges
    expect_answer_of_general_way(test::two_blocks(6, contact));
  Scene bridged = test::box_scene(3, {9, 9, 13}); // two blocks and a bridge of one cell
  bridged.specimen.material_id.assign(std::size_t(bridged.specimen.grid.n_cells()), 0);
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 9; ++x)
      if (x != 4 || y != 3)
        bridged.specimen.material_id[std::size_t(bridged.specimen.grid.cell({x, y, 6}))] = no_material;
  test::hold_and_move_ends(bridged);
  expect_answer_of_general_way(bridged);
}

std::int64_t iterations(Scene scene) {
  scene.relaxation.tolerance = 1e-3;
  return solve_by(solve_on_ladder, scene).iterations;
}

TEST(MaskedSolverContract, IterationsAreBounded) { // boxes of one material take 5 to 6
  EXPECT_LE(iterations(test::two_blocks(12, 2)), 8);
  EXPECT_LE(iterations(test::two_blocks(12, 1)), 8);
  EXPECT_LE(iterations(test::carved_body({20, 20, 20}, test::Fibres::turning)), 10);
  // Nothing but bending, which coarser grids of linear functions are too stiff for; the general way takes 160
  // and 890 (to 1e-4).
  for (const auto& [cells, most] : {std::pair{Index3{1, 60, 60}, 40}, {Index3{1, 1, 500}, 75}}) {
    Scene scene = test::carved_body(cells, test::Fibres::slanted);
    std::ranges::replace(scene.specimen.material_id, no_material, std::uint8_t{0});
    EXPECT_LE(iterations(scene), most);
  }
  // A tendon across its fibres is a thousand times as soft as along them, and turned out of the axes.
  EXPECT_LE(iterations(read_scene(MAILLE_SCENES "/muscle_belly.toml")), 30);
}

TEST(MaskedSolverContract, IterationsGrowLittleWithContrastAndIncompressibility) {
  const auto bundle = [](double contrast, double poisson) { // a stiff cord in soft matter
    Scene scene = test::box_scene(3, {16, 16, 24});
    scene.materials.push_back(scene.materials[0]);
    scene.materials[0].elasticity = ElasticConstants::isotropic(1e3, poisson);
    scene.materials[1].elasticity = ElasticConstants::isotropic(contrast * 1e3, poisson);
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
      const Index3 at = scene.specimen.grid.cell_at(cell);
      const double wave = 8 + 2 * std::sin(0.3 * at[2]);
      scene.specimen.material_id.push_back(std::hypot(at[0] + 0.5 - wave, at[1] - 7.5) < 3 ? 1 : 0);
    }
    test::hold_and_move_ends(scene);
    return scene;
  };
  EXPECT_LE(iterations(bundle(10, 0.3)), 8);
  EXPECT_LE(iterations(bundle(1000, 0.3)), 10);
  EXPECT_LE(iterations(bundle(1000, 0.49)), 20);
}

/// A block of 18 cells a side on a rod of one cell by 25, under its weight across.
Scene block_on_rod() {
  Scene scene = test::box_scene(3, {18, 18, 45});
  auto& of_cell = scene.specimen.material_id;
  of_cell.assign(std::size_t(scene.specimen.grid.n_cells()), no_material);
  for (std::size_t i = 0; i < of_cell.size(); ++i) {
    const Index3 at = scene.specimen.grid.cell_at(std::int64_t(i));
    if (at[2] < 2 || at[2] >= 27 || (at[0] == 9 && at[1] == 9))
      of_cell[i] = 0;
  }
  test::hold_face(scene, 2, false);
  scene.materials[0].density = 1000;
  scene.gravity = {1, 0, 0};
  return scene;
}

/// Blocks of six cells a side, 1e4 times as stiff as what they float in.
Scene floating_blocks() {
  Scene scene = test::box_scene(3, {24, 24, 24});
  scene.materials.assign(2, scene.materials[0]);
  scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0.45);
  scene.materials[1].elasticity = ElasticConstants::isotropic(1e8, 0.3);
  auto& of_cell = scene.specimen.material_id;
  for (std::int64_t i = 0; i < scene.specimen.grid.n_cells(); ++i) {
    const Index3 at = scene.specimen.grid.cell_at(i);
    int blocks = 0;
    bool is_within = true;
    for (const int along : at) {
      blocks += along / 8;
      is_within = is_within && along % 8 > 0 && along % 8 < 7;
    }
    of_cell.push_back(is_within && blocks % 2 == 0 ? 1 : 0);
  }
  test::hold_and_move_ends(scene);
  return scene;
}

/// What is soft in them is less than 2^-11 of what is stiff.
TEST(MaskedSolverContract, StiffPartsOnThinOrSoftOnesAreNotRounded) {
  EXPECT_LE(iterations(block_on_rod()), 150);
  EXPECT_LE(iterations(floating_blocks()), 60);
}

TEST(MaskedSolverContract, MemoryFollowsTheMatterAndIsForeseen) {
  for (const auto fibres : {test::Fibres::none, test::Fibres::slanted, test::Fibres::turning}) {
    const Scene scene = test::carved_body({24, 24, 40}, fibres);
    const Answer answer = solve(scene, "coupled");
    EXPECT_LE(answer.bytes, bytes_needed(scene, "coupled"));
  }
  for (const Index3& cells : {Index3{1, 1, 500}, {1, 60, 60}, {60, 2, 60}, {2, 2, 300}}) { // chains, sheets
    Scene scene = test::carved_body(cells, test::Fibres::slanted);
    std::ranges::replace(scene.specimen.material_id, no_material, std::uint8_t{0});
    const Answer answer = solve(scene, "coupled");
    EXPECT_LE(answer.bytes, bytes_needed(scene, "coupled")) << cells[0] << ' ' << cells[1] << ' ' << cells[2];
  }
}

/// One material: most blocks of cells share a pattern if few cells are missing, and otherwise do not.
TEST(MaskedSolverContract, MemoryOfBlocksThatAreAlikeIsForeseen) {
  for (const unsigned missing : {40U, 7U}) {
    Scene scene = test::box_scene(3, {32, 32, 40});
    std::uint32_t random = 1;
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
      random = random * 1664525u + 1013904223u;
      const int z = scene.specimen.grid.cell_at(cell)[2];
      scene.specimen.material_id.push_back(z > 0 && z < 39 && (random >> 8) % missing == 0 ? no_material
                                                                                           : std::uint8_t{0});
    }
    test::hold_and_move_ends(scene);
    const Answer answer = solve(scene, "coupled");
    const std::int64_t forecast = bytes_needed(scene, "coupled");
    EXPECT_LE(answer.bytes, forecast) << missing;
    EXPECT_LE(forecast, 2 * answer.bytes) << missing;
  }
}

/// Columns that touch at edges alone, but for the layers that join them: hinges take more than is foreseen.
TEST(MaskedSolverContract, HingesBeyondTheForecastAreRefusedWhileTheyRun) {
  for (const int width : {2, 3, 4}) {
    Scene scene = test::box_scene(3, {32, 32, 40});
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
      const Index3 at = scene.specimen.grid.cell_at(cell);
      const bool is_void = (at[0] / width + at[1] / width) % 2 == 0 && at[2] % 10 > 1 && at[2] < 39;
      scene.specimen.material_id.push_back(is_void ? no_material : std::uint8_t{0});
    }
    test::hold_and_move_ends(scene);
    Control control;
    control.bytes_budget = bytes_needed(scene, "coupled");
    const Answer refused = solve(scene, "coupled", control);
    EXPECT_EQ(refused.message.find("coupled needs more memory than the "), 0U) << refused.message;
    control.bytes_budget = 4 * *control.bytes_budget;
    EXPECT_EQ(solve(scene, "coupled", control).status, Status::done) << width;
  }
}

/// A load that grows and falls again leaves no trace: answers depend on the scene alone.
TEST(RelaxersConsistent, CyclesOfLoadingDoNotDrift) {
  for (const char* method : {"relaxed", "coupled"}) {
    Scene scene = poked_block({6, 5, 7});
    const Answer first = solve(scene, method);
    ASSERT_TRUE(has_displacement(first.status)) << first.message;
    for (const double factor : {2.0, 5.0, -3.0, 0.5}) {
      Scene loaded = scene;
      for (Prescribed& prescribed : loaded.prescribed)
        prescribed.value *= factor;
      solve(loaded, method);
    }
    EXPECT_EQ(solve(scene, method).displacement, first.displacement) << method;
  }
}

} // namespace
} // namespace maille::deform
