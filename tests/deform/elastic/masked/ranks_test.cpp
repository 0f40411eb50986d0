/// `coupled` by several ranks, here threads: the same bits as by one process.

#include "maille/deform/solve.hpp"
#include "support/bodies/carved.hpp"
#include "support/kit.hpp"
#include "support/thread_ranks.hpp"

#include <atomic>

namespace maille::deform {
namespace {

/// The reference is the answer of one process.
void expect_same_bits(const Scene& scene, const std::vector<int>& sizes, int threads = 1) {
  Control control;
  control.threads = threads;
  const Answer alone = solve(scene, "coupled", control);
  ASSERT_EQ(alone.status, Status::done) << alone.message;
  ASSERT_GT(alone.iterations, 3);
  for (const int size : sizes) {
    SCOPED_TRACE(testing::Message() << size << " ranks");
    ASSERT_TRUE(is_for_all_ranks(scene, "coupled", size));
    const auto answers = test::in_ranks(size, [&](Communicator& all) {
      Control of_rank = control;
      of_rank.communicator = &all;
      return solve(scene, "coupled", of_rank);
    });
    for (const Answer& answer : answers) {
      EXPECT_EQ(answer.status, alone.status);
      EXPECT_EQ(answer.iterations, alone.iterations);
      EXPECT_EQ(answer.residual, alone.residual);
      EXPECT_EQ(answer.strain_energy, alone.strain_energy);
    }
    const Answer& first = answers.front();
    EXPECT_EQ(first.reaction, alone.reaction);
    EXPECT_EQ(first.algorithm, alone.algorithm);
    EXPECT_TRUE(first.displacement == alone.displacement);
  }
}

TEST(RanksReference, BodiesOfAFewMaterials) {
  expect_same_bits(test::carved_body({9, 12, 37}, test::Fibres::none), {2, 3, 5});
  expect_same_bits(test::carved_body({14, 5, 24}, test::Fibres::slanted), {2, 6});
}

TEST(RanksReference, BodiesWhoseEveryCellIsAnother) {
  expect_same_bits(test::carved_body({9, 12, 37}, test::Fibres::turning), {2, 3, 9});
}

TEST(RanksReference, Hinges) {
  for (const int contact : {1, 2}) // by a corner, and by an edge
    expect_same_bits(test::two_blocks(10, contact), {2, 4, 5});
}

/// A gyroid of one material: most pieces of the coarser grid are of few patterns.
Scene gyroid(const Index3& cells) {
  Scene scene = test::box_scene(3, cells);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    const double x = at[0] / 2.5, y = at[1] / 2.5, z = at[2] / 2.5;
    const double of = std::sin(x) * std::cos(y) + std::sin(y) * std::cos(z) + std::sin(z) * std::cos(x);
    scene.specimen.material_id.push_back(of > -0.2 ? std::uint8_t{0} : no_material);
  }
  test::hold_and_move_ends(scene);
  return scene;
}

TEST(RanksReference, OneMaterialInPatternsAndThreads) {
  expect_same_bits(gyroid({26, 31, 64}), {2, 3, 8}, 2);
}

TEST(RanksReference, PlanesWithoutMatter) {
  for (const auto& [first, end] : {std::pair(0, 22), {41, 64}, {22, 41}}) {
    Scene scene = gyroid({26, 31, 64});
    scene.prescribed.clear();
    const Grid& grid = scene.specimen.grid;
    for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
      if (const int z = grid.cell_at(cell)[2]; z < first || z >= end)
        scene.specimen.material_id[static_cast<std::size_t>(cell)] = no_material;
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      if (const Index3 at = grid.node_at(node);
          scene.specimen.is_node(at) && (at[2] == first || at[2] == end))
        for (int c = 0; c < 3; ++c)
          scene.prescribed.push_back({node, c, at[2] == end ? 1e-4 : 0, at[2] == first});
    expect_same_bits(scene, {2, 16});
  }
}

TEST(RanksReference, LoadsAloneToRounding) {
  Scene scene = test::carved_body({9, 8, 29}, test::Fibres::slanted);
  for (Material& material : scene.materials)
    material.density = 1000;
  scene.gravity = {1, -2, -9};
  scene.prescribed.clear();
  test::hold_face(scene, 2, false);
  scene.relaxation.tolerance = 1e-11;
  expect_same_bits(scene, {2, 7});
}

TEST(RanksReference, ManySmallPieces) { // which coarsening joins wherever they lie
  Scene scene = test::carved_body({12, 12, 32}, test::Fibres::none);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    if (at[2] > 0 && at[2] < 31 && (at[0] + at[1] + at[2]) % 2 == 0)
      scene.specimen.material_id[static_cast<std::size_t>(cell)] = no_material;
  }
  expect_same_bits(scene, {2, 5});
}

TEST(RanksReference, ThinMatterAndASingleColumn) {
  Scene sheet = test::carved_body({1, 40, 40}, test::Fibres::slanted);
  expect_same_bits(sheet, {2, 4});
  expect_same_bits(test::carved_body({4, 5, 64}, test::Fibres::none), {3, 6});
}

TEST(RanksReference, SeveralRounds) { // residuals anew in float64
  Scene scene = test::carved_body({9, 12, 37}, test::Fibres::turning);
  scene.relaxation.tolerance = 1e-9;
  expect_same_bits(scene, {2, 3});
}

/// The share of a process in memory, as its arena counts it, and that of one alone.
TEST(RanksContract, EveryRankHoldsLess) {
  const Scene scene = gyroid({40, 40, 96});
  const Answer alone = solve(scene, "coupled", {});
  const auto answers = test::in_ranks(3, [&](Communicator& all) {
    Control control;
    control.communicator = &all;
    return solve(scene, "coupled", control);
  });
  for (const Answer& answer : answers) // of 32 layers, and six more on either side
    EXPECT_LT(static_cast<double>(answer.bytes), 0.8 * static_cast<double>(alone.bytes));
}

TEST(RanksContract, TheFirstSaysWhenToStop) {
  const Scene scene = test::carved_body({9, 12, 37}, test::Fibres::turning);
  const auto answers = test::in_ranks(2, [&](Communicator& all) {
    Control control;
    control.communicator = &all;
    std::atomic<int> asked = 0;
    control.stop_requested = [&] { return all.is_first() && ++asked > 3; };
    return solve(scene, "coupled", control);
  });
  for (const Answer& answer : answers) {
    EXPECT_EQ(answer.status, Status::interrupted);
    EXPECT_EQ(answer.iterations, 3);
  }
}

TEST(RanksContract, OthersAreAnsweredByEveryRank) {
  const Scene box = test::two_blocks(6, 3); // whole
  EXPECT_FALSE(is_for_all_ranks(box, "coupled", 2));
  const Scene body = test::carved_body({15, 15, 9}, test::Fibres::none);
  EXPECT_FALSE(is_for_all_ranks(body, "relaxed", 2));
  EXPECT_FALSE(is_for_all_ranks(body, "coupled", 3)); // too few planes
  const Answer alone = solve(body, "coupled", {});
  for (const Answer& answer : test::in_ranks(3, [&](Communicator& all) {
         Control control;
         control.communicator = &all;
         return solve(body, "coupled", control);
       }))
    EXPECT_TRUE(answer.displacement == alone.displacement);
}

} // namespace
} // namespace maille::deform
