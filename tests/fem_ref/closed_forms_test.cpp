// Bars and beams whose displacement is known.

#include "fem_ref/bodies.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

using test::options_of;

constexpr double E = 10e3, L = 0.02, h = 1e-3;

/// A bar along x of 20 cells, one cell thick, held at x = 0, without contraction.
Scene bar(int dimension) {
  Scene scene = test::box_scene(dimension, {20, 1, 1}, {h, h, h});
  scene.materials[0] = test::material_of(ElasticConstants::isotropic(E, 0));
  test::hold_face(scene, 0, false);
  return scene;
}

/// Of bars in one to three dimensions. @param along  the displacement at x
void expect_along_bars(const std::function<void(Scene&)>& load, const std::function<double(double)>& along) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (const int degree : {1, 2}) {
      SCOPED_TRACE(fmt::format("{}D Q{}", dimension, degree));
      Scene scene = bar(dimension);
      load(scene);
      const fem_ref::Result result = test::solved(scene, options_of(degree));
      const auto exact = [&](const Vec3& x) -> Vec3 { return {along(x[0]), 0, 0}; };
      EXPECT_LT(test::largest_error(scene, result.answer.displacement, exact), 1e-10 * std::abs(along(L)));
    }
}

// Truth: u = t x / E for a traction t on the end.
TEST(BarAnalytic, EndLoad) {
  expect_along_bars(
      [](Scene& scene) {
        test::pull_face(scene, 0, true, {250, 0, 0});
      },
      [](double x) { return 250 * x / E; });
}

// Truth: u = rho g (2 L x - x^2) / (2 E); linear elements are exact at the nodes here too, as in every 1D
// problem with constant coefficients.
TEST(BarAnalytic, OwnWeight) {
  const auto weigh = [](Scene& scene) {
    scene.materials[0].density = 1060;
    scene.gravity = {9.81, 0, 0};
  };
  expect_along_bars(weigh, [](double x) { return 1060 * 9.81 * (2 * L * x - x * x) / (2 * E); });
}

// Truth: one force runs through both parts: u = t x / E_1, then t L_1 / E_1 + t (x - L_1) / E_2.
TEST(BarAnalytic, TwoMaterialsInSeries) {
  const auto pull_two = [](Scene& scene) {
    scene.materials.push_back(test::material_of(ElasticConstants::isotropic(5 * E, 0)));
    scene.specimen.material_id.assign(20, 0);
    std::fill(scene.specimen.material_id.begin() + 8, scene.specimen.material_id.end(), std::uint8_t{1});
    test::pull_face(scene, 0, true, {250, 0, 0});
  };
  expect_along_bars(pull_two, [](double x) {
    const double first = std::min(x, 8 * h), second = std::max(0.0, x - 8 * h);
    return 250 * (first / E + second / (5 * E));
  });
}

// Truth: for degree 2 the mid point of a cell whose ends are both prescribed lies half way, though its own
// weight would pull it down: the documented rule, seen through the L2 norm.
TEST(BarAnalytic, MidPointsBetweenPrescribedNodesAreInterpolated) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    Scene scene = test::box_scene(dimension, {1, 1, 1});
    scene.gravity = {9.81, 0, 0};
    test::hold_face(scene, 0, false);
    test::move_face(scene, 0, true, {1e-4, 0, 0});
    fem_ref::Options options = options_of(2);
    options.exact = [](const Vec3& x) -> Vec3 { return {0.1 * x[0], 0, 0}; };
    const fem_ref::Result result = test::solved(scene, options);
    EXPECT_LT(*result.l2_error, 1e-16);
  }
}

// Truth: Hooke's law with the third strain or the third stress zero.
TEST(PlaneAnalytic, StrainAndStressDiffer) {
  const double nu = 0.3, t = 200;
  for (const PlaneAssumption plane : {PlaneAssumption::strain, PlaneAssumption::stress}) {
    Scene scene = test::box_scene(2, {6, 4, 1}, {h, h, h});
    scene.plane = plane;
    test::prescribe_face(scene, 0, false, 0, 0, true);
    test::prescribe_face(scene, 1, false, 1, 0, true);
    test::pull_face(scene, 0, true, {t, 0, 0});
    const bool strain = plane == PlaneAssumption::strain;
    const double along = strain ? t * (1 - nu * nu) / E : t / E;
    const double across = strain ? -t * nu * (1 + nu) / E : -nu * t / E;
    const auto exact = [&](const Vec3& x) -> Vec3 { return {along * x[0], across * x[1], 0}; };
    for (const int degree : {1, 2}) {
      const fem_ref::Result result = fem_ref::solve(scene, options_of(degree));
      EXPECT_LT(test::largest_error(scene, result.answer.displacement, exact), 1e-10 * along * 6 * h);
    }
  }
}

// Truth: MacNeal and Harder 1985, straight beam, unit in-plane load at the tip: P L^3 / 3 E I + 6 P L / 5 G
// A = 0.1081. Beam theory leaves out what the clamp does over a length of one depth, (depth / L)^2 = 0.1 % of
// the deflection, and quadratic elements one third of the depth long are off by about as much: 0.3 % in all.
TEST(BeamAnalytic, SlenderCantileverBendsAsBeamTheorySays) {
  const double length = 6, depth = 0.2, width = 0.1, modulus = 1e7, nu = 0.3;
  Scene scene = test::box_scene(3, {45, 2, 1}, {length / 45, depth / 2, width});
  scene.materials[0] = test::material_of(ElasticConstants::isotropic(modulus, nu));
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {0, 1 / (depth * width), 0});
  const fem_ref::Result result = test::solved(scene, options_of(2));
  const double tip = result.answer.displacement(1, scene.specimen.grid.node({45, 1, 0}));
  EXPECT_NEAR(tip, 0.1081, 0.003 * 0.1081);
}

/// Beams that are a hundred times as long as they are thick. What bends them is a millionth of what their
/// single cells resist with, so that the rounding of those forces is as large as what pulls: a residual
/// measured by the load alone says nothing there.

using fem_ref::LinearSolver;

constexpr double youngs_modulus = 1e6, traction = 0.01;

/// Of cells of 1 mm, held at one end, pulled across at the other.
Scene cantilever(const Index3& cells, double nu) {
  Scene scene = test::box_scene(3, cells);
  scene.materials.front().elasticity = ElasticConstants::isotropic(youngs_modulus, nu);
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {0, 0, -traction});
  return scene;
}

double mean_deflection_of_the_end(const Scene& scene, const Answer& answer) {
  const Grid& grid = scene.specimen.grid;
  double sum = 0, n = 0;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    if (grid.node_at(node)[0] == grid.cells()[0]) {
      sum -= answer.displacement(2, node);
      ++n;
    }
  return sum / n;
}

/// Timoshenko's beam: bending, and shear with the coefficient 10 (1 + nu) / (12 + 11 nu) of a rectangle
/// (Cowper 1966).
double deflection_of_the_beam(const Index3& cells, double nu) {
  const double length = 1e-3 * cells[0], width = 1e-3 * cells[1], height = 1e-3 * cells[2];
  const double force = traction * width * height, area = width * height,
               inertia = width * std::pow(height, 3) / 12, shear_modulus = youngs_modulus / (2 * (1 + nu)),
               coefficient = 10 * (1 + nu) / (12 + 11 * nu);
  return force * std::pow(length, 3) / (3 * youngs_modulus * inertia) +
         force * length / (coefficient * shear_modulus * area);
}

// Truth: beam theory. The held end adds a length that is a hundredth of the beam's at most.
TEST(SlenderBeamAnalytic, QuadraticElementsBendAsABeamByEverySolver) {
  const Index3 cells{400, 2, 2};
  const Scene scene = cantilever(cells, 0.49);
  const double expected = deflection_of_the_beam(cells, 0.49);
  for (const LinearSolver solver : {LinearSolver::cholmod, LinearSolver::gmg}) { // AMG takes minutes
    SCOPED_TRACE(fem_ref::linear_solver_names[static_cast<std::size_t>(solver)]);
    const Answer answer = test::solved(scene, options_of(2, solver)).answer;
    EXPECT_NEAR(mean_deflection_of_the_end(scene, answer), expected, 0.01 * expected);
    EXPECT_LT(answer.residual, 1e-4);
  }
}

// Truth: one solver has nothing in common with another but the cells' matrices.
TEST(SlenderBeamOracle, SolversAgree) {
  const Scene scene = cantilever({400, 4, 4}, 0.49);
  const Answer truth = test::solved(scene, options_of(1, LinearSolver::cholmod)).answer;
  for (const LinearSolver solver : {LinearSolver::gmg, LinearSolver::cg_amg}) {
    SCOPED_TRACE(fem_ref::linear_solver_names[static_cast<std::size_t>(solver)]);
    const Answer answer = test::solved(scene, options_of(1, solver)).answer;
    EXPECT_LT(test::largest_difference(truth.displacement, answer.displacement),
              1e-4 * test::largest(truth.displacement));
  }
}

// Truth: of linear elements, that an answer does not depend on the size of the load.
TEST(SlenderBeamOracle, AThousandTimesTheLoadMovesAThousandTimesAsFar) {
  Scene scene = cantilever({400, 4, 4}, 0.49);
  const Answer one = test::solved(scene, options_of(1)).answer;
  for (FaceLoad& load : scene.tractions)
    load.traction[2] *= 1000;
  const Answer thousand = test::solved(scene, options_of(1)).answer;
  EXPECT_NEAR(test::largest(thousand.displacement) / test::largest(one.displacement), 1000, 0.01);
}

// Cells that are bent into shape, and stress at nodes.

Scene slanted_box(int dimension) {
  Scene scene =
      test::box_scene(dimension, dimension == 2 ? Index3{5, 4, 1} : Index3{4, 3, 3}, {0.2, 0.25, 0.3});
  scene.materials = {test::material_of(test::fibrous())};
  scene.specimen.fibre = test::slanted_fibre(dimension);
  return scene;
}

Vec3 bent(const Vec3& x) {
  return {x[0] + 0.1 * x[0] * x[1], x[1] + 0.15 * x[0] * x[0], x[2] + 0.1 * x[0] * x[2]};
}

/// Any straight line stays straight: only shears and stretches.
Vec3 stretched(const Vec3& at) {
  return {1e-3 * at[0] + 2e-3 * at[1], -5e-4 * at[0] + 3e-3 * at[1] + 1e-3 * at[2],
          2e-3 * at[2] - 1e-3 * at[0]};
}

// Truth: a linear displacement has one strain, whatever the mesh (the patch test), and that strain its stress
// C : eps.
TEST(ShapeAnalytic, BentCellsHoldConstantStrain) {
  for (const int dimension : {2, 3})
    for (const int degree : {1, 2}) {
      const Scene scene = slanted_box(dimension);
      fem_ref::Options options = test::options_of(degree);
      options.shape = bent;
      options.recover_stress = true;
      options.boundary_displacement = [dimension](const Vec3& x) {
        Vec3 u = stretched(x);
        if (dimension == 2)
          u = stretched({x[0], x[1], 0});
        return u;
      };
      const Answer answer = test::solved(scene, options).answer;
      const Grid& grid = scene.specimen.grid;
      Eigen::VectorXd strain(dimension == 2 ? 3 : 6);
      if (dimension == 2)
        strain << 1e-3, 3e-3, 1.5e-3;
      else
        strain << 1e-3, 3e-3, 2e-3, 1e-3, -1e-3, 1.5e-3;
      const Eigen::VectorXd stress = scene.cell_stiffness(0) * strain;
      const double size = stress.cwiseAbs().maxCoeff();
      for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
        const Vec3 u = stretched(bent(scene.specimen.position(grid.node_at(node))));
        for (int c = 0; c < dimension; ++c)
          EXPECT_NEAR(answer.displacement(c, node), u[static_cast<std::size_t>(c)], 1e-13);
        const auto& found = answer.nodal_stress[static_cast<std::size_t>(node)];
        EXPECT_NEAR(answer.nodal_strain[static_cast<std::size_t>(node)][3], 0.75e-3, 1e-12);
        EXPECT_NEAR(found[0], stress[0], 1e-9 * size);
        EXPECT_NEAR(found[1], stress[1], 1e-9 * size);
        EXPECT_NEAR(found[3], stress[dimension == 2 ? 2 : 5], 1e-9 * size); // XY
      }
    }
}

// Truth: pure bending of an isotropic bar, a polynomial of degree two: stress E k z along the bar and nothing
// else. Quadratic elements hold it, so their strain is linear in every cell and its recovery exact, at the
// boundary too.
TEST(RecoveryAnalytic, BendingStressIsExactForQuadraticElements) {
  constexpr double nu = 0.3, k = 0.01;
  Scene scene = test::box_scene(3, {4, 3, 4}, {0.2, 0.25, 0.3});
  scene.materials = {test::material_of(ElasticConstants::isotropic(E, nu))};
  fem_ref::Options options = test::options_of(2);
  options.recover_stress = true;
  options.boundary_displacement = [](const Vec3& x) {
    return Vec3{k * x[0] * x[2], -nu * k * x[1] * x[2],
                -k / 2 * (x[0] * x[0] + nu * (x[2] * x[2] - x[1] * x[1]))};
  };
  const Answer answer = test::solved(scene, options).answer;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
    const double z = scene.specimen.position(scene.specimen.grid.node_at(node))[2];
    const auto& stress = answer.nodal_stress[static_cast<std::size_t>(node)];
    EXPECT_NEAR(stress[0], E * k * z, 1e-9 * E * k);
    for (const std::size_t other : {1, 2, 3, 4, 5})
      EXPECT_NEAR(stress[other], 0, 1e-9 * E * k);
  }
}

// Truth: two bars in line carry one stress; each has its own strain. The nodes between them show the material
// of lower number.
TEST(RecoveryAnalytic, StressIsNotAveragedAcrossMaterials) {
  Scene scene = test::box_scene(1, {6, 1, 1}, {0.1, 1, 1});
  scene.materials = {test::material_of(ElasticConstants::isotropic(10e3, 0.3)),
                     test::material_of(ElasticConstants::isotropic(40e3, 0.3))};
  scene.specimen.material_id = {0, 0, 0, 1, 1, 1};
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {100, 0, 0});
  fem_ref::Options options = test::options_of(1);
  options.recover_stress = true;
  const Answer answer = fem_ref::solve(scene, options).answer;
  for (std::size_t node = 0; node < 7; ++node) {
    EXPECT_NEAR(answer.nodal_stress[node][0], 100, 1e-9);
    EXPECT_NEAR(answer.nodal_strain[node][0], node <= 3 ? 0.01 : 0.0025, 1e-12);
  }
}

TEST(ShapeContract, AShapeThatTurnsCellsInsideOutIsAFailure) {
  Scene scene = test::box_scene(2, {2, 2, 1});
  test::hold_face(scene, 0, false);
  fem_ref::Options options = test::options_of(1);
  options.shape = [](const Vec3& x) { return Vec3{-x[0], x[1], x[2]}; };
  const Answer answer = fem_ref::solve(scene, options).answer;
  EXPECT_EQ(answer.status, Status::failed);
  EXPECT_EQ(answer.message, "the shape turns a cell inside out");
}

} // namespace
} // namespace maille
