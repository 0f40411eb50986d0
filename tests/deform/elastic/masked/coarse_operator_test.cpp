/// Operators of coarser grids by patterns of matter, against the general operator in float64 and plain loops.

#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_level.hpp"
#include "elastic/masked/slot_interpolation.hpp"
#include "support/bodies/carved.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"

namespace maille::deform {
namespace {

/// One number for every component of every vertex.
using Values = std::vector<double>;

/// A box of one material, or of two with a plane between them; one cell in `one_in` is missing, at random.
Scene porous_body(int materials, unsigned seed, unsigned one_in = 30) {
  const Index3 cells{15, 13, 18};
  Scene scene = test::box_scene(3, cells, {1e-3, 1.3e-3, 0.8e-3});
  scene.materials.assign(std::size_t(materials), scene.materials[0]);
  scene.materials.back().elasticity = ElasticConstants::isotropic(80e3, 0.4);
  std::mt19937 random(seed);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
    const int z = scene.specimen.grid.cell_at(cell)[2];
    const bool is_missing = z > 0 && z + 1 < cells[2] && random() % one_in == 0;
    scene.specimen.material_id.push_back(is_missing                ? no_material
                                         : z < 7 || materials == 1 ? std::uint8_t{0}
                                                                   : std::uint8_t{1});
  }
  test::hold_and_move_ends(scene);
  return scene;
}

/// The body's own grid and the coarser ones of it.
struct Grids {
  Grids(const Scene& of, ThreadTeam& team)
      : scene(of), elasticity(of), level(of, elasticity, of.prescribed, team),
        fine(level.matter().complex(team)), once(coarsen(fine, Joining::faces, team)),
        twice(coarsen(once.complex, Joining::faces, team)),
        A(galerkin_product(level, fine, once, true, team)),
        B(galerkin_product(A, once.complex, twice, twice.interpolation.transposed(twice.complex.n_vertices),
                           team)) {}
  const Scene& scene;
  LatticeElasticity elasticity;
  MaskedLevel level;
  CellComplex fine;
  Coarsened once, twice;
  CoarseOperator A, B;
};

Values interpolated(const Weights& P, const Values& coarse) {
  Values fine(3 * std::size_t(P.n_rows()));
  for (std::size_t row = 0; row < std::size_t(P.n_rows()); ++row)
    for (auto i = std::size_t(P.first[row]); i < std::size_t(P.first[row + 1]); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        fine[3 * row + c] += double{P.weight[i]} * coarse[3 * std::size_t(P.column[i]) + c];
  return fine;
}

Values summed(const Weights& P, const Values& fine, std::int32_t n_coarse) {
  Values coarse(3 * std::size_t(n_coarse));
  for (std::size_t row = 0; row < std::size_t(P.n_rows()); ++row)
    for (auto i = std::size_t(P.first[row]); i < std::size_t(P.first[row + 1]); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        coarse[3 * std::size_t(P.column[i]) + c] += double{P.weight[i]} * fine[3 * row + c];
  return coarse;
}

/// Of slots, by the general operator, where components may move.
Values forces_of_slots(const Grids& of, const Values& u) {
  const Grid& grid = of.scene.specimen.grid;
  Displacement moved(grid), forces(grid);
  const auto for_each_free = [&](const auto& visit) {
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      for (std::size_t c = 0; c < 3 && of.scene.specimen.is_node(grid.node_at(node)); ++c) {
        const std::int32_t slot = of.level.rows().slot(grid.node_at(node));
        if (of.level.inverse()[std::int64_t(c) * of.level.component_stride() + slot] > 0)
          visit(c, std::size_t(node), 3 * std::size_t(slot) + c);
      }
  };
  for_each_free([&](std::size_t c, std::size_t node, std::size_t at) {
    moved(c, node) = u[at] / of.level.matter().scale()[c];
  });
  ThreadTeam alone(1);
  of.elasticity.apply(moved, forces, alone);
  Values result(u.size());
  for_each_free([&](std::size_t c, std::size_t node, std::size_t at) {
    result[at] = forces(c, node) / (of.level.matter().unit() * of.level.matter().scale()[c]);
  });
  return result;
}

Values random_values(std::int32_t n_vertices, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(-1, 1);
  Values values(3 * std::size_t(n_vertices));
  for (double& entry : values)
    entry = double{value(random)};
  return values;
}

/// Four numbers a vertex.
AlignedArray<float> product(const CoarseOperator& A, const Values& u, ThreadTeam& team) {
  const std::size_t n = u.size() / 3;
  AlignedArray<float> from(block_stride * n + 16), to(block_stride * n + 16);
  for (std::size_t i = 0; i < u.size(); ++i)
    from[block_stride * (i / 3) + i % 3] = float(u[i]);
  A.apply(from.data(), to.data(), team);
  return to;
}

void expect_values(const AlignedArray<float>& found, const Values& expected, double rounding) {
  double largest = 0;
  for (const double value : expected)
    largest = std::max(largest, std::abs(value));
  ASSERT_GT(largest, 0);
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(double{found[block_stride * (i / 3) + i % 3]}, expected[i], rounding * largest) << i;
}

TEST(CoarseOperatorOracle, PatternsAreProductsOfTheGeneralOperator) {
  for (const int materials : {1, 2}) {
    SCOPED_TRACE(materials);
    const Scene scene = porous_body(materials, 11);
    ThreadTeam team(2);
    const Grids of(scene, team);
    ASSERT_TRUE(of.A.has_pieces());
    ASSERT_FALSE(of.A.blocks().column.empty()); // hinges, and what is fixed
    const std::int32_t n = of.once.complex.n_vertices;
    const Values u = random_values(n, 3);
    const Values expected =
        summed(of.once.interpolation, forces_of_slots(of, interpolated(of.once.interpolation, u)), n);
    for (const std::int64_t target : test::vector_targets()) {
      SCOPED_TRACE(target);
      const test::ForcedVectors forced(target);
      expect_values(product(of.A, u, team), expected, 2e-6);
    }
    const std::int32_t m = of.twice.complex.n_vertices;
    const Values v = random_values(m, 4), once = interpolated(of.twice.interpolation, v);
    const Values of_twice = summed(
        of.twice.interpolation,
        summed(of.once.interpolation, forces_of_slots(of, interpolated(of.once.interpolation, once)), n), m);
    expect_values(product(of.B, v, team), of_twice, 2e-6);
    AlignedArray<float> diagonal(block_stride * std::size_t(n) + 16);
    of.A.copy_diagonal(diagonal, team);
    for (std::size_t i = 0; i < u.size(); i += 97) {
      Values unit(u.size());
      unit[i] = 1;
      const std::size_t at = block_stride * (i / 3) + i % 3;
      EXPECT_NEAR(product(of.A, unit, team)[at], diagonal[at], 1e-6F * std::abs(diagonal[at])) << i;
    }
  }
}

TEST(CoarseOperatorContract, BitsAreTheSameForAnyNumberOfThreads) {
  const Scene scene = porous_body(2, 12);
  ThreadTeam one(1), four(4);
  const Grids of_one(scene, one), of_four(scene, four);
  ASSERT_TRUE(of_one.A.has_pieces());
  const Values u = random_values(of_one.A.n_rows(), 5), v = random_values(of_one.B.n_rows(), 6);
  EXPECT_TRUE(std::ranges::equal(product(of_one.A, u, one).all(), product(of_four.A, u, four).all()));
  EXPECT_TRUE(std::ranges::equal(product(of_one.B, v, one).all(), product(of_four.B, v, four).all()));
}

/// Hinges, nodes within pieces and at their corners, and slots without matter.
TEST(SlotInterpolationOracle, IsThatOfWeights) {
  const Scene scene = porous_body(1, 14, 3);
  ThreadTeam team(1);
  const Grids of(scene, team);
  Coarsened taken = of.once;
  const SlotInterpolation P(taken);
  const auto& pieces = of.A.pieces().pieces;
  ASSERT_GT(std::ranges::count(of.once.is_hinge, 1), 3);
  const std::int32_t n = of.once.complex.n_vertices, slots = of.level.rows().n_slots();
  const std::int64_t stride = of.level.component_stride();
  const Values coarse = random_values(n, 8), fine = random_values(slots, 9);
  const Values expected = interpolated(of.once.interpolation, coarse);
  const Values expected_sums = summed(of.once.interpolation, fine, n);
  std::vector<float> u(block_stride * std::size_t(n)), of_fine(3 * std::size_t(stride));
  for (std::size_t i = 0; i < coarse.size(); ++i)
    u[block_stride * (i / 3) + i % 3] = float(coarse[i]);
  const auto place = [&](std::size_t i) { return i % 3 * std::size_t(stride) + i / 3; };
  for (std::size_t i = 0; i < fine.size(); ++i)
    of_fine[place(i)] = float(fine[i]);
  for (const std::int64_t target : test::vector_targets()) {
    SCOPED_TRACE(target);
    const test::ForcedVectors forced(target);
    std::vector<float> out = of_fine;
    P.interpolate(pieces, 0, slots, u.data(), of.level.inverse(), stride, out.data());
    for (std::size_t i = 0; i < fine.size(); ++i) {
      const double change = of.level.inverse()[place(i)] > 0 ? expected[i] : 0;
      ASSERT_NEAR(double{out[place(i)]}, fine[i] + change, 1e-6) << i;
    }
    AlignedArray<float> sums(u.size());
    P.add_up(pieces, 0, slots, of_fine.data(), stride, sums.data());
    for (std::size_t i = 0; i < expected_sums.size(); ++i)
      ASSERT_NEAR(double{sums[block_stride * (i / 3) + i % 3]}, expected_sums[i], 1e-5) << i;
  }
  BlockMatrix S; // of every seventh slot
  S.first.push_back(0);
  for (std::int32_t slot = 0; slot < slots; ++slot) {
    if (slot % 7 == 0)
      S.column.push_back(slot);
    S.first.push_back(static_cast<std::int32_t>(S.column.size()));
  }
  const Values rows = interpolated(P.rows_of(S, pieces), coarse);
  for (std::size_t i = 0; i < rows.size(); ++i)
    ASSERT_NEAR(rows[i], i / 3 % 7 == 0 ? expected[i] : 0, 1e-6) << i;
}

TEST(LatticeElasticityWindowsContract, ForcesHaveTheBitsOfTheWhole) {
  for (const int layers : {1, 7, 8, 9, 21}) {
    SCOPED_TRACE(layers);
    const Scene scene = test::carved_body({5, 4, layers}, test::Fibres::slanted);
    const Grid& grid = scene.specimen.grid;
    LatticeElasticity elasticity(scene);
    NodalSpring spring;
    spring.node = grid.n_nodes() - 3;
    spring.stiffness(0, 0) = spring.stiffness(1, 1) = 7;
    elasticity.set_springs({spring});
    Displacement u(grid), forces(grid);
    for (std::size_t i = 0; i < u.values().size(); ++i)
      u.values()[i] = std::sin(1.7 * double(i));
    ThreadTeam one(1), two(2);
    elasticity.apply(u, forces, one);
    std::int64_t next = 0;
    elasticity.for_each_window(u, two, {0, grid.nodes()[2]}, [&](const LatticeElasticity::Window& window) {
      EXPECT_EQ(window.first_node, next);
      next += window.n_nodes;
      for (std::size_t c = 0; c < 3; ++c)
        for (std::int64_t i = 0; i < window.n_nodes; ++i)
          EXPECT_EQ(window.forces[c][i], forces(c, std::size_t(window.first_node + i)));
    });
    EXPECT_EQ(next, grid.n_nodes());
  }
}

/// @returns the forces of all windows, one after another
std::vector<double> forces_of_planes(const LatticeElasticity& elasticity, const Displacement& u,
                                     const Grid& grid, ThreadTeam& team) {
  std::vector<double> forces(u.values().size());
  const auto put = [&](int first, int end, const std::array<double*, 3>& to) {
    const std::int64_t begin = grid.node({0, 0, first}), n = (end - first) * grid.stride(2);
    for (std::size_t c = 0; c < 3; ++c)
      std::ranges::copy(u.component(c).subspan(std::size_t(begin), std::size_t(n)), to[c]);
    return std::any_of(to[0], to[0] + n, [](double value) { return value != 0; });
  };
  elasticity.for_each_window(put, team, {0, grid.nodes()[2]}, [&](const LatticeElasticity::Window& window) {
    for (std::size_t c = 0; c < 3; ++c)
      std::copy_n(window.forces[c], window.n_nodes,
                  forces.data() + c * u.n_nodes() + std::size_t(window.first_node));
  });
  return forces;
}

// Planes whose displacements are only there for a while, and planes at rest, which are left out.
TEST(LatticeElasticityWindowsContract, ForcesOfPlanesHaveTheBitsOfTheWhole) {
  for (const int layers : {1, 7, 8, 9, 21}) {
    SCOPED_TRACE(layers);
    const Scene scene = test::carved_body({5, 4, layers}, test::Fibres::slanted);
    const Grid& grid = scene.specimen.grid;
    const LatticeElasticity elasticity(scene);
    Displacement u(grid), forces(grid);
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
      for (int c = 0; c < 3 && std::abs(grid.node_at(node)[2] - layers / 2) > 3; ++c)
        u(c, node) = std::sin(1.7 * double(3 * node + c + 1));
    ThreadTeam one(1), two(2);
    elasticity.apply(u, forces, one);
    EXPECT_TRUE(std::ranges::equal(forces_of_planes(elasticity, u, grid, two), forces.values()));
  }
}

} // namespace
} // namespace maille::deform
