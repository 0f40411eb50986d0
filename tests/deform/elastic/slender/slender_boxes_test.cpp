/// `coupled` on full boxes that are slender, thin or made of oblong cells: bodies that bend at little energy.

#include "maille/deform/solve.hpp"
#include "maille/scene/scene.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/scenes.hpp"
#include "support/direct_solution.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"

namespace maille::deform {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
}

double spread(std::mt19937& random, double low, double high) {
  return std::exp(uniform(random, std::log(low), std::log(high)));
}

int one_of(std::mt19937& random, int n) {
  return static_cast<int>(random() % static_cast<unsigned>(n));
}

/// Rods, plates and bodies of flat or long cells, held at one end, with a load or a move; isotropic or along
/// a fibre.
Scene random_slender(unsigned seed, double load) {
  std::mt19937 random(seed);
  Index3 cells{1, 1, 1};
  Vec3 spacing{1e-3, 1e-3, 1e-3};
  const int kind = one_of(random, 4), along = one_of(random, 3);
  const auto a = static_cast<std::size_t>(along), b = (a + 1) % 3, c = (a + 2) % 3;
  if (kind == 0) { // a rod
    cells[b] = 1 + one_of(random, 3);
    cells[c] = 1 + one_of(random, 3);
    cells[a] = static_cast<int>(spread(random, 8, 300.0 / (cells[b] * cells[c])));
  } else if (kind == 1) { // a plate
    cells[c] = 1 + one_of(random, 2);
    cells[a] = 4 + one_of(random, 11);
    cells[b] = 4 + one_of(random, 11);
    spacing[c] = spread(random, 0.1e-3, 1e-3);
  } else if (kind == 2) { // oblong cells
    for (std::size_t axis = 0; axis < 3; ++axis) {
      cells[axis] = 2 + one_of(random, 7);
      spacing[axis] = spread(random, 0.1e-3, 10e-3); // up to 100:1
    }
  } else { // a strip
    cells[a] = 10 + one_of(random, 40);
    cells[b] = 2 + one_of(random, 4);
    cells[c] = 1 + one_of(random, 3);
    spacing[a] = spread(random, 0.3e-3, 3e-3);
  }
  Scene scene = test::box_scene(3, cells, spacing);
  const double nus[] = {0, 0.3, 0.45, 0.49, 0.499, 0.4999};
  Material& material = scene.materials[0];
  material.density = 1000;
  material.elasticity = ElasticConstants::isotropic(spread(random, 1e3, 1e7), nus[one_of(random, 6)]);
  if (one_of(random, 5) == 0) {
    material.elasticity = ElasticConstants::transversely_isotropic(200e3, 10e3, 7e3, 0.3, 0.4);
    scene.specimen.fibre = {0.48, 0.6, 0.64};
  }
  test::hold_face(scene, along, one_of(random, 2) == 0);
  const bool is_upper = scene.specimen.grid.node_at(scene.prescribed[0].node)[a] == 0; // the free end
  const Vec3 pull{load * uniform(random, -10, 10), load * uniform(random, -10, 10),
                  load * uniform(random, -10, 10)};
  switch (one_of(random, 4)) {
  case 0:
    scene.gravity = pull;
    break;
  case 1:
    test::pull_face(scene, along, is_upper, pull);
    break;
  case 2:
    test::pull_face(scene, static_cast<int>(b), true, pull);
    break;
  default:
    test::move_face(scene, along, is_upper, {1e-5 * pull[0], 1e-5 * pull[1], 1e-5 * pull[2]});
  }
  return scene;
}

// Truth: a direct factorisation of the matrix that the energy's formula gives, in long double.
TEST(SlenderBoxesOracle, FiveHundredRandomOnesAreWithinTwiceTheTolerance) {
  for (unsigned seed = 1; seed <= test::cases(500u, 30u); ++seed) {
    Scene scene = random_slender(seed, 1);
    const Displacement truth = test::direct_solution(scene);
    scene.relaxation.tolerance = std::pow(10.0, -3 - static_cast<int>(seed % 3));
    const Answer answer = solve(scene, "coupled");
    const Index3& n = scene.specimen.grid.cells();
    SCOPED_TRACE(testing::Message() << "seed " << seed << ": " << n[0] << " x " << n[1] << " x " << n[2]
                                    << ", tolerance " << scene.relaxation.tolerance << ", "
                                    << answer.iterations << " iterations, estimated " << answer.residual
                                    << ' ' << answer.message);
    ASSERT_EQ(answer.status, Status::done);
    EXPECT_LE(test::relative_difference(answer.displacement, truth), 2 * scene.relaxation.tolerance);
  }
}

// Truth: the equations are linear.
TEST(SlenderBoxesContract, TheScaleOfTheLoadChangesNoDigitThatCounts) {
  for (unsigned seed = 1; seed <= test::cases(60u, 6u); ++seed) {
    const Scene scene = random_slender(seed, 1);
    const Answer answer = solve(scene, "coupled");
    for (const double factor : {1e-6, 1e6}) {
      Answer other = solve(random_slender(seed, factor), "coupled");
      SCOPED_TRACE(testing::Message() << "seed " << seed << ", load times " << factor);
      ASSERT_EQ(other.status, Status::done);
      for (double& value : other.displacement.values())
        value /= factor;
      EXPECT_LE(test::relative_difference(other.displacement, answer.displacement),
                scene.relaxation.tolerance);
    }
  }
}

/// Mean displacement of a face [m].
double mean_of_end(const Scene& scene, const Answer& answer, int component) {
  const Grid& grid = scene.specimen.grid;
  double sum = 0;
  int n = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (grid.node_at(node)[0] == grid.nodes()[0] - 1) {
      sum += answer.displacement(component, node);
      ++n;
    }
  return sum / n;
}

// Truth: Euler and Bernoulli's cantilever under its weight, w = rho g A L^4 / (8 E I), of rods 300 to 1000
// times as long as thick, where shear adds less than 1e-4; nu = 0, so that the held end is clamped as the
// theory has it. Cells bend with their exact stiffness.
TEST(SlenderBoxesAnalytic, LongRodsBendAsBeamsDo) {
  for (const auto& [length, across] : {std::pair(1000, 1), std::pair(400, 1), std::pair(600, 2)}) {
    Scene scene = test::box_scene(3, {length, across, across});
    scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, 0);
    scene.materials[0].density = 1000;
    scene.gravity = {0, 0, -1e-4};
    test::hold_face(scene, 0, false);
    const Answer answer = solve(scene, "coupled");
    SCOPED_TRACE(testing::Message() << length << " x " << across << " x " << across << ' ' << answer.message);
    ASSERT_EQ(answer.status, Status::done);
    const double L = length * 1e-3, h = across * 1e-3;
    const double w = -1000 * 1e-4 * h * h * std::pow(L, 4) / (8 * 1e6 * std::pow(h, 4) / 12);
    EXPECT_NEAR(mean_of_end(scene, answer, 2), w, 2e-3 * std::abs(w));
  }
}

// Truth: Kirchhoff's plate in cylindrical bending, w = rho g L^4 / (8 E h^2 / 12) at nu = 0; flat cells, 100
// : 1.
TEST(SlenderBoxesAnalytic, ThinPlatesOfFlatCellsBendAsPlatesDo) {
  Scene scene = test::box_scene(3, {40, 10, 4}, {1e-3, 1e-3, 0.01e-3});
  scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, 0);
  scene.materials[0].density = 1000;
  scene.gravity = {0, 0, -1e-6};
  test::hold_face(scene, 0, false);
  const Answer answer = solve(scene, "coupled");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  const double L = 40e-3, h = 0.04e-3, w = -1000 * 1e-6 * std::pow(L, 4) / (8 * 1e6 * h * h / 12);
  EXPECT_NEAR(mean_of_end(scene, answer, 2), w, 5e-3 * std::abs(w));
}

/// `coupled` on slender bodies that are no boxes: columns of cells on a foot, and chains that wind, whose
/// bending float32 cannot tell from nothing.

/// A body of the listed cells, in a grid of that size.
Scene body_of(const Index3& grid, const std::vector<Index3>& cells) {
  Scene scene = test::box_scene(3, grid);
  scene.specimen.material_id.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), no_material);
  for (const Index3& cell : cells)
    scene.specimen.material_id[static_cast<std::size_t>(scene.specimen.grid.cell(cell))] = 0;
  return scene;
}

/// A column along z, `width` by `thickness` cells, on a foot of one layer of cells, which is fixed below.
Scene column_on_foot(int length, int width, int thickness) {
  std::vector<Index3> cells;
  for (int z = 0; z <= length; ++z)
    for (int y = 0; y < width; ++y)
      for (int x = 0; x <= thickness; ++x)
        if (z == 0 || x < thickness)
          cells.push_back({x, y, z});
  Scene scene = body_of({thickness + 1, width, length + 1}, cells);
  test::hold_face(scene, 2, false);
  return scene;
}

/// A chain of single cells that climbs, and turns aside where it likes.
Scene winding_chain(unsigned seed) {
  constexpr int side = 7, steps = 90;
  std::mt19937 random(seed);
  std::vector<Index3> cells{{0, 0, 0}};
  const auto go = [&](std::size_t axis, int by) {
    for (int i = 0; i < 2; ++i) { // so that no two parts of it touch
      cells.push_back(cells.back());
      cells.back()[axis] += by;
    }
  };
  for (int step = 0; step < steps; ++step) {
    go(2, 1);
    if (random() % 4 != 0)
      continue;
    const std::size_t axis = random() % 2;
    go(axis, cells.back()[axis] + 2 >= side || (cells.back()[axis] > 0 && random() % 2 == 0) ? -1 : 1);
  }
  Scene scene = body_of({side, side, cells.back()[2] + 1}, cells);
  const double nus[] = {0, 0.3, 0.45, 0.49};
  scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, nus[random() % 4]);
  scene.materials[0].density = 1000;
  const auto share = [&] { return static_cast<double>(random() % 2001) / 1000 - 1; };
  scene.gravity = {share(), share(), share()};
  test::hold_face(scene, 2, false);
  return scene;
}

// Truth: a direct factorisation of the matrix that the energy's formula gives, in long double.
TEST(SlenderBodiesOracle, ChainsThatWindAreWithinTwiceTheTolerance) {
  int by_factor = 0;
  for (unsigned seed = 1; seed <= test::cases(20u, 2u); ++seed) {
    Scene scene = winding_chain(seed);
    const Displacement truth = test::direct_solution(scene);
    scene.relaxation.tolerance = std::pow(10.0, -3 - static_cast<int>(seed % 3));
    const Answer answer = solve(scene, "coupled");
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", " << scene.specimen.n_matter_cells()
                                    << " cells, " << answer.iterations << " iterations, estimated "
                                    << answer.residual << ' ' << answer.message);
    ASSERT_EQ(answer.status, Status::done);
    EXPECT_LE(test::relative_difference(answer.displacement, truth), 2 * scene.relaxation.tolerance);
    by_factor += answer.algorithm.find("Cholesky") != std::string::npos ? 1 : 0;
  }
  EXPECT_GT(by_factor, 0);
}

// Truth: Euler and Bernoulli's cantilever under its weight, w = rho g A L^4 / (8 E I), with the shear of
// Timoshenko, rho g L^2 / (2 G 5/6), beside which the foot's give is small.
TEST(SlenderBodiesAnalytic, ColumnsAndRibbonsOnAFootBendAsBeamsDo) {
  struct Case {
    int length, width, thickness;
    const char* way;
  };
  for (const auto& [length, width, thickness, way] :
       {Case{200, 1, 1, "Cholesky"}, Case{450, 2, 2, "Cholesky"}, Case{1000, 1, 1, "Cholesky"},
        Case{500, 4, 4, "Cholesky"}, Case{260, 40, 1, "in float64"}}) {
    Scene scene = column_on_foot(length, width, thickness);
    constexpr double E = 1e6;
    scene.materials[0].elasticity = ElasticConstants::isotropic(E, 0);
    scene.materials[0].density = 1000;
    scene.gravity = {1e-4, 0, 0};
    const Answer answer = solve(scene, "coupled");
    SCOPED_TRACE(testing::Message() << length << " x " << width << " x " << thickness << ", "
                                    << answer.algorithm);
    ASSERT_EQ(answer.status, Status::done) << answer.message;
    EXPECT_NE(answer.algorithm.find(way), std::string::npos);
    EXPECT_LE(answer.iterations, 150);
    EXPECT_LE(answer.bytes, bytes_needed(scene, "coupled"));
    const double L = length * 1e-3, h = thickness * 1e-3;
    const double w = 1000 * 1e-4 * (std::pow(L, 4) / (8 * E * h * h / 12) + L * L / (E * 5 / 6));
    const std::int64_t end = scene.specimen.grid.node({0, 0, length + 1});
    EXPECT_NEAR(answer.displacement(0, end), w, 0.01 * w);
  }
}

// Truth: a full box of the same cells, without void beside them. Its limits bind along half of its length.
TEST(SlenderBodiesConsistent, WithinLimitsAColumnIsWhatTheBoxIs) {
  constexpr int length = 150;
  const auto bent = [&](Scene scene) {
    scene.materials[0].elasticity = ElasticConstants::isotropic(1e9, 0.3);
    scene.limits.from = LimitSource::given;
    scene.limits.given = test::even_limits(1.01, 0.99, 0.0005);
    test::hold_face(scene, 2, false);
    scene.tractions.push_back({scene.specimen.grid.cell({0, 0, length - 1}), 2, true, {1000, 0, 1000}});
    return solve(scene, "coupled");
  };
  std::vector<Index3> cells;
  for (int z = 0; z < length; ++z)
    cells.push_back({0, 0, z});
  const Answer box = bent(test::box_scene(3, {1, 1, length})), column = bent(body_of({2, 2, length}, cells));
  ASSERT_EQ(box.status, Status::done) << box.message;
  ASSERT_EQ(column.status, Status::done) << column.message;
  EXPECT_NE(column.message.find("limits are active"), std::string::npos) << column.message;
  const Grid& grid = Grid(3, {2, 2, length}, {1e-3, 1e-3, 1e-3});
  double difference = 0, size = 0;
  for (int z = 0; z <= length; ++z)
    for (int y = 0; y < 2; ++y)
      for (int x = 0; x < 2; ++x)
        for (int c = 0; c < 3; ++c) {
          const double one = box.displacement(c, x + 2 * (y + 2 * z)),
                       other = column.displacement(c, grid.node({x, y, z}));
          difference += (one - other) * (one - other);
          size += one * one;
        }
  EXPECT_LE(difference, 4e-6 * size);
}

} // namespace
} // namespace maille::deform
