// Finite strain: total Lagrange with laws by automatic differentiation.

#include "fem_ref/bodies.hpp"
#include "finite/energy.hpp"
#include "maille/scene/cell_fields.hpp"
#include "support/bodies/bent_bar.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <sys/wait.h>

#include <cstdio>
#include <numbers>
#include <random>

namespace maille {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::options_of;

constexpr double E = 10e3, nu = 0.45, L = 4e-3, h = 1e-3;
constexpr double mu = E / (2 * (1 + nu)), lambda = E * nu / ((1 + nu) * (1 - 2 * nu));

Material with_law(const Law& law) {
  Material material = test::material_of(rest_constants(law));
  material.law = law;
  return material;
}

/// A root of a continuous function that is below zero at `low` and above at `high`.
double root(const std::function<double(double)>& of, double low, double high) {
  for (int i = 0; i < 200; ++i)
    (of(0.5 * (low + high)) < 0 ? low : high) = 0.5 * (low + high);
  return 0.5 * (low + high);
}

/// Nominal stress along an axis that is stretched by l where the volume is J: of neo-Hookean matter.
double nominal(double l, double J) {
  return mu * (l - 1 / l) + lambda * std::log(J) / l;
}

/// Stretch of the `n_across` axes without stress while the others make `held` of the volume.
double stretch_across(double held, int n_across) {
  return root([&](double a) { return nominal(a, held * std::pow(a, n_across)); }, 0.2, 5);
}

/// 4 x 2 x 2 cells of neo-Hookean matter that slide along the planes x = 0, y = 0 and z = 0.
Scene block(int dimension, PlaneAssumption plane = PlaneAssumption::strain) {
  Scene scene = test::box_scene(dimension, {4, 2, dimension == 3 ? 2 : 1}, {h, h, h});
  scene.plane = plane;
  scene.strain = Strain::finite;
  scene.materials[0] = with_law(NeoHookean{mu, lambda});
  for (int axis = 0; axis < dimension; ++axis)
    test::prescribe_face(scene, axis, false, axis, 0, true);
  return scene;
}

void expect_stretched(const Scene& scene, const Vec3& stretch, double pull, const std::string& what) {
  const double section = scene.dimension() == 3 ? 4 * h * h : 2 * h;
  for (const int degree : {1, 2}) {
    SCOPED_TRACE(fmt::format("{}, Q{}", what, degree));
    const Answer answer = test::solved(scene, options_of(degree)).answer;
    const auto exact = [&](const Vec3& x) -> Vec3 {
      return {(stretch[0] - 1) * x[0], (stretch[1] - 1) * x[1], (stretch[2] - 1) * x[2]};
    };
    EXPECT_LT(test::largest_error(scene, answer.displacement, exact), 1e-9 * L);
    EXPECT_NEAR(test::total_reaction(scene, answer, 0, true), -pull * section, 1e-8 * E * section);
  }
}

// Truth: neo-Hookean matter in closed form; the stretch across by a root in one unknown.
TEST(FiniteStretchAnalytic, Uniaxial) {
  for (const double l : {0.6, 0.8, 1.2, 1.4, 1.6}) {
    const double a = stretch_across(l, 2), pull = nominal(l, l * a * a);
    Scene scene = block(3), plate = block(2, PlaneAssumption::stress);
    test::prescribe_face(scene, 0, true, 0, (l - 1) * L, false);
    test::prescribe_face(plate, 0, true, 0, (l - 1) * L, false);
    expect_stretched(scene, {l, a, a}, pull, fmt::format("3D by {}", l));
    expect_stretched(plate, {l, a, a}, pull, fmt::format("plane stress by {}", l));
  }
}

TEST(FiniteStretchAnalytic, PlaneStrain) {
  for (const double l : {0.6, 0.8, 1.2, 1.4}) {
    const double a = stretch_across(l, 1);
    Scene scene = block(2);
    test::prescribe_face(scene, 0, true, 0, (l - 1) * L, false);
    expect_stretched(scene, {l, a, 1}, nominal(l, l * a), fmt::format("by {}", l));
  }
}

TEST(FiniteStretchAnalytic, Biaxial) {
  const double l = 1.3, m = 1.15, a = stretch_across(l * m, 1);
  Scene scene = block(3), plate = block(2, PlaneAssumption::stress);
  for (Scene* of : {&scene, &plate}) {
    test::prescribe_face(*of, 0, true, 0, (l - 1) * L, false);
    test::prescribe_face(*of, 1, true, 1, (m - 1) * 2 * h, false);
    expect_stretched(*of, {l, m, a}, nominal(l, l * m * a), fmt::format("{}D", of->dimension()));
  }
}

// Truth: incompressible Guccione matter pulled along its fibre and across it, nominal stress by a root in one
// unknown [Pa]; here the bulk modulus is ten thousand times C.
TEST(FiniteStretchAnalytic, NearlyIncompressibleFibres) {
  for (const auto& [fibre, pull] : {std::pair{Vec3{1, 0, 0}, 2200.63}, std::pair{Vec3{0, 1, 0}, 713.1}}) {
    Scene scene = block(3);
    scene.materials[0] = with_law(Guccione{2e3, 8, 2, 4, 2e7});
    scene.specimen.fibre = fibre;
    test::prescribe_face(scene, 0, true, 0, 0.1 * L, false);
    for (const int degree : {1, 2}) {
      const Answer answer = test::solved(scene, options_of(degree)).answer;
      EXPECT_NEAR(-test::total_reaction(scene, answer, 0, true) / (4 * h * h), pull, 1e-3 * pull);
    }
  }
}

// Truth: nominal stress = traction per area at rest, which is what dead tractions and springs are.
TEST(FiniteStretchAnalytic, TractionSpringsAndContraction) {
  const double l = 1.3, a = stretch_across(l, 2), pull = nominal(l, l * a * a);
  Scene scene = block(3);
  test::pull_face(scene, 0, true, {pull, 0, 0});
  expect_stretched(scene, {l, a, a}, pull, "traction");

  Scene held = block(3);
  const double stiffness = 5e5;
  for (const FaceLoad& face : scene.tractions)
    held.springs.push_back({face.cell, face.axis, face.upper, stiffness, {1, 0, 0}});
  test::pull_face(held, 0, true, {pull + stiffness * (l - 1) * L, 0, 0});
  expect_stretched(held, {l, a, a}, pull, "springs");

  const double s = 0.8, b = stretch_across(s, 2);
  Scene muscle = block(3);
  muscle.active_stress.assign(static_cast<std::size_t>(muscle.specimen.grid.n_cells()),
                              -nominal(s, s * b * b));
  expect_stretched(muscle, {s, b, b}, 0, "contraction");
}

// Truth: a hanging bar carries the weight below every section, and its whole weight at the hold.
TEST(FiniteStretchAnalytic, WeightIsThatAtRest) {
  Scene scene = block(3);
  scene.gravity = {40, 0, 0};
  scene.specimen.tissue.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 0.5F);
  const Answer answer = test::solved(scene, options_of(2)).answer;
  const double weight = 0.5 * scene.materials[0].density * 40 * 4 * L * h * h;
  EXPECT_NEAR(test::total_reaction(scene, answer, 0, true), -weight, 1e-9 * weight);
}

// Truth: energy is in proportion to tissue, and to tissue times stiffness.
TEST(FiniteStretchAnalytic, PartialVolumeAndStiffnessScaleForces) {
  const double l = 1.3, a = stretch_across(l, 2), pull = nominal(l, l * a * a);
  for (const bool has_law : {true, false}) {
    Scene scene = block(3);
    test::prescribe_face(scene, 0, true, 0, (l - 1) * L, false);
    if (!has_law)
      scene.materials[0].law.reset();
    const Answer whole = test::solved(scene, options_of(1)).answer;
    const auto n = static_cast<std::size_t>(scene.specimen.grid.n_cells());
    scene.specimen.tissue.assign(n, 0.5F);
    scene.specimen.stiffness_ratio.assign(n, 3);
    const Answer part = test::solved(scene, options_of(1)).answer;
    EXPECT_NEAR(*part.strain_energy, 1.5 * *whole.strain_energy, 1e-9 * *whole.strain_energy);
    const double whole_pull = test::total_reaction(scene, whole, 0, true);
    EXPECT_NEAR(test::total_reaction(scene, part, 0, true), 1.5 * whole_pull, -1e-8 * whole_pull);
    if (has_law) {
      EXPECT_NEAR(whole_pull, -pull * 4 * h * h, 1e-8 * pull * 4 * h * h);
    }
  }
}

/// Every node of the surface where an affine map has it.
Scene mapped_block(int dimension, const Matrix3d& F) {
  Scene scene = block(dimension);
  scene.prescribed.clear();
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    bool is_inside = true;
    for (int a = 0; a < dimension; ++a)
      is_inside = is_inside && at[a] > 0 && at[a] < grid.cells()[a];
    const Vec3 x = scene.specimen.position(at);
    for (int c = 0; c < dimension && !is_inside; ++c) {
      double value = -x[c];
      for (int a = 0; a < 3; ++a)
        value += F(c, a) * x[a];
      scene.prescribed.push_back({node, c, value, at[1] == 0});
    }
  }
  test::sort_prescribed(scene);
  return scene;
}

// Truth: P = mu (F - F^-T) at constant volume, so the shear stress is mu gamma and nothing pulls at the
// plane y = 0 along y.
TEST(FiniteStretchAnalytic, SimpleShear) {
  const double gamma = 0.5;
  Matrix3d F = Matrix3d::Identity();
  F(0, 1) = gamma;
  const Scene scene = mapped_block(3, F);
  for (const int degree : {1, 2}) {
    const Answer answer = test::solved(scene, options_of(degree)).answer;
    EXPECT_LT(test::largest_error(scene, answer.displacement,
                                  [&](const Vec3& x) -> Vec3 {
                                    return {gamma * x[1], 0, 0};
                                  }),
              1e-10 * L);
    EXPECT_NEAR(*answer.strain_energy, mu / 2 * gamma * gamma * 4 * L * h * h, 1e-9 * mu * L * h * h);
    Vec3 held{};
    for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
      if (scene.prescribed[i].held)
        held[std::size_t(scene.prescribed[i].component)] += answer.reaction[i];
    EXPECT_NEAR(held[0], -mu * gamma * L * 2 * h, 1e-8 * mu * L * h);
    EXPECT_NEAR(held[1], 0, 1e-8 * mu * L * h);
  }
}

// Truth: turned matter is not strained.
TEST(FiniteStretchAnalytic, RigidTurnCostsNothing) {
  const Vector3d axis = Vector3d(1, 2, -1).normalized();
  for (const bool has_law : {true, false}) {
    Scene scene = test::box_scene(3, {4, 2, 2}, {h, h, h});
    scene.strain = Strain::finite;
    scene.materials[0] = has_law ? with_law(NeoHookean{mu, lambda}) : test::material_of(test::fibrous());
    Turn turn;
    turn.axis = {axis[0], axis[1], axis[2]};
    turn.angle = std::numbers::pi / 3;
    test::turn_face(scene, false, turn);
    test::turn_face(scene, true, turn);
    for (const int degree : {1, 2}) {
      const Answer answer = test::solved(scene, options_of(degree)).answer;
      EXPECT_LT(*answer.strain_energy, 1e-14 * E * 4 * L * h * h);
      EXPECT_LT(test::largest_error(scene, answer.displacement,
                                    [&](const Vec3& x) { return turn.displacement(x); }),
                1e-9 * L);
    }
  }
}

/// A bar three times as long as high, one cell thick, clamped at one end and pulled across at the other.
Scene bent_bar(int cells_across, double poisson_ratio) {
  const int n = cells_across;
  const double spacing = 4 * h / n;
  Scene scene = test::box_scene(3, {3 * n, n, 1}, {spacing, spacing, 2 * h});
  scene.strain = Strain::finite;
  const double G = E / (2 * (1 + poisson_ratio));
  scene.materials[0] = with_law(NeoHookean{G, 2 * G * poisson_ratio / (1 - 2 * poisson_ratio)});
  test::hold_face(scene, 0, false);
  test::pull_face(scene, 0, true, {0, 0.005 * E, 0});
  return scene;
}

double tip(const Scene& scene, int degree) {
  const Index3& n = scene.specimen.grid.cells();
  return test::solved(scene, options_of(degree))
      .answer.displacement(1, scene.specimen.grid.node({n[0], n[1] / 2, 0}));
}

// Truth: the same by cells a quarter or half as large. Linear elements of full integration lose four fifths
// of the deflection here.
TEST(FiniteBarConsistent, DoesNotLockNearIncompressibility) {
  const double fine = tip(bent_bar(8, 0.4999), 2);
  EXPECT_NEAR(tip(bent_bar(2, 0.4999), 2), fine, 0.02 * fine);
  EXPECT_NEAR(tip(bent_bar(4, 0.4999), 1), fine, 0.06 * fine);
  Scene linear = bent_bar(4, 0.4999);
  linear.strain = Strain::small;
  EXPECT_LT(tip(linear, 1), 0.3 * fine);
}

// Truth: linear elasticity, from which finite strain differs in proportion to the load. Plane stress has no
// pressure of its own, so that the elements agree too.
TEST(FiniteBarConsistent, SmallLoadsGiveTheLinearAnswer) {
  for (const bool has_law : {true, false})
    for (const int degree : {1, 2}) {
      std::array<double, 2> difference{};
      for (const int i : {0, 1}) {
        Scene scene = test::box_scene(2, {6, 3, 1}, {h, h, h});
        scene.plane = PlaneAssumption::stress;
        scene.materials[0] = with_law(NeoHookean{mu, lambda});
        if (!has_law)
          scene.materials[0].law.reset();
        test::hold_face(scene, 0, false);
        test::pull_face(scene, 0, true, {i == 0 ? 1e-3 * E : 1e-4 * E, 1e-4 * E, 0});
        const Answer linear = test::solved(scene, options_of(degree)).answer;
        scene.strain = Strain::finite;
        difference[i] =
            compare(scene, test::solved(scene, options_of(degree)).answer.displacement, linear.displacement)
                .relative_max;
      }
      EXPECT_LT(difference[0], 0.05);
      EXPECT_LT(difference[1], 0.3 * difference[0]);
    }
}

// Truth: the promise of finite_problem.cpp: increments halve, and a shortened one is no answer.
TEST(FiniteIncrementsContract, ReachLargeStretchOrSayWhatTheyReach) {
  Scene scene = test::box_scene(3, {6, 2, 2}, {h, h, h});
  scene.strain = Strain::finite;
  scene.materials[0] = with_law(NeoHookean{mu, 100 * mu});
  test::hold_face(scene, 0, false);
  Scene torn = scene;
  test::move_face(scene, 0, true, {0.4 * 6 * h, 0, 0});
  const Answer answer = test::solved(scene, options_of(2)).answer;
  EXPECT_EQ(answer.algorithm.substr(0, 21), "total Lagrange, Q2-P1");
  EXPECT_LT(answer.residual, 1e-8);
  double pull = 0; // mean nominal stress of cells in balance with the end
  const CellFields of = cell_fields(scene, answer);
  for (std::size_t cell = 0; cell < of.strain.size(); ++cell)
    pull -= maille::nominal(of.strain[cell], of.stress[cell])[0] * h * h / 6;
  EXPECT_NEAR(pull, test::total_reaction(scene, answer, 0, true), -0.02 * pull);
  test::move_face(torn, 0, true, {-1.2 * 6 * h, 0, 0});
  const Answer failed = fem_ref::solve(torn, options_of(1)).answer;
  EXPECT_EQ(failed.status, Status::failed);
  EXPECT_EQ(failed.message.substr(0, 18), "no balance beyond ");
  EXPECT_TRUE(failed.displacement.empty());
}

TEST(FiniteIncrementsContract, StopWhereTheyAreAsked) {
  Scene scene = bent_bar(4, 0.3);
  Control control;
  int asked = 0;
  control.stop_requested = [&] { return ++asked > 2; };
  const Answer answer = fem_ref::solve(scene, options_of(1), control).answer;
  EXPECT_EQ(answer.status, Status::interrupted);
}

TEST(FiniteRefusalContract, SaysWhatFiniteStrainCannot) {
  Scene line = test::box_scene(1, {4, 1, 1});
  test::hold_face(line, 0, false);
  line.strain = Strain::finite;
  EXPECT_EQ(fem_ref::solve(line, options_of(1)).answer.message,
            "finite strain is for bodies of two and three dimensions");
  Scene sliding = bent_bar(2, 0.3);
  sliding.specimen.label.assign(static_cast<std::size_t>(sliding.specimen.grid.n_cells()), 1);
  for (std::int64_t cell = 0; cell < sliding.specimen.grid.n_cells(); ++cell)
    if (sliding.specimen.grid.cell_at(cell)[1] == 1)
      sliding.specimen.label[static_cast<std::size_t>(cell)] = 2;
  sliding.sliding = {{1, 2}};
  const Answer refused = fem_ref::solve(sliding, options_of(1)).answer;
  EXPECT_EQ(refused.status, Status::refused);
  EXPECT_EQ(refused.message, "finite strain knows no sliding borders");
}

// Truth: dolfinx (FEniCS), a program of other authors, with the same element and an energy of its own words;
// it solves for dilatation and pressure together with the displacement.
TEST(FiniteDolfinxIndependent, StretchShearAndTwist) {
  const double G = 4e3, lame = 6e3;
  for (const auto& [name, by] : {std::pair{"stretch", 2.4e-3}, {"shear", 1.6e-3}, {"twist", 0.8}}) {
    SCOPED_TRACE(name);
    const std::string command = fmt::format("{} {}/finite_strain_witness.py {} 6 2 2 {} {} {} {}",
                                            MAILLE_PYTHON, MAILLE_WITNESSES, name, L / 4, G, lame, by);
    std::FILE* const pipe = popen(command.c_str(), "r");
    Scene scene = test::box_scene(3, {6, 2, 2}, {L / 4, L / 4, L / 4});
    scene.strain = Strain::finite;
    scene.materials[0] = with_law(NeoHookean{G, lame});
    Displacement witness(scene.specimen.grid);
    std::array<double, 6> x{};
    std::int64_t nodes = 0;
    for (; std::fscanf(pipe, "%lf %lf %lf %lf %lf %lf", &x[0], &x[1], &x[2], &x[3], &x[4], &x[5]) == 6;
         ++nodes) {
      Index3 at;
      for (std::size_t a = 0; a < 3; ++a)
        at[a] = static_cast<int>(std::lround(x[a] / (L / 4)));
      for (int c = 0; c < 3; ++c)
        witness(c, scene.specimen.grid.node(at)) = x[std::size_t(3 + c)];
    }
    if (const int status = pclose(pipe); WIFEXITED(status) && WEXITSTATUS(status) == 77)
      GTEST_SKIP() << "python3-dolfinx is not installed";
    ASSERT_EQ(nodes, scene.specimen.grid.n_nodes());
    test::hold_face(scene, 0, false);
    if (std::string_view(name) == "twist") {
      Turn turn;
      turn.axis = {1, 0, 0};
      turn.angle = by;
      turn.about = {0, L / 4, L / 4};
      test::turn_face(scene, true, turn);
    } else {
      const bool is_stretch = std::string_view(name) == "stretch";
      test::move_face(scene, 0, true, {is_stretch ? by : 0, is_stretch ? 0 : by, 0});
    }
    const Answer answer = test::solved(scene, options_of(2)).answer;
    EXPECT_LT(compare(scene, answer.displacement, witness).relative_max, 1e-7);
  }
}

struct NamedMatter {
  std::string name;
  std::optional<Law> law;
};

// Truth: the closed forms of stress and tangent in materials/, of which the energies here share nothing:
// P = F S, dP = dF S + F dS.
TEST(FiniteLawOracle, AutomaticDerivativesAgreeWithClosedForms) {
  const std::vector<NamedMatter> all{{"neo-Hookean", NeoHookean{3e3, 20e3}},
                                     {"Mooney-Rivlin", MooneyRivlin{2e3, 1e3, 50e3}},
                                     {"Guccione", Guccione{2e3, 8, 2, 4, 100e3}},
                                     {"Holzapfel", HolzapfelGasserOgden{3e3, 5e3, 2, 0.1, 100e3}},
                                     {"muscle", Muscle{500, 600, 0.05, 6.6, 1.1, 1.4, 300e3, 0.5, 1e6, 700}},
                                     {"corotated", std::nullopt}};
  constexpr int at[6][2]{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1, 1);
  for (const auto& [name, law] : all)
    for (int trial = 0; trial < 100; ++trial) {
      SCOPED_TRACE(fmt::format("{}, trial {}", name, trial));
      const Matrix3d noise =
                         Matrix3d::NullaryExpr([&] { return (trial % 3 == 0 ? 1e-6 : 0.25) * any(random); }),
                     turn = Eigen::Quaterniond(any(random), any(random), any(random), any(random))
                                .normalized()
                                .toRotationMatrix();
      const Matrix3d F = turn * (Matrix3d::Identity() + noise),
                     strain = 0.5 * (F.transpose() * F - Matrix3d::Identity());
      fem_ref::Matter matter;
      matter.law = law ? &*law : nullptr;
      matter.stiffness = turned(stiffness(test::orthotropic()), turn);
      matter.fibre = Vector3d(any(random), any(random), any(random)).normalized();
      const LawResponse closed =
          law ? respond(*law, strain, matter.fibre) : respond_corotated(matter.stiffness, strain);
      const fem_ref::PointResponse found = respond_at(matter, F, std::nullopt);
      Matrix3d S;
      for (int p = 0; p < 6; ++p)
        S(at[p][0], at[p][1]) = S(at[p][1], at[p][0]) = closed.stress[p];
      const double size = closed.tangent.cwiseAbs().maxCoeff();
      EXPECT_NEAR(found.strain_energy, closed.energy, 1e-12 * size);
      const Matrix3d P = F * S;
      for (int k = 0; k < 9; ++k) {
        Matrix3d dF = Matrix3d::Zero();
        dF(k / 3, k % 3) = 1;
        EXPECT_NEAR(found.gradient(k), P(k / 3, k % 3), 1e-10 * size);
        const Matrix3d dE = 0.5 * (dF.transpose() * F + F.transpose() * dF);
        Vector6 e;
        for (int p = 0; p < 6; ++p)
          e[p] = (p < 3 ? 1 : 2) * dE(at[p][0], at[p][1]);
        const Vector6 s = closed.tangent * e;
        Matrix3d dS;
        for (int p = 0; p < 6; ++p)
          dS(at[p][0], at[p][1]) = dS(at[p][1], at[p][0]) = s[p];
        const Matrix3d dP = dF * S + F * dS;
        for (int j = 0; j < 9; ++j)
          EXPECT_NEAR(found.hessian(k, j), dP(j / 3, j % 3), 1e-10 * size);
      }
    }
}

} // namespace
} // namespace maille
