/// `coupled` on bodies of any shape and matter against its general way.

#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/carved.hpp"
#include "support/coupled_algorithms.hpp"
#include "support/vector_targets.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace maille::deform {
namespace {

using test::solve_by;

/// The general way is the oracle, converged to 1e-11.
void expect_answer_of_general_way(Scene scene) {
  scene.relaxation.tolerance = 1e-11;
  test::expect_same_answer(solve_by(solve_coupled_masked, scene), solve_by(solve_coupled_body, scene), 1e-8,
                           1e-7);
}

TEST(MaskedSolverOracle, CarvedBodiesAreAnsweredAsByTheGeneralWay) {
  for (const auto fibres : {test::Fibres::none, test::Fibres::slanted, test::Fibres::turning})
    for (const Index3& cells : {Index3{9, 12, 13}, {17, 3, 8}, {2, 2, 9}, {1, 1, 1}}) {
      SCOPED_TRACE(testing::Message() << cells[0] << ' ' << cells[1] << ' ' << cells[2]);
      expect_answer_of_general_way(test::carved_body(cells, fibres));
    }
}

TEST(MaskedSolverOracle, LoadsAreAnsweredAsByTheGeneralWay) {
  Scene scene = test::carved_body({9, 8, 12}, test::Fibres::turning);
  for (Material& material : scene.materials)
    material.density = 1000;
  scene.gravity = {1, -2, -9};
  expect_answer_of_general_way(scene);
  scene.prescribed.clear();
  test::hold_face(scene, 2, false); // loads alone
  expect_answer_of_general_way(scene);
}

TEST(MaskedSolverOracle, HingesAndBridgesAreAnsweredAsByTheGeneralWay) {
  for (const int contact : {1, 2, 3}) {
    SCOPED_TRACE(contact);
    expect_answer_of_general_way(test::two_blocks(6, contact));
  }
  Scene scene = test::box_scene(3, {9, 9, 13}); // two blocks and a bridge of one cell
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0);
  for (int y = 0; y < 9; ++y)
    for (int x = 0; x < 9; ++x)
      if (x != 4 || y != 3)
        scene.specimen.material_id[static_cast<std::size_t>(scene.specimen.grid.cell({x, y, 6}))] =
            no_material;
  test::hold_and_move_ends(scene);
  expect_answer_of_general_way(scene);
}

TEST(MaskedSolverOracle, TheErrorIsBelowTheToleranceThatWasAsked) {
  for (const double poisson : {0.3, 0.49}) {
    Scene scene = test::carved_body({14, 13, 15}, test::Fibres::none);
    scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson);
    scene.relaxation.tolerance = 1e-11;
    const Answer exact = solve(scene, "coupled"); // the oracle: the same, converged
    for (const double tolerance : {1e-2, 1e-3, 1e-4, 1e-6}) {
      scene.relaxation.tolerance = tolerance;
      const Answer answer = solve(scene, "coupled");
      ASSERT_EQ(answer.status, Status::done);
      EXPECT_LE(answer.residual, tolerance);
      EXPECT_LE(test::relative_difference(answer.displacement, exact.displacement), tolerance) << poisson;
    }
  }
}

TEST(MaskedSolverContract, AnyNumberOfThreadsGivesTheSameBits) {
  Scene scene = test::carved_body({23, 21, 37}, test::Fibres::turning);
  scene.relaxation.tolerance = 1e-6;
  const Answer one = solve_by(solve_coupled_masked, scene);
  for (const int threads : {2, 3}) {
    const Answer several = solve_by(solve_coupled_masked, scene, threads);
    EXPECT_EQ(several.displacement, one.displacement) << threads;
    EXPECT_EQ(several.reaction, one.reaction) << threads;
    EXPECT_EQ(several.strain_energy, one.strain_energy) << threads;
  }
}

TEST(MaskedSolverContract, VectorsOfAnyLengthGiveTheSameBits) {
  const Scene scene = test::carved_body({19, 8, 9}, test::Fibres::slanted);
  std::vector<Answer> found;
  for (const std::int64_t target : tests::vector_targets()) {
    const tests::ForcedVectors forced(target);
    const Answer answer = solve_by(solve_coupled_masked, scene);
    if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) != 0) { // those that fuse products with sums
      found.push_back(answer);
      EXPECT_EQ(found.back().displacement, found.front().displacement);
    } else if (!found.empty()) {
      EXPECT_LE(test::relative_difference(answer.displacement, found.front().displacement), 1e-4);
    }
  }
}

std::int64_t iterations(Scene scene) {
  scene.relaxation.tolerance = 1e-3;
  return solve_by(solve_coupled_masked, scene).iterations;
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
  of_cell.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), no_material);
  for (std::size_t i = 0; i < of_cell.size(); ++i) {
    const Index3 at = scene.specimen.grid.cell_at(static_cast<std::int64_t>(i));
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

/// Columns that touch at edges alone, but for the layers that join them: hinges take most memory.
TEST(MaskedSolverContract, MemoryOfHingesIsForeseen) {
  for (const int width : {2, 3, 4}) {
    Scene scene = test::box_scene(3, {32, 32, 40});
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
      const Index3 at = scene.specimen.grid.cell_at(cell);
      const bool is_void = (at[0] / width + at[1] / width) % 2 == 0 && at[2] % 10 > 1 && at[2] < 39;
      scene.specimen.material_id.push_back(is_void ? no_material : std::uint8_t{0});
    }
    test::hold_and_move_ends(scene);
    EXPECT_LE(solve(scene, "coupled").bytes, bytes_needed(scene, "coupled")) << width;
  }
}

TEST(MaskedSolverContract, AnInterruptedSolveLeavesAUsableState) {
  Scene scene = test::carved_body({12, 12, 12}, test::Fibres::none);
  scene.relaxation.tolerance = 1e-12;
  int asked = 0;
  Control control;
  control.stop_requested = [&] { return ++asked > 3; };
  const Answer answer = solve(scene, "coupled", control);
  EXPECT_EQ(answer.status, Status::interrupted);
  EXPECT_TRUE(answer.reaction.empty());
  for (const Prescribed& p : scene.prescribed)
    EXPECT_EQ(answer.displacement(p.component, p.node), p.value);
}

} // namespace
} // namespace maille::deform
