#include "elastic/model/lattice_elasticity.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/scene_builder.hpp"
#include "support/bodies/scenes.hpp"
#include "support/direct_solution.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/oriented_labels.hpp"
#include "support/solved.hpp"

#include <Eigen/Dense>

namespace maille::deform {
namespace {

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * double(random()) / double(std::mt19937::max());
}

/// A body with holes, of two materials that know no symmetry with the grid.
Scene odd_body(int dimension, unsigned seed) {
  std::mt19937 random(seed);
  Scene scene =
      test::box_scene(dimension, {4, dimension > 1 ? 3 : 1, dimension > 2 ? 3 : 1}, {1e-3, 1.4e-3, 0.7e-3});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(25e3, 0.45);
  Specimen& body = scene.specimen;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const double chance = uniform(random, 0, 1);
    body.material_id.push_back(chance < 0.2 ? no_material : chance < 0.6 ? std::uint8_t{0} : std::uint8_t{1});
    const Eigen::Vector3f f =
        Eigen::Vector3f(float(uniform(random, -1, 1)), dimension > 1 ? float(uniform(random, -1, 1)) : 0.0F,
                        dimension > 2 ? float(uniform(random, -1, 1)) : 0.0F)
            .normalized();
    body.fibres.push_back({f[0], f[1], f[2]});
  }
  body.material_id[0] = 0;
  return scene;
}

Displacement random_field(const Scene& scene, unsigned seed) {
  std::mt19937 random(seed);
  Displacement u(scene.specimen.grid);
  for (double& value : u.values())
    value = uniform(random, -1e-4, 1e-4);
  return u;
}

/// The energy as the documentation writes it, cell by cell.
double energy_by_the_formula(const Scene& scene, const Displacement& u) {
  const Grid& grid = scene.specimen.grid;
  double total = 0;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    const Index3 at = grid.cell_at(cell);
    total += test::cell_energy<double>(grid.dimension(), scene.cell_stiffness(cell), grid.spacing(),
                                       test::cells_in_a_row(scene.specimen, at),
                                       [&](int b, int corner) { return u(b, grid.corner(at, corner)); });
  }
  return total;
}

TEST(LatticeElasticityOracle, EnergyIsThatOfTheFormulaCellByCell) {
  for (int dimension = 1; dimension <= 3; ++dimension)
    for (unsigned seed = 1; seed <= 10; ++seed) {
      const Scene scene = odd_body(dimension, seed);
      const Displacement u = random_field(scene, seed + 100);
      Displacement forces(scene.specimen.grid);
      ThreadTeam team(1);
      LatticeElasticity(scene).apply(u, forces, team);
      const double expected = energy_by_the_formula(scene, u);
      EXPECT_NEAR(0.5 * test::product(u, forces), expected, 1e-12 * expected)
          << dimension << "D seed " << seed;
    }
}

TEST(LatticeElasticityOracle, TheOperatorIsSymmetricAndTheDiagonalItsOwn) {
  for (int dimension = 1; dimension <= 3; ++dimension) {
    const Scene scene = odd_body(dimension, 3);
    const LatticeElasticity elasticity(scene);
    const Displacement u = random_field(scene, 1), v = random_field(scene, 2),
                       diagonal = elasticity.diagonal();
    Displacement of_u(scene.specimen.grid), of_v(of_u);
    ThreadTeam team(1);
    elasticity.apply(u, of_u, team);
    elasticity.apply(v, of_v, team);
    EXPECT_NEAR(test::product(v, of_u), test::product(u, of_v), 1e-12 * std::abs(test::product(u, of_u)));
    for (std::size_t i = 0; i < diagonal.values().size(); ++i) {
      Displacement unit(scene.specimen.grid);
      unit.values()[i] = 1;
      elasticity.apply(unit, of_u, team);
      EXPECT_NEAR(diagonal.values()[i], of_u.values()[i], 1e-12 * of_u.values()[i]);
    }
  }
}

TEST(LatticeElasticityAnalytic, RigidMotionsAreAllThatCostsNothing) {
  for (const int dimension : {2, 3}) {
    Scene scene = test::box_scene(dimension, {2, 2, dimension > 2 ? 2 : 1});
    scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, 0.4);
    const LatticeElasticity elasticity(scene);
    const auto n = static_cast<Eigen::Index>(scene.specimen.grid.n_nodes());
    Eigen::MatrixXd K(dimension * n, dimension * n);
    ThreadTeam team(1);
    for (Eigen::Index column = 0; column < K.cols(); ++column) {
      Displacement unit(scene.specimen.grid), forces(scene.specimen.grid);
      unit(column / n, column % n) = 1;
      elasticity.apply(unit, forces, team);
      for (Eigen::Index row = 0; row < K.rows(); ++row)
        K(row, column) = forces(row / n, row % n);
    }
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
    const int rigid = dimension == 2 ? 3 : 6; // shifts and turns
    EXPECT_LE(std::abs(values[rigid - 1]), 1e-12 * values[values.size() - 1]);
    EXPECT_GE(values[rigid], 1e-4 * values[values.size() - 1]);
  }
}

/// Forces at the corners (two a corner) of a rectangle by assumed stresses: constant, xx linear across x, yy
/// linear across y.
/// Source  Pian and Sumihara 1984, Int. J. Numer. Methods Eng. 20: their element on a rectangle
Eigen::Matrix<double, 8, 8> stiffness_by_assumed_stress(const Eigen::Matrix3d& C, double hx, double hy) {
  Eigen::Matrix<double, 5, 5> flexibility = Eigen::Matrix<double, 5, 5>::Zero();
  Eigen::Matrix<double, 5, 8> work = Eigen::Matrix<double, 5, 8>::Zero();
  const double point = std::sqrt(1.0 / 3);
  for (const double x : {-point, point})
    for (const double y : {-point, point}) {
      Eigen::Matrix<double, 3, 5> stress;
      stress << 1, 0, 0, y, 0, 0, 1, 0, 0, x, 0, 0, 1, 0, 0;
      Eigen::Matrix<double, 3, 8> strain = Eigen::Matrix<double, 3, 8>::Zero();
      for (int corner = 0; corner < 4; ++corner) {
        const double sx = corner & 1 ? 1 : -1, sy = corner & 2 ? 1 : -1;
        const double dx = sx * (1 + sy * y) / 2 / hx, dy = sy * (1 + sx * x) / 2 / hy;
        strain(0, 2 * corner) = strain(2, 2 * corner + 1) = dx;
        strain(1, 2 * corner + 1) = strain(2, 2 * corner) = dy;
      }
      flexibility += hx * hy / 4 * stress.transpose() * C.inverse() * stress;
      work += hx * hy / 4 * stress.transpose() * strain;
    }
  return work.transpose() * flexibility.inverse() * work;
}

// Truth: an element that knows nothing of links. In 2D the two are one and the same, however the fibres run.
TEST(LatticeElasticityAnalytic, InThePlaneItIsTheElementOfAssumedStresses) {
  for (const double degrees : {0.0, 20.0, 45.0, 70.0}) {
    Scene scene = test::box_scene(2, {1, 1, 1}, {1e-3, 0.7e-3, 1});
    scene.materials[0].elasticity = // E_fibre / E_cross 506, as of a tendon
        ElasticConstants::transversely_isotropic(157e6, 0.31e6, 0.104e6, 0.49, 0.49);
    scene.specimen.fibre = {std::cos(degrees * std::numbers::pi / 180),
                            std::sin(degrees * std::numbers::pi / 180), 0};
    const LatticeElasticity lattice(scene);
    const Eigen::Matrix<double, 8, 8> K = stiffness_by_assumed_stress(scene.cell_stiffness(0), 1e-3, 0.7e-3);
    for (int i = 0; i < 8; ++i) {
      Eigen::Matrix<double, 3, 4> u = Eigen::Matrix<double, 3, 4>::Zero();
      u(i % 2, i / 2) = 1;
      const Eigen::Matrix<double, 3, 4> force = lattice.cell_forces<2>(0, u);
      for (int j = 0; j < 8; ++j)
        EXPECT_NEAR(force(j % 2, j / 2), K(j, i), 1e-9 * K.cwiseAbs().maxCoeff()) << degrees << " " << i << j;
    }
  }
}

TEST(LatticeElasticityContract, AnyNumberOfThreadsGivesTheSameBits) {
  const Scene scene = odd_body(3, 5);
  const LatticeElasticity elasticity(scene);
  const Displacement u = random_field(scene, 9);
  Displacement one(scene.specimen.grid), several(scene.specimen.grid);
  ThreadTeam alone(1);
  elasticity.apply(u, one, alone);
  for (const int threads : {2, 3, 7}) {
    ThreadTeam team(threads);
    elasticity.apply(u, several, team);
    EXPECT_EQ(one, several) << threads;
  }
}

/// The parts of cells in what elastic methods minimise, and the forces that balance.

Scene scene_of(const std::string& specimen, const std::string& rest) {
  return parse_scene("[specimen]\nshape = \"box\"\nspacing = \"1 mm\"\nmaterial = "
                     "\"muscle/vastus_lateralis\"\n" +
                     specimen + "\n[[hold]]\nwhere = \"x-\"\n" + rest);
}

const std::string in_3d = "cells = [8, 4, 4]\nfibre = { angle = \"20 deg\", plane = \"xz\" }\n";
const std::string pull = "[[move]]\nwhere = \"x+\"\nby = [\"0.4 mm\", 0, \"0.3 mm\"]\n";

double sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

/// @param tolerance  relative: 1e-10 where sums are the only difference
void expect_parts_add_up(const Scene& scene, const char* method, double tolerance) {
  const Answer answer = test::solved(scene, method);
  ASSERT_GT(answer.strain_energy.value(), 0);
  EXPECT_NEAR(sum(cell_energies(scene, answer)) / *answer.strain_energy, 1, tolerance) << answer.algorithm;
}

TEST(CellEnergiesAnalytic, AddUpToWhatCoupledMinimises) {
  expect_parts_add_up(scene_of(in_3d, pull), "coupled", 1e-10);
  expect_parts_add_up(scene_of(in_3d, pull + "[[load]]\ntraction = [0, \"50 Pa\", 0]\nwhere = \"z+\"\n"),
                      "coupled", 1e-10);
  expect_parts_add_up(scene_of("cells = [8, 4]\n", "[[move]]\nwhere = \"x+\"\nby = [0, \"0.3 mm\"]\n"),
                      "coupled", 1e-10);
  expect_parts_add_up(scene_of("cells = [8]\n", "[[move]]\nwhere = \"x+\"\nby = [\"0.3 mm\"]\n"), "coupled",
                      1e-10);
}

TEST(CellEnergiesAnalytic, AddUpWhereFibresContractAndWhereTheBodyIsNoBox) {
  expect_parts_add_up(scene_of(in_3d, "[[load]]\ncontraction = \"3 kPa\"\n"), "coupled", 1e-10);
  expect_parts_add_up(parse_scene(R"([specimen]
shape = "ellipsoid"
cells = [10, 6, 6]
spacing = "1 mm"
material = "muscle/soleus"
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["0.3 mm", 0, "0.2 mm"]
)"),
                      "coupled", 1e-10);
}

// In blocks frames are turned to the accuracy of their iteration.
TEST(CellEnergiesAnalytic, AddUpInBlocks) {
  expect_parts_add_up(scene_of(in_3d,
                               "[[move]]\nwhere = \"x+\"\nby = [0, 0, \"3 mm\"]\n[relaxation]\nframe = "
                               "\"blocks\"\n"),
                      "coupled", 1e-10);
}

// Weights of links are float32.
TEST(CellEnergiesAnalytic, AddUpToWhatRelaxedMinimises) {
  expect_parts_add_up(scene_of(in_3d, pull), "relaxed", 1e-6);
  expect_parts_add_up(scene_of("cells = [8, 4]\n", "[[move]]\nwhere = \"x+\"\nby = [0, \"0.3 mm\"]\n"),
                      "relaxed", 1e-6);
}

TEST(CellEnergiesContract, MethodsWithoutEnergyHaveNone) {
  const Scene scene = scene_of(in_3d, pull);
  EXPECT_TRUE(cell_energies(scene, solve(scene, "limits")).empty());
  EXPECT_TRUE(cell_energies(scene, refusal("coupled", "no reason")).empty());
}

// Truth: a body at rest is in balance: forces on it and their moments about any place add up to nothing.
TEST(ResultantsAnalytic, ForcesAndMomentsOnTheBodyBalance) {
  for (const char* frame : {"object", "blocks"}) {
    const Scene scene =
        scene_of(in_3d, pull +
                            "[[load]]\ntraction = [0, \"200 Pa\", \"90 Pa\"]\nwhere = \"z+\"\n"
                            "[[load]]\ngravity = [0, 0, -9.81]\n"
                            "[relaxation]\ntolerance = 1e-10\nframe = \"" +
                            frame + "\"\n");
    const Answer answer = test::solved(scene, "coupled");
    const Mechanics found = mechanics_of(scene, answer, cell_energies(scene, answer));
    ASSERT_EQ(found.holds.size(), 1u);
    ASSERT_EQ(found.moves.size(), 1u);
    ASSERT_EQ(found.loads.size(), 2u);
    EXPECT_EQ(found.loads[0].name, "load[1]");
    EXPECT_EQ(found.loads[0].where, "z+");
    EXPECT_EQ(found.loads[1].name, "gravity");
    Vec3 force{}, moment{};
    double size = 0;
    for (const auto* list : {&found.holds, &found.moves, &found.loads})
      for (const Resultant& r : *list)
        for (std::size_t a = 0; a < 3; ++a) {
          force[a] += r.force[a];
          moment[a] += r.moment[a] + r.centroid[(a + 1) % 3] * r.force[(a + 2) % 3] -
                       r.centroid[(a + 2) % 3] * r.force[(a + 1) % 3];
          size += std::abs(r.force[a]);
        }
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(force[a], 0, 1e-6 * size) << frame;
      EXPECT_NEAR(moment[a], 0, 1e-6 * size * 8e-3) << frame;
    }
  }
}

std::string face(std::size_t axis, bool upper, const test::Orientation& to) {
  for (std::size_t a = 0; a < 3; ++a)
    if (to.axis[a] == axis)
      return {"xyz"[a], upper != to.flipped[a] ? '+' : '-'};
  return {};
}

Vec3 vector(const Vec3& v, const test::Orientation& to) {
  Vec3 turned{};
  for (std::size_t a = 0; a < 3; ++a)
    turned[a] = v[to.axis[a]] * (to.flipped[a] ? -1 : 1);
  return turned;
}

/// A bent body of two labels that is pulled, in an array of some orientation.
Mechanics mechanics_in(const test::Orientation& to) {
  const test::LabelArray array = turned(test::bent_body(), to);
  Material firm;
  firm.name = "firm";
  firm.elasticity = ElasticConstants::isotropic(30e3, 0.4);
  RelaxationSettings relaxation;
  relaxation.tolerance = 1e-11;
  const Scene scene = SceneBuilder()
                          .material(17, "muscle/soleus")
                          .material(5, firm)
                          .labels(std::vector<std::int32_t>(array.values.begin(), array.values.end()),
                                  ArrayLayout::x_fastest(array.size), array.affine)
                          .fibre(vector({0.48, 0.6, 0.64}, to))
                          .hold(face(2, false, to))
                          .move(face(2, true, to), vector({1e-4, -2e-4, 3e-4}, to))
                          .relaxation(relaxation)
                          .build();
  const Answer answer = test::solved(scene, "coupled");
  return mechanics_of(scene, answer, cell_energies(scene, answer));
}

void expect_near(const std::optional<Spread>& found, const std::optional<Spread>& expected, double size) {
  ASSERT_TRUE(found && expected);
  for (double Spread::*figure : {&Spread::mean, &Spread::least, &Spread::most, &Spread::percentile_5,
                                 &Spread::median, &Spread::percentile_95})
    EXPECT_NEAR((*found).*figure, (*expected).*figure, 1e-5 * size);
}

// Truth: physics does not depend on the order in which an array stores voxels; affines are of float32.
TEST(MechanicsAnalytic, LabelsAndForcesAreTheSameInAllOrdersOfAxes) {
  const Mechanics expected = mechanics_in({});
  ASSERT_EQ(expected.labels.size(), 2u);
  for (const test::Orientation& to : test::all_orientations()) {
    SCOPED_TRACE(testing::Message() << "axes " << to.axis[0] << to.axis[1] << to.axis[2] << ", flipped "
                                    << to.flipped[0] << to.flipped[1] << to.flipped[2]);
    const Mechanics found = mechanics_in(to);
    ASSERT_EQ(found.labels.size(), 2u);
    for (std::size_t i = 0; i < 2; ++i) {
      const PartMechanics &part = found.labels[i], &wanted = expected.labels[i];
      EXPECT_EQ(part.label, wanted.label);
      EXPECT_EQ(part.material, wanted.material);
      EXPECT_EQ(part.cells, wanted.cells);
      EXPECT_NEAR(part.volume / wanted.volume, 1, 1e-6);
      EXPECT_NEAR(*part.strain_energy / *wanted.strain_energy, 1, 1e-5);
      const double strain = wanted.largest_strain->most, stress = wanted.von_mises->most;
      expect_near(part.fibre_strain, wanted.fibre_strain, strain);
      expect_near(part.largest_strain, wanted.largest_strain, strain);
      expect_near(part.smallest_strain, wanted.smallest_strain, strain);
      expect_near(part.fibre_stress, wanted.fibre_stress, stress);
      expect_near(part.von_mises, wanted.von_mises, stress);
      expect_near(part.pressure, wanted.pressure, stress);
    }
    const Resultant &pulled = found.moves.at(0), &wanted = expected.moves.at(0);
    const double size = std::hypot(wanted.force[0], wanted.force[1], wanted.force[2]);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(pulled.centroid[a], wanted.centroid[a], 1e-8);
      EXPECT_NEAR(pulled.force[a], wanted.force[a], 1e-5 * size);
      EXPECT_NEAR(pulled.moment[a], wanted.moment[a], 1e-5 * size * 1e-2);
    }
  }
}

} // namespace
} // namespace maille::deform
