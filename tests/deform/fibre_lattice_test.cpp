/// Methods on a lattice that is turned to the fibre.

#include "maille/deform/solve.hpp"
#include "maille/scene/fibre/fibre_lattice.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace maille::deform {
namespace {

Scene bent_box(const std::string& lattice, const std::string& tissue = "muscle/vastus_lateralis") {
  return parse_scene(fmt::format("[specimen]\nshape = \"box\"\nlattice = \"{}\"\ncells = [8, 4, 4]\nspacing "
                                 "= \"1 mm\"\nmaterial = \"{}\"\n"
                                 "fibre = [0, 0, 1]\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby "
                                 "= [\"0.5 mm\", \"0.2 mm\", \"-1 mm\"]\n"
                                 "[limits]\nfrom = \"taut\"\n[relaxation]\ntolerance = 1e-7\n",
                                 lattice, tissue));
}

} // namespace

// Oracle: the lattice along the axes, which after a quarter turn has the same cells, nodes and links.
TEST(FibreLatticeOracle, AQuarterTurnChangesNoAnswer) {
  const Scene grid = bent_box("grid"), turned = bent_box("fibre");
  ASSERT_FALSE(turned.specimen.placement.is_identity());
  const double move = grid.largest_prescribed();
  for (const char* method : {"limits", "relaxed", "coupled"}) {
    const Displacement expected = solve(grid, method).displacement,
                       found = solve(turned, method).displacement;
    double worst = 0;
    for (std::int64_t node = 0; node < grid.specimen.grid.n_nodes(); ++node) {
      // x, y, z of the turned lattice are z, y, -x of the world; its nodes count x from the other end.
      const Index3 at = grid.specimen.grid.node_at(node);
      const std::int64_t there = turned.specimen.grid.node({at[2], at[1], 8 - at[0]});
      worst = std::max({worst, std::abs(found(0, there) - expected(2, node)),
                        std::abs(found(1, there) - expected(1, node)),
                        std::abs(found(2, there) + expected(0, node))});
    }
    EXPECT_LT(worst, 1e-5 * move) << method; // what the relaxers settle to
  }
}

// Analytic: a body that is moved as a whole moves as a whole, stairs or not.
TEST(FibreLatticeAnalytic, AShiftIsAShift) {
  const Scene scene = parse_scene(
      "[specimen]\nshape = \"ellipsoid\"\nlattice = \"fibre\"\ncells = [16, 8, 8]\nspacing = \"1 mm\"\n"
      "material = \"muscle/soleus\"\nfibre = { angle = \"33 deg\", plane = \"xy\" }\n"
      "[[move]]\nwhere = \"x-\"\nby = [\"1 mm\", \"2 mm\", \"3 mm\"]\n[[move]]\nwhere = \"x+\"\nby = [\"1 "
      "mm\", \"2 mm\", \"3 mm\"]\n"
      "[limits]\nfrom = \"given\"\nstretch = 1\ncompress = 1\nshear = 0\n");
  const Answer answer = solve(scene, "limits");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  const Specimen& body = scene.specimen;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    if (!body.is_node(body.grid.node_at(node)))
      continue;
    for (std::size_t r = 0; r < 3; ++r) {
      double world = 0;
      for (std::size_t c = 0; c < 3; ++c)
        world += body.placement.direction[r][c] * answer.displacement(static_cast<int>(c), node);
      EXPECT_NEAR(world, 1e-3 * static_cast<double>(r + 1), 1e-9);
    }
  }
}

} // namespace maille::deform
