// Fronts, lattices and what is carried between them, and a trade of a small scene.

#include "fit/fit.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/read_scene.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"
#include "trade/trade.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

using Indices = std::vector<std::size_t>;

// Analytic: by the definition, read off a sketch.
TEST(ParetoAnalytic, KeepsWhatNothingBeats) {
  const std::vector<CostAndError> points{{4, 1}, {1, 5}, {2, 5}, {3, 2}, {2, 3}, {5, 4}, {4, 0.5}};
  EXPECT_EQ(pareto_front(points), (Indices{1, 4, 3, 6}))
      << "{2, 5} costs more than {1, 5}, {4, 1} is less exact than "
         "{4, 0.5}, {5, 4} is worse than most";
}

TEST(ParetoAnalytic, PointsThatAreAlikeAreAllInIt) {
  EXPECT_EQ(pareto_front(std::vector<CostAndError>{{2, 2}, {1, 3}, {2, 2}, {2, 2.5}}), (Indices{1, 0, 2}));
}

TEST(ParetoAnalytic, WhatIsNotFiniteIsInNone) {
  const double infinity = std::numeric_limits<double>::infinity(),
               none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(
      pareto_front(std::vector<CostAndError>{{none, 1}, {1, none}, {infinity, 0}, {0, infinity}, {3, 3}}),
      Indices{4});
  EXPECT_TRUE(pareto_front({}).empty());
}

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

// Contract: rows, fronts, and the wish for more repetitions; errors against quadratic elements, so coupled is
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
  EXPECT_TRUE(
      test::has(table(lattices.scene(), trade, true), "limits at 2 times the spacing: move[1].where"));
  EXPECT_FALSE(trade.any_failed()) << "that a spacing does not exist is a result";
}

// Contract: the fronts are marked on settled rows with an error, and on no others.
TEST(TradeContract, FrontsAreOfSettledRows) {
  std::vector<TradeRow> rows(4);
  const std::array<std::array<double, 3>, 4> values{{{1, 10, 0.5}, {2, 5, 0.2}, {3, 1, 0.3}, {0.5, 1, 0.1}}};
  for (std::size_t i = 0; i < 4; ++i) {
    rows[i].seconds.solve = values[i][0];
    rows[i].bytes = static_cast<std::int64_t>(values[i][1]);
    rows[i].error = ErrorNorms{values[i][2], 0, 0};
  }
  rows[3].status = Status::budget_reached;
  mark_fronts(rows);
  const std::array<std::pair<bool, bool>, 4> expected{
      {{true, false}, {true, true}, {false, true}, {false, false}}};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(std::pair(rows[i].on_time_front, rows[i].on_memory_front), expected[i]) << i;
}

// The fit of limits and weights, against families whose best numbers are known.

const std::string tissue = "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n";

Scene bar(double pull) {
  return parse_scene("units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [8]\nspacing = 0.001\n" +
                     tissue + "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [" +
                     std::to_string(pull) + "]\n");
}

/// A sheet that is held at its lower edge and has a spot in its middle moved.
Scene sheet(double along, double across, const std::string& constants = tissue) {
  return parse_scene(
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [9, 7]\nspacing = 0.001\n" + constants +
      "[[hold]]\nwhere = \"y-\"\n[[move]]\nwhere = { box = [[0.004, 0.003], [0.005, 0.004]] }\nby = [" +
      std::to_string(along) + ", " + std::to_string(across) + "]\n");
}

FitCase answered(Scene scene, const std::vector<Material>& materials, std::string_view method) {
  Scene asked = scene;
  asked.materials = materials;
  asked.limits.from = LimitSource::material;
  Displacement reference = deform::solve(asked, method).displacement;
  return {std::move(scene), std::move(reference)};
}

double value_of(const Fit& fit, const std::string& name, const std::string& material = "specimen.material") {
  for (const FittedNumber& number : fit.numbers)
    if (number.name == name && number.material == material)
      return number.value;
  ADD_FAILURE() << "no number " << name;
  return 0;
}

// Oracle: data that limits made themselves. Every number decides some node, so all of them must come back.
TEST(FitOracle, FindsTheLimitsThatMadeTheData) {
  Material known = sheet(1e-3, 1e-3).materials[0];
  known.limits = NeighbourLimits{{1.3, 1.25, 1}, {0.8, 0.7, 1}, {{{0, 0.22, 0}, {0.18, 0, 0}, {}}}};
  const std::vector<FitCase> cases{answered(sheet(5e-4, 3e-4), {known}, "limits"),
                                   answered(sheet(3e-4, 5e-4), {known}, "limits")};
  const Fit found = fit(cases, {});
  EXPECT_EQ(found.status, Status::done);
  EXPECT_LT(mean_error(found.fitted), 1e-5);
  const double tolerance = 1e-4; // of slacks of 0.18 to 0.3; the search stops at 1e-8 of their logarithms
  EXPECT_NEAR(value_of(found, "stretch[x]"), 1.3, tolerance);
  EXPECT_NEAR(value_of(found, "stretch[y]"), 1.25, tolerance);
  EXPECT_NEAR(value_of(found, "compress[x]"), 0.8, tolerance);
  EXPECT_NEAR(value_of(found, "compress[y]"), 0.7, tolerance);
  EXPECT_NEAR(value_of(found, "shear[x][y]"), 0.22, tolerance);
  EXPECT_NEAR(value_of(found, "shear[y][x]"), 0.18, tolerance);
  for (const FittedNumber& number : found.numbers)
    EXPECT_TRUE(number.is_determined) << number.name;
}

/// The sheet, of another matter from the spot on.
Scene sheet_of_two(double along, double across) {
  Scene scene = sheet(along, across);
  scene.materials[0].name = "near";
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].name = "far";
  scene.materials[1].elasticity = ElasticConstants::isotropic(30e3, 0.3);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    scene.specimen.material_id.push_back(grid.cell_at(cell)[0] < 4 ? 0 : 1);
  return scene;
}

// Oracle: the same of two materials at once; and a scene that the fit has not seen is met as well.
TEST(FitOracle, FindsTheLimitsOfTwoMaterialsThatMadeTheData) {
  std::vector<Material> known = sheet_of_two(0, 1e-4).materials;
  known[0].limits = NeighbourLimits{{1.3, 1.25, 1}, {0.8, 0.7, 1}, {{{0, 0.22, 0}, {0.18, 0, 0}, {}}}};
  known[1].limits = NeighbourLimits{{1.12, 1.1, 1}, {0.91, 0.88, 1}, {{{0, 0.09, 0}, {0.08, 0, 0}, {}}}};
  const std::vector<FitCase> cases{answered(sheet_of_two(2.2e-4, 1.6e-4), known, "limits"),
                                   answered(sheet_of_two(-1.6e-4, -2.2e-4), known, "limits")};
  const Fit found = fit(cases, {});
  EXPECT_EQ(found.status, Status::done);
  ASSERT_EQ(found.materials.size(), 2u);
  EXPECT_EQ(found.materials[1].name, "far");
  EXPECT_LT(mean_error(found.fitted), 1e-4);
  EXPECT_LT(fit_error(answered(sheet_of_two(2e-4, -1.8e-4), known, "limits"), found.materials, "limits")
                .relative_l2,
            1e-3);
  const double tolerance = 2e-3; // of slacks of 0.08 to 0.3
  EXPECT_NEAR(value_of(found, "stretch[y]", "far"), 1.1, tolerance);
  EXPECT_NEAR(value_of(found, "shear[y][x]", "far"), 0.08, tolerance);
}

TEST(FitOracle, FindsTheWeightsOfTwoMaterialsThatMadeTheData) {
  std::vector<Material> known = sheet_of_two(0, 1e-4).materials;
  for (Material& material : known)
    material.limits = NeighbourLimits{{2, 2, 2}, {0, 0, 0}, {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}}};
  known[0].relaxed_weights = {0.4, 2.5, 1};
  known[1].relaxed_weights = {3, 0.6, 1};
  const std::vector<FitCase> cases{answered(sheet_of_two(5e-4, 3e-4), known, "relaxed"),
                                   answered(sheet_of_two(-3e-4, 5e-4), known, "relaxed")};
  const Fit found = fit(cases, {"relaxed"});
  EXPECT_LT(mean_error(found.fitted), 1e-4); // relaxed itself ends at 1e-4
  for (std::size_t m = 0; m < 2; ++m)
    for (std::size_t b = 0; b < 2; ++b)
      EXPECT_NEAR(found.materials[m].relaxed_weights[b], known[m].relaxed_weights[b],
                  2e-2 * known[m].relaxed_weights[b])
          << m << " " << b;
}

TEST(FitContract, AMaterialThatNothingWasFittedForIsRefused) {
  const FitCase one{sheet_of_two(0, 1e-4), Displacement(sheet_of_two(0, 1e-4).specimen.grid)};
  EXPECT_THROW(fit_error(one, std::vector<Material>{one.scene.materials[0]}, "limits"), std::runtime_error);
  FitCase other = one;
  other.scene.materials[0].elasticity = ElasticConstants::isotropic(1e3, 0.3);
  EXPECT_THROW(materials_of(std::vector<FitCase>{one, other}), std::runtime_error);
}

TEST(FitOracle, FindsTheWeightsThatMadeTheData) {
  Material known = sheet(1e-3, 1e-3).materials[0];
  known.limits = NeighbourLimits{{2, 2, 2}, {0, 0, 0}, {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}}}};
  known.relaxed_weights = {0.4, 2.5, 1};
  const Fit found = fit(std::vector<FitCase>{answered(sheet(5e-4, 3e-4), {known}, "relaxed")}, {"relaxed"});
  EXPECT_LT(mean_error(found.fitted), 1e-4); // relaxed itself ends at 1e-4
  EXPECT_NEAR(found.materials[0].relaxed_weights[0], 0.4, 0.4e-2);
  EXPECT_NEAR(found.materials[0].relaxed_weights[1], 2.5, 2.5e-2);
}

// Analytic: a bar whose links all stretch alike, moved by A and by A/2. A link must give A/n, or the larger
// move is cut back; a larger limit leaves more nodes behind. In the smaller move the half next to the handle
// then follows, at full slack.
TEST(FitAnalytic, ABarPulledTwiceIsTautAtTheLargerPull) {
  constexpr double A = 8e-4;
  constexpr int n = 8;
  std::vector<FitCase> cases;
  double expected = 0;
  for (const double pull : {A, A / 2}) {
    FitCase one{bar(pull), Displacement(bar(pull).specimen.grid)};
    double lost = 0, whole = 0;
    for (int i = 0; i <= n; ++i) {
      const double r = pull * i / n, u = std::max(0.0, pull - A / n * (n - i));
      one.reference(0, i) = r;
      if (i != 0 && i != n) {
        lost += (u - r) * (u - r);
        whole += r * r;
      }
    }
    expected += lost / whole / 2;
    cases.push_back(std::move(one));
  }
  const Fit found = fit(cases, {});
  ASSERT_EQ(found.status, Status::done);
  EXPECT_NEAR(value_of(found, "stretch[x]"), 1 + A / n / 1e-3, 1e-6);
  EXPECT_FALSE(found.numbers[1].is_determined) << "nothing is compressed";
  EXPECT_EQ(value_of(found, "compress[x]"), 0) << "open: it must not bind where another scene compresses";
  EXPECT_NEAR(mean_error(found.fitted), std::sqrt(expected), 1e-4);
  EXPECT_EQ(found.fitted[0].cut, 0);
  ASSERT_EQ(found.alone.size(), 2u);
  EXPECT_LT(found.alone[1], 1e-5) << "alone, it is the taut bar";
}

// Analytic: a strip that narrows as it is pulled. What it narrows by is what limits cannot do.
TEST(FitAnalytic, WhatNothingMovesIsOutOfReach) {
  const Scene scene = parse_scene(
      "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [4, 2]\nspacing = 0.001\n" + tissue +
      "[[hold]]\nwhere = \"x-\"\naxes = \"x\"\n[[move]]\nwhere = \"x+\"\naxes = \"x\"\n"
      "by = [4e-4, 0]\n");
  FitCase one{scene, Displacement(scene.specimen.grid)};
  double narrowed = 0, whole = 0;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const Index3 at = scene.specimen.grid.node_at(node);
    one.reference(0, node) = 1e-4 * at[0];
    one.reference(1, node) = -3e-5 * (at[1] - 1);
    if (at[0] == 0 || at[0] == 4)
      continue;
    narrowed += std::pow(one.reference(1, node), 2);
    whole += std::pow(one.reference(1, node), 2) + std::pow(one.reference(0, node), 2);
  }
  const Vec3 lost = unreachable(one);
  EXPECT_EQ(lost[0], 0);
  EXPECT_NEAR(lost[1], std::sqrt(narrowed / whole), 1e-12);
  const Fit found = fit(std::vector<FitCase>{one}, {});
  EXPECT_NEAR(found.fitted[0].relative_l2, lost[1], 1e-5) << "and what is in reach is reached";
}

TEST(FitContract, GivesTheSameBitsAndEndsWithTheBestSoFarWhenItIsAskedTo) {
  Material known = sheet(1e-3, 1e-3).materials[0];
  known.limits = NeighbourLimits{{1.3, 1.25, 1}, {0.8, 0.7, 1}, {{{0, 0.22, 0}, {0.18, 0, 0}, {}}}};
  const std::vector<FitCase> cases{answered(sheet(5e-4, 3e-4), {known}, "limits")};
  EXPECT_EQ(fit(cases, {}).materials[0].limits, fit(cases, {}).materials[0].limits);
  Control control;
  int polled = 0;
  control.stop_requested = [&] { return ++polled > 300; };
  const Fit found = fit(cases, {}, control);
  EXPECT_EQ(found.status, Status::interrupted);
  EXPECT_EQ(found.fitted.size(), 1u);
  EXPECT_EQ(found.fitted[0].cut, 0);
  EXPECT_EQ(fit(cases, {"limits", 20}).status, Status::budget_reached);
}

TEST(FitContract, ScenesThatMoveNothingAreRefused) {
  const FitCase one{bar(0), Displacement(bar(0).specimen.grid)};
  EXPECT_THROW(fit(std::vector<FitCase>{one}, {}), std::runtime_error);
}

} // namespace
} // namespace maille::studies
