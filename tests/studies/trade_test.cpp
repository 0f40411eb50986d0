// Lattices and what is carried between them, and a trade of a small scene.

#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"
#include "trade/trade.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

std::string scene_text(const std::string& shape, const std::string& cells,
                       const std::string& where = "\"x+\"") {
  const std::string zeros = std::array{"", ", 0", ", 0, 0"}[std::size_t(std::ranges::count(cells, ','))];
  return fmt::format("[specimen]\nshape = \"{}\"\ncells = {}\nspacing = \"1 mm\"\nmaterial = {}\n"
                     "{}[[move]]\nwhere = {}\nby = [\"0.5 mm\"{}]\n",
                     shape, cells, test::soft, test::hold_text(), where, zeros);
}

/// A cube whose handle is a node that coarser lattices lack.
const std::string poked = scene_text(
    "box", "[8, 8, 8]", "{ box = [[\"7 mm\", \"3 mm\", \"3 mm\"], [\"7 mm\", \"3 mm\", \"3 mm\"]] }");

constexpr std::array<Vec3, 3> gradient{{{0.01, -0.02, 0.005}, {0.003, 0.04, 0.02}, {-0.01, 0.006, 0.03}}};

/// The largest difference from the linear field after it went from one lattice of a body to another.
double error_of_linear_field(Lattices& lattices, int from, int to) {
  const Scene &a = *lattices.at(from).scene, &b = *lattices.at(to).scene;
  const Vec3 shift{1e-3, -2e-3, 5e-4};
  const Displacement truth = test::affine_displacement<Displacement>(b, gradient, shift);
  const Displacement carried =
      between_lattices(a, test::affine_displacement<Displacement>(a, gradient, shift), b);
  double largest = 0;
  for (std::int64_t node = 0; node < b.specimen.grid.n_nodes(); ++node)
    for (int c = 0; c < b.dimension(); ++c)
      largest = std::max(largest, b.specimen.is_node(b.specimen.grid.node_at(node))
                                      ? std::abs(carried(c, node) - truth(c, node))
                                      : std::abs(carried(c, node)));
  return largest;
}

// Analytic: (multi)linear interpolation and its continuation reproduce linear fields, to rounding of values
// of 1e-3 m.
TEST(BetweenLatticesAnalytic, LinearFieldsAreCarriedExactly) {
  for (const auto& [shape, cells] : {std::pair{"box", "[7]"},
                                     {"box", "[9, 5]"},
                                     {"box", "[9, 6, 5]"},
                                     {"ellipsoid", "[12, 9, 10]"},
                                     {"ellipsoid", "[13, 11]"}}) {
    Lattices lattices(scene_text(shape, cells), "body.toml");
    for (const auto& [from, to] : {std::pair{-1, 0}, {-2, 0}, {0, -1}, {1, 0}, {0, 1}, {-2, 1}})
      EXPECT_LT(error_of_linear_field(lattices, from, to), 1e-17 * 1e2) << shape << cells << from << to;
  }
}

// Analytic: a bilinear field on one cell of 2 mm, u = x y, at the middle of the cell and of its lower edges.
TEST(BetweenLatticesAnalytic, MiddlesTakeTheMeanOfCorners) {
  Lattices lattices(scene_text("box", "[2, 2]"), "body.toml");
  const Scene &coarse = *lattices.at(-1).scene, &fine = lattices.scene();
  ASSERT_EQ(coarse.specimen.grid.n_cells(), 1);
  Displacement u(coarse.specimen.grid);
  u(0, 3) = 4e-6;
  const Displacement carried = between_lattices(coarse, u, fine);
  EXPECT_DOUBLE_EQ(carried(0, fine.specimen.grid.node({1, 1, 0})), 1e-6);
  EXPECT_DOUBLE_EQ(carried(0, fine.specimen.grid.node({2, 1, 0})), 2e-6);
  EXPECT_EQ(carried(0, fine.specimen.grid.node({1, 0, 0})), 0);
  EXPECT_EQ(carried(0, fine.specimen.grid.node({2, 2, 0})), 4e-6) << "common nodes keep their bits";
}

// Contract: what Lattices promises of coarser and finer lattices.
TEST(LatticesContract, CoarserOnesKeepTheExtentAndFinerOnesTheBody) {
  Lattices lattices(scene_text("box", "[9, 4, 1]"), "body.toml");
  const Scene& coarse = *lattices.at(-1).scene;
  EXPECT_EQ(coarse.specimen.grid.cells(), (Index3{5, 2, 1}));
  const Vec3 extent{9e-3, 4e-3, 1e-3};
  for (std::size_t a = 0; a < 3; ++a)
    EXPECT_DOUBLE_EQ(coarse.specimen.grid.cells()[a] * coarse.specimen.grid.spacing()[a], extent[a]);
  EXPECT_EQ(lattices.at(1).scene->specimen.n_matter_cells(), 8 * 36);
  EXPECT_EQ(lattices.at(0).scene.get(), &lattices.scene());
  Lattices single(scene_text("box", "[1, 1, 1]"), "cell.toml");
  EXPECT_FALSE(single.at(-1).scene);
  EXPECT_TRUE(test::has(single.at(-1).why_not, "no coarser"));
}

TEST(LatticesContract, ARegionWithoutNodesIsAReason) {
  Lattices lattices(poked, "poked.toml");
  EXPECT_FALSE(lattices.at(-1).scene);
  EXPECT_TRUE(test::has(lattices.at(-1).why_not, "move[1].where"));
  EXPECT_TRUE(lattices.at(1).scene);
}

TradeSettings small_trade() {
  TradeSettings settings;
  settings.methods = {"limits", "relaxed", "coupled", "fem_q1"};
  settings.halvings = {0, -1, -3};
  settings.tolerances = {1e-2, 1e-4};
  settings.reference_seconds = 5;
  settings.repetitions = 2;
  return settings;
}

// Contract: rows, and the wish for more repetitions; errors against quadratic elements, so coupled is
// nearer than limits.
TEST(TradeContract, EveryWayIsARow) {
  Lattices lattices(
      scene_text("box", "[6, 4, 4]", "{ box = [[\"6 mm\", 0, 0], [\"6 mm\", \"3 mm\", \"4 mm\"]] }"),
      "box.toml");
  const Trade trade = measure_trade(lattices, small_trade(), {});
  ASSERT_TRUE(trade.is_whole) << trade.reference_message;
  EXPECT_FALSE(trade.any_failed());
  // limits 3, relaxed and coupled 2 tolerances each, linear elements by a factor, which knows none
  ASSERT_EQ(trade.rows.size(), 3u + 6u + 6u + 3u);
  double best_of_limits = 1, best_of_coupled = 1;
  for (const TradeRow& row : trade.rows) {
    ASSERT_EQ(row.status, Status::done) << row.way.method << row.message;
    EXPECT_EQ(row.repetitions, 2);
    EXPECT_GT(row.seconds.total(), 0);
    EXPECT_LE(row.seconds.total(), 2 * row.wall_seconds);
    ASSERT_TRUE(row.error);
    ASSERT_TRUE(row.predicted.error && row.predicted.seconds);
    double& best = row.way.method == "limits" ? best_of_limits : best_of_coupled;
    if (row.way.method == "limits" || row.way.method == "coupled")
      best = std::min(best, row.error->relative_l2);
  }
  EXPECT_LT(best_of_coupled, 0.5 * best_of_limits);
  const auto out = json(lattices.scene(), trade);
  EXPECT_EQ(out["rows"].size(), trade.rows.size());
  EXPECT_GT(out["reference_error"]["relative_l2"].get<double>(), 0);
}

// Contract: an impossible lattice is a row that says why.
TEST(TradeContract, AnImpossibleSpacingIsARowThatSaysWhy) {
  Lattices lattices(poked, "poked.toml");
  TradeSettings settings = small_trade();
  settings.methods = {"limits"};
  settings.halvings = {-1, 0};
  settings.reference = "fem_q1";
  const Trade trade = measure_trade(lattices, settings, {});
  ASSERT_EQ(trade.rows.size(), 2u);
  EXPECT_EQ(trade.rows[0].status, Status::refused);
  EXPECT_TRUE(test::has(trade.rows[0].message, "move[1].where"));
  EXPECT_FALSE(trade.any_failed()) << "that a spacing does not exist is a result";
}

} // namespace
} // namespace maille::studies
