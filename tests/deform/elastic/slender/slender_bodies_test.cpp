/// `coupled` on slender bodies that are no boxes: columns of cells on a foot, and chains that wind, whose
/// bending float32 cannot tell from nothing.

#include "maille/deform/solve.hpp"
#include "maille/scene/scene.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/bodies/scenes.hpp"
#include "support/direct_solution.hpp"
#include "support/fields.hpp"
#include "support/sanitized.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace maille::deform {
namespace {

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

// Truth: a full box of the same cells, whose solver is another. Its limits bind along half of its length.
TEST(SlenderBodiesOracle, WithinLimitsAColumnIsWhatTheBoxIs) {
  constexpr int length = 150;
  const auto bent = [&](Scene scene) {
    scene.materials[0].elasticity = ElasticConstants::isotropic(1e9, 0.3);
    scene.limits.from = LimitSource::given;
    scene.limits.given = tests::even_limits(1.01, 0.99, 0.0005);
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
  EXPECT_NE(column.algorithm, box.algorithm);
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
