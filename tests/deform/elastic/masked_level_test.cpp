/// The parts of `coupled` on bodies of any shape: operator, coarser grids, operators on them.

#include "elastic/masked/masked_level.hpp"
#include "maille/deform/solve.hpp"
#include "support/bodies/carved.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

#include <Eigen/Core>

namespace maille::deform {
namespace {

/// A field of the level from one number for every component of every node.
template<class Value>
AlignedArray<float> field_of(const Scene& scene, const MaskedLevel& level, const Value& value) {
  AlignedArray<float> field = level.field();
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (scene.specimen.is_node(grid.node_at(node)))
      for (int c = 0; c < 3; ++c)
        field[std::size_t(c * level.component_stride() + level.rows().slot(grid.node_at(node)))] =
            float(value(c, node));
  return field;
}

void expect_forces_of_general_operator(const Scene& scene) {
  const Grid& grid = scene.specimen.grid;
  const LatticeElasticity elasticity(scene);
  ThreadTeam team(1);
  const MaskedLevel level(scene, elasticity, scene.prescribed, team);
  Displacement u(grid), forces(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (int c = 0; c < 3; ++c)
      u(c, node) = std::sin(1.7 * double(node) + c);
  elasticity.apply(u, forces, team);
  const auto scale = [&](int c) { return level.matter().scale()[std::size_t(c)]; };
  const AlignedArray<float> v =
      field_of(scene, level, [&](int c, std::int64_t node) { return u(c, node) * scale(c); });
  const AlignedArray<float> expected = field_of(scene, level, [&](int c, std::int64_t node) {
    return forces(c, node) / (level.matter().unit() * scale(c));
  });
  AlignedArray<float> found = level.field();
  level.apply(v.data(), found.data(), team);
  float largest = 0;
  for (const float force : expected.all())
    largest = std::max(largest, std::abs(force));
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(found[i], expected[i], 1e-6f * largest) << i;
}

TEST(MaskedLevelOracle, ForcesAreThoseOfTheGeneralOperator) {
  for (const Index3& cells : {Index3{9, 7, 6}, {8, 5, 11}, {1, 1, 1}, {17, 2, 3}}) {
    SCOPED_TRACE(testing::Message() << cells[0] << ' ' << cells[1] << ' ' << cells[2]);
    expect_forces_of_general_operator(test::carved_body(cells, test::Fibres::none));
    expect_forces_of_general_operator(test::carved_body(cells, test::Fibres::slanted));
    expect_forces_of_general_operator(test::carved_body(cells, test::Fibres::turning));
  }
  expect_forces_of_general_operator(
      test::carved_body({12, 11, 10}, test::Fibres::turning)); // too many kinds for a table
}

Eigen::MatrixXd dense(const Weights& P, std::int32_t n_columns) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * P.n_rows(), 3 * n_columns);
  for (std::size_t row = 0; row < std::size_t(P.n_rows()); ++row)
    for (auto i = std::size_t(P.first[row]); i < std::size_t(P.first[row + 1]); ++i)
      for (int c = 0; c < 3; ++c)
        matrix(static_cast<Eigen::Index>(3 * row) + c, 3 * P.column[i] + c) = double{P.weight[i]};
  return matrix;
}

Eigen::MatrixXd dense(const BlockMatrix& A) {
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * A.n_rows(), 3 * A.n_rows());
  for (std::size_t row = 0; row < std::size_t(A.n_rows()); ++row)
    for (auto i = std::size_t(A.first[row]); i < std::size_t(A.first[row + 1]); ++i)
      for (int e = 0; e < 9; ++e)
        matrix(static_cast<Eigen::Index>(3 * row) + e % 3, 3 * A.column[i] + e / 3) =
            double{A.blocks[9 * i + std::size_t(e)]};
  return matrix;
}

/// By unit displacements of the slots that may move.
Eigen::MatrixXd dense(const MaskedLevel& level) {
  ThreadTeam team(1);
  const Eigen::Index n = level.rows().n_slots();
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  AlignedArray<float> u = level.field(), forces = level.field();
  const auto place = [&](Eigen::Index i) { return std::size_t(i % 3 * level.component_stride() + i / 3); };
  for (Eigen::Index j = 0; j < 3 * n; ++j) {
    if (level.inverse()[place(j)] == 0)
      continue;
    u[place(j)] = 1;
    level.apply(u.data(), forces.data(), team);
    u[place(j)] = 0;
    for (Eigen::Index i = 0; i < 3 * n; ++i)
      matrix(i, j) = level.inverse()[place(i)] > 0 ? double{forces[place(i)]} : 0;
  }
  return matrix;
}

/// Planes that one slab begins and another ends, slabs of one layer, springs to the ground.
TEST(MaskedLevelOracle, PassesOverPlanesAreThoseOverWholeFields) {
  for (const int layers : {1, 4, 5, 13})
    for (const bool has_springs : {false, true}) {
      SCOPED_TRACE(testing::Message() << layers << (has_springs ? " with springs" : ""));
      Scene scene = test::carved_body({11, 6, layers}, test::Fibres::slanted);
      if (has_springs)
        scene.springs.push_back({0, 0, false, 1e7, {0.6, 0.8, 0}});
      const LatticeElasticity elasticity(scene);
      ThreadTeam team(2);
      MaskedLevel level(scene, elasticity, scene.prescribed, team);
      AlignedArray<float> u = level.field(), product = level.field();
      const float* const inverse = level.inverse();
      for (std::size_t i = 0; i < std::size_t(3 * level.component_stride()); ++i)
        if (inverse[i] > 0) {
          level.u[i] = u[i] = std::sin(1.7F * float(i));
          level.f[i] = std::cos(0.3F * float(i));
        }
      level.apply(u.data(), product.data(), team);
      double u_f = 0, p_Ap = 0;
      const float weight = 0.4F;
      level.find_residual(team);
      for (std::size_t i = 0; i < u.size() - 16; ++i)
        ASSERT_FLOAT_EQ(level.r[i], inverse[i] > 0 ? level.f[i] - product[i] : 0) << i;
      const double found_p_Ap = level.apply_and_dot(u.data(), level.r.data(), team),
                   found_u_f = level.relax_and_dot(weight, team);
      for (std::size_t i = 0; i < u.size() - 16; ++i) {
        const float next = u[i] + weight * inverse[i] * (level.f[i] - product[i]);
        ASSERT_NEAR(level.u[i], next, 1e-5F) << i;
        u_f += double{next} * double{level.f[i]};
        p_Ap += inverse[i] > 0 ? double{u[i]} * double{product[i]} : 0;
      }
      EXPECT_NEAR(found_u_f, u_f, 1e-5 * std::abs(u_f) + 1e-5);
      EXPECT_NEAR(found_p_Ap, p_Ap, 1e-5 * std::abs(p_Ap));
    }
}

TEST(MaskedGalerkinOracle, CoarseOperatorsAreDenseProducts) {
  for (const Joining joining : {Joining::faces, Joining::places})
    for (const auto fibres : {test::Fibres::none, test::Fibres::turning}) {
      const Scene scene = test::carved_body({7, 5, 6}, fibres);
      const LatticeElasticity elasticity(scene);
      if (fibres == test::Fibres::turning) {
        ASSERT_GT(elasticity.kinds().size(), 64U); // more than products are remembered of
      }
      ThreadTeam team(2);
      const MaskedLevel level(scene, elasticity, scene.prescribed, team);
      const CellComplex fine = level.matter().complex(team);
      const Coarsened once = coarsen(fine, joining, team), twice = coarsen(once.complex, joining, team);
      const CoarseOperator A = galerkin_product(level, fine, once, false, team),
                           B = galerkin_product(A, once.complex, twice,
                                                twice.interpolation.transposed(twice.complex.n_vertices),
                                                team);
      const Eigen::MatrixXd P = dense(once.interpolation, once.complex.n_vertices),
                            Q = dense(twice.interpolation, twice.complex.n_vertices);
      const Eigen::MatrixXd of_once = P.transpose() * dense(level) * P,
                            of_twice = Q.transpose() * of_once * Q;
      EXPECT_LE((dense(A.blocks()) - of_once).cwiseAbs().maxCoeff(), 2e-6 * of_once.maxCoeff());
      EXPECT_LE((dense(B.blocks()) - of_twice).cwiseAbs().maxCoeff(), 2e-6 * of_twice.maxCoeff());
    }
}

TEST(CellComplexAnalytic, LinearFunctionsAreInterpolatedExactly) {
  const Scene scene = test::carved_body({9, 8, 7}, test::Fibres::none);
  const LatticeElasticity elasticity(scene);
  ThreadTeam team(2);
  const MaskedLevel level(scene, elasticity, scene.prescribed, team);
  const CellComplex fine = level.matter().complex(team);
  const auto positions = [](const CellComplex& complex, double spacing) {
    Eigen::MatrixXd place = Eigen::MatrixXd::Zero(complex.n_vertices, 4); // 1 x y z
    for (const ComplexCell& cell : complex.cells)
      for (int k = 0; k < 8; ++k)
        place.row(cell.vertex[k]) << 1, spacing * (cell.at[0] + (k & 1)),
            spacing * (cell.at[1] + (k >> 1 & 1)), spacing * (cell.at[2] + (k >> 2));
    return place;
  };
  for (const Joining joining : {Joining::faces, Joining::places}) {
    const Coarsened coarse = coarsen(fine, joining, team);
    const Eigen::MatrixXd of_coarse = positions(coarse.complex, 2);
    const Eigen::MatrixXd of_fine = positions(fine, 1);
    for (Eigen::Index v = 0; v < of_fine.rows(); ++v) {
      Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(4);
      const Weights& P = coarse.interpolation;
      for (auto i = std::size_t(P.first[std::size_t(v)]); i < std::size_t(P.first[std::size_t(v) + 1]); ++i)
        sum += double{P.weight[i]} * of_coarse.row(P.column[i]);
      EXPECT_LE((sum - of_fine.row(v)).cwiseAbs().maxCoeff(), 1e-5) << v; // slots without matter: 0 = 0
    }
  }
}

TEST(CellComplexContract, AnyNumberOfThreadsCoarsensAlike) {
  const Scene scene = test::carved_body({13, 14, 31}, test::Fibres::none);
  const LatticeElasticity elasticity(scene);
  ThreadTeam one(1), three(3);
  const MaskedLevel level(scene, elasticity, scene.prescribed, one);
  for (const Joining joining : {Joining::faces, Joining::places}) {
    const Coarsened a = coarsen(level.matter().complex(one), joining, one),
                    b = coarsen(level.matter().complex(three), joining, three);
    EXPECT_EQ(a.cell_of, b.cell_of);
    EXPECT_EQ(a.place, b.place);
    EXPECT_EQ(a.is_hinge, b.is_hinge);
    EXPECT_EQ(a.interpolation.first, b.interpolation.first);
    EXPECT_EQ(a.interpolation.column, b.interpolation.column);
    EXPECT_EQ(a.interpolation.weight, b.interpolation.weight);
    ASSERT_EQ(a.complex.cells.size(), b.complex.cells.size());
    for (std::size_t i = 0; i < a.complex.cells.size(); ++i) {
      EXPECT_EQ(a.complex.cells[i].at, b.complex.cells[i].at);
      EXPECT_TRUE(std::ranges::equal(a.complex.cells[i].vertex, b.complex.cells[i].vertex));
    }
  }
}

TEST(CellComplexAnalytic, WhatHangsTogetherByAnEdgeOrACornerStaysApart) {
  // Boxes of 4 cells an axis have 27 coarse vertices; of 2 cells 8.
  const auto coarse_vertices = [](int contact, Joining joining) {
    const Scene scene = test::two_blocks(4, contact);
    const LatticeElasticity elasticity(scene);
    ThreadTeam team(2);
    const MaskedLevel level(scene, elasticity, scene.prescribed, team);
    return coarsen(level.matter().complex(team), joining, team).complex.n_vertices;
  };
  EXPECT_EQ(coarse_vertices(3, Joining::faces), 2 * 27 - 9); // joined by a face
  EXPECT_EQ(coarse_vertices(2, Joining::faces), 2 * 27);     // by an edge
  EXPECT_EQ(coarse_vertices(1, Joining::faces), 2 * 27);     // by a corner
  EXPECT_EQ(coarse_vertices(2, Joining::places), 2 * 27 - 3);
  EXPECT_EQ(coarse_vertices(1, Joining::places), 2 * 27 - 1);
}

} // namespace
} // namespace maille::deform
