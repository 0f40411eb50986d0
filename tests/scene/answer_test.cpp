#include "maille/base/csv.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/refined.hpp"
#include "maille/scene/scene.hpp"
#include "support/bodies/scenes.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

/// A chain of four nodes whose first is held and whose last is moved; errors count over the two between.
Scene chain() {
  Scene scene = test::box_scene(1, {3, 1, 1});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {3e-3, 0, 0});
  return scene;
}

// By hand: u - r = (0, -3) over the free nodes, |r| = 5, max |r| = 4, mean square = 9 / 2; and all of them
// times powers of two that squares of doubles do not hold.
TEST(CompareAnalytic, NormsAreThoseOfTheDefinitionAtAnySize) {
  const Scene scene = chain();
  for (const double unit : {1.0, 0x1p900, 0x1p-900}) {
    Displacement u(scene.specimen.grid), r(scene.specimen.grid);
    std::ranges::copy(std::vector<double>{9 * unit, 3 * unit, 4 * unit, 9 * unit}, r.component(0).begin());
    std::ranges::copy(std::vector<double>{0, 3 * unit, 1 * unit, 0}, u.component(0).begin());
    const ErrorNorms norms = compare(scene, u, r);
    EXPECT_DOUBLE_EQ(norms.relative_l2, 3.0 / 5.0);
    EXPECT_DOUBLE_EQ(norms.relative_max, 3.0 / 4.0);
    EXPECT_DOUBLE_EQ(norms.rms / unit, std::sqrt(4.5));
  }
}

TEST(CompareAnalytic, LeavesOutNodesHeldInOneComponentOnly) {
  Scene scene = test::box_scene(2, {1, 1, 1});
  scene.prescribed = {{0, 1, 0.0, true}}; // y of node 0
  Displacement u(scene.specimen.grid), r(scene.specimen.grid);
  std::ranges::copy(std::vector<double>{1, 1, 1, 1}, r.component(0).begin());
  std::ranges::copy(std::vector<double>{7, 1, 1, 1}, u.component(0).begin());
  EXPECT_EQ(compare(scene, u, r).relative_l2, 0); // the only difference is at the held node
}

TEST(CompareAnalytic, RelativeErrorWithoutReferenceIsInfinite) {
  const Scene scene = chain();
  Displacement u(scene.specimen.grid), zero(scene.specimen.grid);
  EXPECT_EQ(compare(scene, zero, zero).relative_l2, 0);
  u(0, 1) = 1;
  EXPECT_TRUE(std::isinf(compare(scene, u, zero).relative_l2));
}

TEST(MethodContract, NamesAreThoseOfTheCommandLine) {
  // Truth: the names as README.md has them, in its order.
  const std::array<std::string_view, 9> names{"limits",  "dijkstra", "literal", "sweep",   "relaxed",
                                              "coupled", "fem_q1",   "fem_q2",  "calculix"};
  ASSERT_EQ(every_method.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(every_method[i]), i);
    EXPECT_EQ(to_string(every_method[i]), names[i]);
    EXPECT_EQ(method_from_string(names[i]), every_method[i]);
  }
}

TEST(MethodContract, OtherNamesAreNone) {
  for (const char* name : {"", "magic", "Coupled", "coupled ", "fem_q3", "limit"})
    EXPECT_FALSE(method_from_string(name)) << name;
}

Scene question() {
  Scene scene = test::box_scene(3, {2, 2, 2});
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-4, 0, 0});
  return scene;
}

TEST(UsableNumbersContract, WhatNoArithmeticCarriesIsNamed) {
  EXPECT_EQ(unusable_number(question()), "");
  const auto with = [](const auto& change) {
    Scene scene = question();
    change(scene);
    return unusable_number(scene);
  };
  EXPECT_EQ(with([](Scene& s) { s.prescribed.back().value = NAN; }), "a prescribed displacement is nan");
  EXPECT_EQ(with([](Scene& s) {
              s.specimen.grid = Grid(3, {2, 2, 2}, {1e-3, INFINITY, 1e-3});
            }),
            "the spacing along y is inf");
  EXPECT_NE(with([](Scene& s) { s.materials[0].elasticity.G13 = INFINITY; }), "");
  EXPECT_NE(with([](Scene& s) { s.materials[0].elasticity.nu12 = NAN; }), "");
  EXPECT_NE(with([](Scene& s) { s.materials[0].elasticity.youngs_modulus[0] = 1e-310; }), "");
  EXPECT_NE(with([](Scene& s) { s.gravity[2] = 1e61; }), "");
  EXPECT_NE(with([](Scene& s) { s.limits.taut_scale = NAN; }), "");
  EXPECT_NE(with([](Scene& s) {
              for (Prescribed& p : s.prescribed)
                p.value *= 1e-300;
            }),
            "");
}

TEST(UsableNumbersContract, SizesOfAnyUnitInUseAreTaken) {
  // Truth: nuclei and galaxies: 1e-15 m, 1e21 m; gases and neutron stars: 1e-20 Pa, 1e34 Pa. Nothing at all
  // is a size, too.
  for (const double size : {1e-15, 1e21}) {
    Scene scene = question();
    scene.specimen.grid = Grid(3, {2, 2, 2}, {size, size, size});
    EXPECT_EQ(unusable_number(scene), "");
  }
  for (const double modulus : {1e-20, 1e34}) {
    Scene scene = question();
    scene.materials[0].elasticity = ElasticConstants::isotropic(modulus, 0.3);
    EXPECT_EQ(unusable_number(scene), "");
  }
  Scene at_rest = question();
  for (Prescribed& p : at_rest.prescribed)
    p.value = 0;
  EXPECT_EQ(unusable_number(at_rest), "");
}

using Cells = std::vector<std::string>;

std::vector<Cells> records_of(std::string_view text, CsvComments comments = CsvComments::none) {
  std::vector<Cells> records;
  for (CsvRecords reader(text, comments); reader.next();)
    records.push_back(reader.cells());
  return records;
}

// RFC 4180, section 2: rules 1, 2, 5, 6 and 7.
TEST(CsvRecordsContract, CellsBetweenQuotesHoldCommasQuotesAndEndsOfLines) {
  EXPECT_EQ(records_of("a,b\r\n\"c, d\",\"say \"\"e\"\"\"\n\"f\r\ng\",\n"),
            (std::vector<Cells>{{"a", "b"}, {"c, d", "say \"e\""}, {"f\r\ng", ""}}));
  EXPECT_EQ(records_of("a\n\nb"), (std::vector<Cells>{{"a"}, {""}, {"b"}}))
      << "the last line may lack its end";
  EXPECT_TRUE(records_of("").empty());
  EXPECT_EQ(records_of("\xEF\xBB\xBF"
                       "a,b\n"),
            (std::vector<Cells>{{"a", "b"}}));
}

TEST(CsvRecordsContract, ARecordHasTheLineInWhichItBegins) {
  CsvRecords records("a\n\"b\n\n\"\nc");
  std::vector<int> lines;
  while (records.next())
    lines.push_back(records.line());
  EXPECT_EQ(lines, (std::vector<int>{1, 2, 5}));
}

TEST(CsvRecordsContract, AnOpenQuoteIsKnown) {
  CsvRecords torn("a\nb"), open("a,\"b\n");
  ASSERT_TRUE(torn.next() && torn.next() && open.next());
  EXPECT_FALSE(torn.is_open());
  EXPECT_TRUE(open.is_open());
}

TEST(CsvRecordsContract, CommentsAreLeftOutWhereTheFormHasThem) {
  const std::string_view text = "# 5\" long\n  #\na # b,\"#c\"\n";
  EXPECT_EQ(records_of(text, CsvComments::lines), (std::vector<Cells>{{""}, {"  "}, {"a # b", "#c"}}));
  EXPECT_EQ(records_of(text, CsvComments::anywhere), (std::vector<Cells>{{""}, {"  "}, {"a "}}));
  EXPECT_EQ(records_of("# a,b\n").front(), (Cells{"# a", "b"}));
}

// The same question on a finer lattice.

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

Scene asymmetric_box() {
  Scene scene = test::box_scene(2, {4, 3, 1}, {1, 1, 1});
  scene.limits.from = LimitSource::given;
  scene.limits.given.stretch = {1.5, 1.25, 1};
  scene.limits.given.compress = {0.75, 0.5, 1};
  scene.limits.given.shear = {{{0, 0.125, 0}, {0.0625, 0, 0}, {}}};
  return scene;
}

TEST(ShortestPathsAnalytic, AddUpTheLimitsOfEachAxis) {
  const Scene scene = asymmetric_box();
  const Grid& grid = scene.specimen.grid;
  const LinkLimits limits(scene);
  const PathEnd end{grid.node({1, 1, 0}), 10};
  const auto from = shortest_paths(scene, limits, 0, std::span(&end, 1), PathDirection::from_ends);
  const auto to = shortest_paths(scene, limits, 0, std::span(&end, 1), PathDirection::to_ends);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    const int x = at[0] - 1, y = at[1] - 1;
    // Theory, theorem 2: forward along x costs the stretch, back the compression; y costs the shear. Dyadic,
    // so exact.
    const double shear = 0.0625 * std::abs(y);
    EXPECT_EQ(from[static_cast<std::size_t>(node)], 10 + (x >= 0 ? x * 0.5 : -x * 0.25) + shear);
    EXPECT_EQ(to[static_cast<std::size_t>(node)], 10 + (x >= 0 ? x * 0.25 : -x * 0.5) + shear);
  }
}

TEST(ShortestPathsAnalytic, GoAroundASlotAndNotToAnotherPiece) {
  Scene scene = asymmetric_box();
  // Matter: a U of cells; the two arms are one row apart, and the last column is a piece that touches
  // nothing.
  scene.specimen.grid = Grid(2, {5, 3, 1}, {1, 1, 1});
  constexpr auto o = no_material;
  scene.specimen.material_id = {0, 0, 0, o, 0, //
                                0, o, o, o, o, //
                                0, 0, 0, o, o};
  const Grid& grid = scene.specimen.grid;
  const LinkLimits limits(scene);
  const PathEnd end{grid.node({3, 1, 0}), 0}; // inner corner of the lower arm's tip
  const auto length = shortest_paths(scene, limits, 0, std::span(&end, 1), PathDirection::from_ends);
  // By hand: back two cells (0.25 each), up one link (0.0625), forward two (0.5 each).
  EXPECT_EQ(length[static_cast<std::size_t>(grid.node({3, 2, 0}))], 2 * 0.25 + 0.0625 + 2 * 0.5);
  EXPECT_TRUE(std::isinf(length[static_cast<std::size_t>(grid.node({5, 0, 0}))]));
}

constexpr double E = 10e3, nu = 0.3; // of test::box_scene

CellFields fields_of(const Scene& scene, const std::array<Vec3, 3>& gradient) {
  return cell_fields(scene, test::affine_displacement<Displacement>(scene, gradient));
}

TEST(CellFieldsAnalytic, PatchOfMacNealAndHarder) {
  // MacNeal, Harder 1985: u = 1e-3 (2x+y+z)/2 and cyclic, E = 1e6, nu = 0.25: normal stresses 2000,
  // shear 400.
  Scene scene = test::box_scene(3, {2, 2, 2});
  scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, 0.25);
  const CellFields fields = fields_of(scene, {{{1e-3, 5e-4, 5e-4}, {5e-4, 1e-3, 5e-4}, {5e-4, 5e-4, 1e-3}}});
  for (std::size_t cell = 0; cell < 8; ++cell) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(fields.strain[cell][i], 1e-3, 1e-15);
      EXPECT_NEAR(fields.strain[cell][i + 3], 5e-4, 1e-15);
      EXPECT_NEAR(fields.stress[cell][i], 2000, 1e-9);
      EXPECT_NEAR(fields.stress[cell][i + 3], 400, 1e-9);
    }
    EXPECT_NEAR(fields.von_mises[cell], 400 * 3, 1e-9); // sqrt(3 * 3 * 400^2)
  }
}

TEST(CellFieldsAnalytic, ShearComponentsStandInVtkOrder) {
  const Scene scene = test::box_scene(3, {1, 1, 1});
  const double G = E / (2 * (1 + nu));
  // gamma of xy, yz, xz in turn; VTK's order is XX YY ZZ XY YZ XZ.
  EXPECT_NEAR(fields_of(scene, {{{0, 1e-3, 0}, {}, {}}}).stress[0][3], G * 1e-3, 1e-9);
  EXPECT_NEAR(fields_of(scene, {{{}, {0, 0, 1e-3}, {}}}).stress[0][4], G * 1e-3, 1e-9);
  EXPECT_NEAR(fields_of(scene, {{{0, 0, 1e-3}, {}, {}}}).stress[0][5], G * 1e-3, 1e-9);
}

TEST(CellFieldsAnalytic, BarIsUniaxialAndContractsFreely) {
  const CellFields fields = fields_of(test::box_scene(1, {4, 1, 1}), {{{0.01, 0, 0}, {}, {}}});
  EXPECT_NEAR(fields.stress[0][0], E * 0.01, 1e-9);
  EXPECT_NEAR(fields.stress[0][1], 0, 1e-9);
  EXPECT_NEAR(fields.strain[0][2], -nu * 0.01, 1e-15);
}

TEST(CellFieldsAnalytic, PlaneStressAndPlaneStrainDifferOutOfThePlane) {
  Scene scene = test::box_scene(2, {2, 2, 1});
  const std::array<Vec3, 3> stretch{{{0.01, 0, 0}, {}, {}}};
  const CellFields strain = fields_of(scene, stretch);
  const double lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
  EXPECT_NEAR(strain.stress[0][2], lambda * 0.01, 1e-9);
  EXPECT_EQ(strain.strain[0][2], 0);
  scene.plane = PlaneAssumption::stress;
  const CellFields stress = fields_of(scene, stretch);
  EXPECT_NEAR(stress.stress[0][0], E / (1 - nu * nu) * 0.01, 1e-9);
  EXPECT_NEAR(stress.stress[0][2], 0, 1e-9);
  EXPECT_NEAR(stress.strain[0][2], -nu / (1 - nu) * 0.01, 1e-15);
}

TEST(CellFieldsAnalytic, CellsWithoutMatterStayZero) {
  Scene scene = test::box_scene(2, {2, 1, 1});
  scene.specimen.material_id = {0, no_material};
  const CellFields fields = fields_of(scene, {{{0.01, 0, 0}, {}, {}}});
  EXPECT_GT(fields.von_mises[0], 0);
  EXPECT_EQ(fields.von_mises[1], 0);
}

} // namespace
} // namespace maille
