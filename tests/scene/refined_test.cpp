// The same question on a finer lattice.
#include "support/bodies/scenes.hpp"

#include "maille/scene/refined.hpp"
#include "maille/scene/scene.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace maille {
namespace {

/// An L of two materials, held at one end and moved at the other; 2 x 2 cells with one of them empty.
Scene corner_piece() {
  Scene scene = test::box_scene(2, {2, 2, 1}, {2e-3, 1e-3, 1});
  scene.specimen.material_id = {0, 1, 0, no_material};
  scene.materials.resize(2);
  const Grid& grid = scene.specimen.grid;
  scene.prescribed = {{grid.node({0, 0, 0}), 0, 0, true},
                      {grid.node({0, 1, 0}), 0, 2e-4, false},
                      {grid.node({2, 1, 0}), 0, 4e-4, false},
                      {grid.node({1, 2, 0}), 0, 6e-4, false}};
  scene.tractions = {{1, 1, false, {3, 5, 0}}};
  scene.gravity = {0, -10, 0};
  return scene;
}

TEST(RefinedContract, CellsAreCutAndKeepTheirMatter) {
  const Scene scene = corner_piece(), fine = refined(scene);
  const Grid& grid = fine.specimen.grid;
  EXPECT_EQ(grid.cells(), (Index3{4, 4, 1}));
  EXPECT_EQ(grid.spacing(), (Vec3{1e-3, 0.5e-3, 1}));
  EXPECT_EQ(fine.specimen.n_matter_cells(), 12);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    EXPECT_EQ(fine.specimen.material(cell),
              scene.specimen.material(scene.specimen.grid.cell({at[0] / 2, at[1] / 2, 0})));
  }
}

// Between two prescribed nodes of an edge of matter stands their mean; (2, 1) and (1, 2) are ends of a
// diagonal that bounds no matter, and nothing stands there.
TEST(RefinedAnalytic, WhatIsPrescribedIsInterpolatedAlongEdges) {
  const Scene fine = refined(corner_piece());
  const Grid& grid = fine.specimen.grid;
  std::vector<std::tuple<Index3, double, bool>> found;
  for (const Prescribed& p : fine.prescribed)
    found.emplace_back(grid.node_at(p.node), p.value, p.held);
  const std::vector<std::tuple<Index3, double, bool>> expected{{{0, 0, 0}, 0, true},
                                                               {{0, 1, 0}, 1e-4, false},
                                                               {{0, 2, 0}, 2e-4, false},
                                                               {{4, 2, 0}, 4e-4, false},
                                                               {{2, 4, 0}, 6e-4, false}};
  EXPECT_EQ(found, expected);
}

// Truth: forces do not depend on the mesh.
TEST(RefinedAnalytic, LoadsStayWhatTheyAre) {
  const Scene scene = corner_piece(), fine = refined(scene);
  for (int component = 0; component < 2; ++component) {
    const List<double> coarse_forces = nodal_forces(scene, component),
                       fine_forces = nodal_forces(fine, component);
    EXPECT_NEAR(std::accumulate(coarse_forces.begin(), coarse_forces.end(), 0.0),
                std::accumulate(fine_forces.begin(), fine_forces.end(), 0.0), 1e-12);
  }
}

TEST(RefinedContract, CoarseNodesReadTheirTwins) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    const Scene scene =
        test::box_scene(dimension, {3, dimension > 1 ? 2 : 1, dimension > 2 ? 4 : 1}, {1e-3, 2e-3, 3e-3});
    const Scene fine = refined(scene);
    Displacement u(fine.specimen.grid);
    for (std::int64_t node = 0; node < fine.specimen.grid.n_nodes(); ++node)
      for (int c = 0; c < dimension; ++c) {
        const Vec3 x = fine.specimen.position(fine.specimen.grid.node_at(node));
        u(c, node) = x[0] + 10 * x[1] + 100 * x[2] + c;
      }
    const Displacement coarse = at_coarse_nodes(scene, fine, u);
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
      for (int c = 0; c < dimension; ++c) {
        const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node));
        EXPECT_DOUBLE_EQ(coarse(c, node), x[0] + 10 * x[1] + 100 * x[2] + c);
      }
  }
}

} // namespace
} // namespace maille
