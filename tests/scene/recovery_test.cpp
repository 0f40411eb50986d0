/// Strain and stress at nodes, recovered from those of cells.
#include "maille/scene/mechanics/recovery.hpp"

#include "support/bodies/scenes.hpp"
#include "support/dice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace maille {
namespace {

using Tensor = std::array<double, 6>;
/// Function of a place [cells] and the number of a material.
using Field = std::function<double(const Vec3& place, int material)>;

Scene solid(int dimension, const Index3& cells) {
  return test::box_scene(dimension, cells, {1e-3, 2e-3, 0.5e-3});
}

/// Where `holds` says what a cell is of.
Scene body(int dimension, const Index3& cells, const std::function<std::uint8_t(const Index3&)>& holds) {
  Scene scene = solid(dimension, cells);
  scene.materials.push_back(scene.materials[0]);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
    scene.specimen.material_id.push_back(holds(scene.specimen.grid.cell_at(cell)));
  return scene;
}

Vec3 place(const Index3& at, double shift) {
  return {at[0] + shift, at[1] + shift, at[2] + shift};
}

/// Cells whose stress is a field at their middles, a multiple of it for each component; strain is minus that.
CellFields cells_of(const Scene& scene, const Field& field) {
  const Specimen& specimen = scene.specimen;
  const auto n = static_cast<std::size_t>(specimen.grid.n_cells());
  CellFields cells{std::vector<Tensor>(n), std::vector<Tensor>(n), std::vector<double>(n)};
  for (std::size_t c = 0; c < n; ++c) {
    const auto cell = static_cast<std::int64_t>(c);
    for (std::size_t k = 0; k < 6 && specimen.is_matter(cell); ++k) {
      cells.stress[c][k] = static_cast<double>(k + 1) *
                           field(place(specimen.grid.cell_at(cell), 0.5), specimen.material(cell));
      cells.strain[c][k] = -cells.stress[c][k];
    }
  }
  return cells;
}

/// The largest difference from a field over all corners of the cells that count, over their components.
double worst(
    const Scene& scene, const RecoveredFields& found, const Field& field,
    const std::function<bool(const Index3&)>& counts = [](const Index3&) { return true; }) {
  const Grid& grid = scene.specimen.grid;
  double worst = 0;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    for (int corner = 0; corner < grid.corners_per_cell() && scene.specimen.is_matter(cell); ++corner) {
      const Index3 at = grid.node_at(grid.corner(grid.cell_at(cell), corner));
      const RecoveredFields::Values& values = found.at_corner(cell, corner);
      for (std::size_t k = 0; k < 6 && counts(at); ++k) {
        const double expected =
            static_cast<double>(k + 1) * field(place(at, 0), scene.specimen.material(cell));
        worst =
            std::max({worst, std::abs(values.stress[k] - expected), std::abs(values.strain[k] + expected)});
      }
    }
  return worst;
}

double recovered_worst(const Scene& scene, const Field& field) {
  return worst(scene, RecoveredFields(scene, cells_of(scene, field)), field);
}

double linear(const Vec3& x, int) {
  return 3 + 2 * x[0] - 1.5 * x[1] + 0.75 * x[2];
}

TEST(RecoveryAnalytic, LinearFieldsAreRecoveredOnFullBoxes) {
  EXPECT_LT(recovered_worst(solid(3, {5, 4, 3}), linear), 1e-11);
  EXPECT_LT(recovered_worst(solid(3, {2, 2, 2}), linear), 1e-11);
  EXPECT_LT(recovered_worst(solid(2, {5, 3, 1}),
                            [](const Vec3& x, int) {
                              return linear({x[0], x[1], 0}, 0);
                            }),
            1e-11);
  EXPECT_LT(recovered_worst(solid(1, {5, 1, 1}),
                            [](const Vec3& x, int) {
                              return linear({x[0], 0, 0}, 0);
                            }),
            1e-11);
}

// A ball with a notch, the stairs of its surface and all.
TEST(RecoveryAnalytic, LinearFieldsAreRecoveredOnMaskedBodies) {
  const Scene scene = body(3, {9, 9, 9}, [](const Index3& at) {
    const Vec3 x = place(at, -4);
    const bool is_notch = at[0] > 5 && at[1] > 4;
    return x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < 18.5 && !is_notch ? std::uint8_t{0} : no_material;
  });
  EXPECT_LT(recovered_worst(scene, linear), 1e-10);
}

// Truth: each layer has a linear field of its own, and a node between them one value of each.
TEST(RecoveryAnalytic, NothingIsSmearedAcrossMaterialsOrLabels) {
  const Field jump = [](const Vec3& x, int material) {
    return material == 1 ? 1e4 * linear(x, 0) : linear({x[1], x[2], x[0]}, 0);
  };
  Scene scene = body(3, {6, 5, 6}, [](const Index3& at) { return std::uint8_t(at[2] < 3 ? 0 : 1); });
  EXPECT_LT(recovered_worst(scene, jump), 1e-7);
  for (const std::uint8_t material : scene.specimen.material_id)
    scene.specimen.label.push_back(material == 0 ? 5 : 17);
  const CellFields cells = cells_of(scene, jump);
  std::ranges::fill(scene.specimen.material_id, 0); // labels alone tell them apart
  const RecoveredFields found(scene, cells);
  const std::int64_t below = scene.specimen.grid.cell({2, 2, 2}), above = scene.specimen.grid.cell({2, 2, 3});
  EXPECT_NEAR(found.at_corner(below, 4).stress[0], jump({2, 2, 3}, 0), 1e-10);
  EXPECT_NEAR(found.at_corner(above, 0).stress[0], jump({2, 2, 3}, 1), 1e-7);
}

// Two legs that are joined far below, with a gap of one cell: a patch does not reach across.
TEST(RecoveryAnalytic, PatchesDoNotLeapOverGaps) {
  const Scene scene = body(
      3, {7, 3, 9}, [](const Index3& at) { return at[0] == 3 && at[2] > 1 ? no_material : std::uint8_t{0}; });
  const Field sides = [](const Vec3& x, int) { return x[0] < 3.5 ? 1.0 : -7.0; };
  const RecoveredFields found(scene, cells_of(scene, sides));
  EXPECT_LT(worst(scene, found, sides, [](const Index3& at) { return at[2] > 4; }), 1e-11);
}

// Moments of outer cells are a thousand times smaller, so that much of rounding is left of values of 20.
TEST(RecoveryAnalytic, UniformFieldsStayUniformWhateverTheBody) {
  constexpr unsigned seed = 5;
  std::mt19937 random(seed);
  tests::Dice dice{random};
  for (const int dimension : {1, 2, 3}) {
    const Scene scene =
        body(dimension, {8, dimension > 1 ? 7 : 1, dimension > 2 ? 6 : 1}, [&](const Index3&) {
          const double what = dice.between(0, 1);
          return what < 0.4 ? no_material : std::uint8_t(what < 0.7 ? 0 : 1);
        });
    EXPECT_LT(recovered_worst(scene, [](const Vec3&, int material) { return material + 2.5; }), 1e-11)
        << seed;
  }
}

// Truth: what one layer of cells knows is constant across it.
TEST(RecoveryAnalytic, ThinBodiesKeepWhatTheyKnow) {
  const Field in_plane = [](const Vec3& x, int) { return linear({x[0], x[1], 0}, 0); };
  EXPECT_LT(recovered_worst(solid(3, {5, 4, 1}), in_plane), 1e-11);
  const Field along_row = [](const Vec3& x, int) { return linear({x[0], 0, 0}, 0); };
  EXPECT_LT(recovered_worst(solid(3, {4, 1, 1}), along_row), 1e-11);
  EXPECT_LT(recovered_worst(solid(3, {1, 1, 1}), [](const Vec3&, int) { return 4.0; }), 1e-13);
  // A stair of single cells, joined by edges alone.
  const Scene stair =
      body(2, {3, 3, 1}, [](const Index3& at) { return at[0] == at[1] ? std::uint8_t{0} : no_material; });
  EXPECT_TRUE(std::isfinite(recovered_worst(stair, linear)));
}

// Truth: the mode that fields of one value a cell have near incompressibility.
TEST(RecoveryAnalytic, CheckerboardsVanishInside) {
  const Scene scene = solid(3, {8, 8, 8});
  CellFields cells = cells_of(scene, [](const Vec3& x, int) {
    return (static_cast<int>(x[0]) + static_cast<int>(x[1]) + static_cast<int>(x[2])) % 2 == 0 ? 1.0 : -1.0;
  });
  const auto is_inside = [](const Index3& at) {
    return std::ranges::all_of(at, [](int i) { return i > 1 && i < 7; });
  };
  EXPECT_LT(worst(
                scene, RecoveredFields(scene, cells), [](const Vec3&, int) { return 0.0; }, is_inside),
            1e-12);
}

/// Root of the sum of squares of sigma_xx - truth over eighths of cells inside, raw and recovered.
std::pair<double, double> errors_of_wave(int cells) {
  Scene scene = test::box_scene(3, {cells, cells, cells}, {1.0 / cells, 1.0 / cells, 1.0 / cells});
  scene.materials[0].elasticity = ElasticConstants::isotropic(10, 0.25); // lambda = mu = 4
  const Grid& grid = scene.specimen.grid;
  Displacement u(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(grid.node_at(node));
    u(0, node) = std::sin(3 * x[0]) * std::cos(2 * x[1]) * std::exp(x[2]);
    u(1, node) = std::cos(x[0] + 2 * x[1] - x[2]);
    u(2, node) = std::sin(x[0]) * x[1] * std::cos(2 * x[2]);
  }
  const auto stress = [](const Vec3& x) {
    const double xx = 3 * std::cos(3 * x[0]) * std::cos(2 * x[1]) * std::exp(x[2]),
                 yy = -2 * std::sin(x[0] + 2 * x[1] - x[2]),
                 zz = -2 * std::sin(x[0]) * x[1] * std::sin(2 * x[2]);
    return 4 * (xx + yy + zz) + 8 * xx;
  };
  const CellFields fields = cell_fields(scene, u);
  const RecoveredFields recovered(scene, fields);
  double raw = 0, smooth = 0;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    if (!std::ranges::all_of(at, [&](int i) { return 5 * i >= cells && 5 * i < 4 * cells; }))
      continue;
    for (int part = 0; part < 8; ++part) {
      Vec3 x = scene.specimen.position(at), in_cell{};
      for (std::size_t a = 0; a < 3; ++a) {
        in_cell[a] = part >> a & 1 ? 0.75 : 0.25;
        x[a] += in_cell[a] / cells;
      }
      const double expected = stress(x), volume = 1.0 / (8.0 * cells * cells * cells);
      raw += volume * std::pow(fields.stress[static_cast<std::size_t>(cell)][0] - expected, 2);
      smooth += volume * std::pow(recovered.at(cell, in_cell).stress[0] - expected, 2);
    }
  }
  return {std::sqrt(raw), std::sqrt(smooth)};
}

// Truth: derivatives by hand.
TEST(RecoveryAnalytic, RecoveredStressConvergesOneOrderFaster) {
  const auto [raw_coarse, coarse] = errors_of_wave(10);
  const auto [raw_fine, fine] = errors_of_wave(20);
  EXPECT_NEAR(std::log2(raw_coarse / raw_fine), 1, 0.1);
  EXPECT_GT(std::log2(coarse / fine), 1.8);
  EXPECT_LT(2 * coarse, raw_coarse);
}

// Truth: stress of a quadratic displacement is linear, up to the surface.
TEST(RecoveryAnalytic, QuadraticDisplacementsGiveExactStress) {
  Scene scene = test::box_scene(3, {4, 5, 3});
  scene.materials[0].elasticity = ElasticConstants::isotropic(10, 0.25);
  Displacement u(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node));
    u(0, node) = x[0] * x[0] + x[1] * x[2];
    u(1, node) = x[0] * x[1] - x[1] * x[1];
    u(2, node) = 3 * x[0] * x[2];
  }
  const RecoveredFields found(scene, u);
  for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
    for (int corner = 0; corner < 8; ++corner) {
      const Index3 at =
          scene.specimen.grid.node_at(scene.specimen.grid.corner(scene.specimen.grid.cell_at(cell), corner));
      const Vec3 x = scene.specimen.position(at);
      const double xx = 2 * x[0], yy = x[0] - 2 * x[1], zz = 3 * x[0];
      EXPECT_NEAR(found.at_corner(cell, corner).stress[0], 4 * (xx + yy + zz) + 8 * xx, 1e-13);
      EXPECT_NEAR(found.at_corner(cell, corner).stress[3], 4 * (x[2] + x[1]), 1e-13);
    }
}

// Truth: the same body and field with its axes in another order.
TEST(RecoveryContract, AxesInAnotherOrderGiveTheSame) {
  constexpr unsigned seed = 11;
  std::mt19937 random(seed);
  tests::Dice dice{random};
  const Index3 cells{5, 6, 7};
  std::vector<double> value;
  std::vector<std::uint8_t> material;
  for (int i = 0; i < 5 * 6 * 7; ++i) {
    value.push_back(dice.between(-1, 1));
    material.push_back(dice.between(0, 1) < 0.35 ? no_material : std::uint8_t{0});
  }
  const auto number = [&](const Index3& at) {
    return static_cast<std::size_t>(at[0] + cells[0] * (at[1] + cells[1] * at[2]));
  };
  const auto unturned = [](const Index3& at) { return Index3{at[2], at[0], at[1]}; };
  const auto recover = [&](const Index3& size, const std::function<Index3(const Index3&)>& own) {
    Scene scene = body(3, size, [&](const Index3& at) { return material[number(own(at))]; });
    const auto field = [&](const Vec3& x, int) {
      return value[number(own({static_cast<int>(x[0]), static_cast<int>(x[1]), static_cast<int>(x[2])}))];
    };
    return std::pair(scene.specimen.grid, RecoveredFields(scene, cells_of(scene, field)));
  };
  const auto [grid, straight] = recover(cells, [](const Index3& at) { return at; });
  const auto [turned_grid, turned] = recover({cells[1], cells[2], cells[0]}, unturned);
  for (std::int64_t cell = 0; cell < turned_grid.n_cells(); ++cell) {
    const Index3 own = unturned(turned_grid.cell_at(cell));
    if (material[number(own)] == no_material)
      continue;
    for (int corner = 0; corner < 8; ++corner) { // bits turn as axes do
      const int own_corner = (corner >> 2 & 1) | (corner & 1) << 1 | (corner >> 1 & 1) << 2;
      EXPECT_NEAR(turned.at_corner(cell, corner).stress[0],
                  straight.at_corner(grid.cell(own), own_corner).stress[0], 1e-9)
          << seed;
    }
  }
}

TEST(RecoveryContract, NodesShowThePartOfMostCells) {
  const Scene scene =
      body(2, {4, 2, 1}, [](const Index3& at) { return std::uint8_t(at[0] < 2 && at[1] == 0 ? 1 : 0); });
  const RecoveredFields found(scene,
                              cells_of(scene, [](const Vec3&, int material) { return 1.0 + material; }));
  const RecoveredFields::Shown shown = found.at_nodes();
  const Grid& grid = scene.specimen.grid;
  EXPECT_NEAR(shown.stress[static_cast<std::size_t>(grid.node({2, 1, 0}))][0], 1, 1e-12) << "three of four";
  EXPECT_NEAR(shown.stress[static_cast<std::size_t>(grid.node({0, 0, 0}))][0], 2, 1e-12);
  EXPECT_NEAR(shown.stress[static_cast<std::size_t>(grid.node({1, 1, 0}))][0], 2, 1e-12)
      << "the first of two";
}

} // namespace
} // namespace maille
