/// What an answer says of forces, strain, stress and energy.
#include "maille/scene/mechanics/mechanics.hpp"

#include "support/bodies/scenes.hpp"
#include "support/dice.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>

namespace maille {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using Gradient = std::array<Vec3, 3>;

Matrix3d matrix(const Gradient& g) {
  Matrix3d m;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      m(row, column) = g[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
  return m;
}

/// A box of 4 x 3 x 2 cells, labels 5 and 17 of two materials, the second in its upper half along x.
Scene two_labels() {
  Scene scene = test::box_scene(3, {4, 3, 2}, {1e-3, 2e-3, 1.5e-3});
  Material firm;
  firm.name = "firm";
  firm.elasticity = ElasticConstants::isotropic(40e3, 0.4);
  scene.materials.push_back(firm);
  Specimen& body = scene.specimen;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const bool is_upper = body.grid.cell_at(cell)[0] >= 2;
    body.material_id.push_back(is_upper ? 1 : 0);
    body.label.push_back(is_upper ? 17 : 5);
  }
  body.fibre = {0.48, 0.6, 0.64};
  return scene;
}

/// Somewhere in the world, in a frame of the other handedness.
Placement mirrored() {
  Placement placement;
  placement.origin = {0.1, -0.2, 0.3};
  Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -2).normalized()).toRotationMatrix();
  turn.col(1) *= -1;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      placement.direction[row][column] =
          turn(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
  return placement;
}

Answer answer_of(Displacement u, std::string method = "coupled") {
  Answer answer;
  answer.method = std::move(method);
  answer.displacement = std::move(u);
  return answer;
}

Displacement random_displacement(const Scene& scene, double size, unsigned seed) {
  std::mt19937 random(seed);
  tests::Dice dice{random};
  Displacement u(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
    for (int b = 0; b < scene.dimension(); ++b)
      u(b, node) = dice.between(-size, size);
  return u;
}

void expect_uniform(const std::optional<Spread>& spread, double value, double tolerance) {
  ASSERT_TRUE(spread.has_value());
  for (double Spread::*figure : {&Spread::mean, &Spread::least, &Spread::most, &Spread::percentile_5,
                                 &Spread::median, &Spread::percentile_95})
    EXPECT_NEAR((*spread).*figure, value, tolerance);
}

// Truth: Hooke's law by Lame's constants, Eigen's eigenvalues, V det F.
TEST(MechanicsAnalytic, UniformStrainOfTwoLabels) {
  Scene scene = two_labels();
  scene.active_stress.assign(24, 0); // to have fibres
  scene.specimen.placement = mirrored();
  const Gradient gradient{{{0.03, 0.01, -0.02}, {0.005, -0.01, 0.02}, {0, 0.015, 0.02}}};
  const Matrix3d G = matrix(gradient), e = (G + G.transpose()) / 2;
  const Vector3d a(0.48, 0.6, 0.64), principal = Eigen::SelfAdjointEigenSolver<Matrix3d>(e).eigenvalues();
  const Mechanics found =
      mechanics_of(scene, answer_of(test::affine_displacement<Displacement>(scene, gradient)));
  ASSERT_EQ(found.labels.size(), 2u);
  ASSERT_EQ(found.materials.size(), 2u);
  const double cell = 1e-3 * 2e-3 * 1.5e-3;
  for (std::size_t i = 0; i < 2; ++i) {
    const PartMechanics& part = found.labels[i];
    EXPECT_EQ(part.label, i == 0 ? 5 : 17);
    EXPECT_EQ(part.material, i == 0 ? "soft" : "firm");
    EXPECT_EQ(part.cells, 12);
    EXPECT_NEAR(part.volume_at_rest, 12 * cell, 1e-20);
    EXPECT_NEAR(part.volume, 12 * cell * (Matrix3d::Identity() + G).determinant(), 1e-20);
    const double E = i == 0 ? 10e3 : 40e3, nu = i == 0 ? 0.3 : 0.4, mu = E / (2 + 2 * nu),
                 lambda = E * nu / ((1 + nu) * (1 - 2 * nu));
    const Matrix3d s = 2 * mu * e + lambda * e.trace() * Matrix3d::Identity(),
                   deviator = s - s.trace() / 3 * Matrix3d::Identity();
    expect_uniform(part.fibre_strain, a.dot(e * a), 1e-14);
    expect_uniform(part.largest_strain, principal[2], 1e-14);
    expect_uniform(part.smallest_strain, principal[0], 1e-14);
    expect_uniform(part.fibre_stress, a.dot(s * a), 1e-8);
    expect_uniform(part.von_mises, std::sqrt(1.5) * deviator.norm(), 1e-8);
    expect_uniform(part.pressure, -s.trace() / 3, 1e-8);
    EXPECT_NEAR(part.strain_energy.value(), 12 * cell * 0.5 * s.cwiseProduct(e).sum(), 1e-16);
    EXPECT_EQ(found.materials[i].strain_energy, part.strain_energy);
  }
  EXPECT_TRUE(found.energy_is_of_means);
}

// Truth: the whole is the sum of its parts.
TEST(MechanicsAnalytic, LabelsAndMaterialsAddUpToTheBody) {
  const Scene scene = two_labels();
  Answer answer = answer_of(random_displacement(scene, 2e-4, 1));
  for (std::int64_t cell = 0; cell < 24; ++cell)
    answer.cell_energy.push_back(1e-6 * static_cast<double>(cell * cell % 7));
  const Mechanics found = mechanics_of(scene, answer);
  for (const auto* parts : {&found.labels, &found.materials}) {
    PartMechanics sum;
    double energy = 0, strain = 0;
    for (const PartMechanics& part : *parts) {
      sum.cells += part.cells;
      sum.volume += part.volume;
      energy += part.strain_energy.value();
      strain += part.largest_strain->mean * static_cast<double>(part.cells) / 24;
    }
    EXPECT_EQ(sum.cells, found.body.cells);
    EXPECT_NEAR(sum.volume, found.body.volume, 1e-10 * found.body.volume);
    EXPECT_NEAR(energy, found.body.strain_energy.value(), 1e-10 * energy);
    EXPECT_NEAR(strain, found.body.largest_strain->mean, 1e-12);
  }
  EXPECT_FALSE(found.energy_is_of_means);
}

// Truth: one thread. Two of the cells are without matter, so parts of the grid have unlike numbers of cells.
TEST(MechanicsContract, AnyNumberOfThreadsGivesTheSameFigures) {
  Scene scene = two_labels();
  scene.specimen.material_id[1] = scene.specimen.material_id[17] = no_material;
  const Answer answer = answer_of(random_displacement(scene, 2e-4, 5));
  const Mechanics one = mechanics_of(scene, answer);
  for (const int threads : {2, 5}) {
    const Mechanics several = mechanics_of(scene, answer, {}, threads);
    ASSERT_EQ(several.labels.size(), one.labels.size());
    for (std::size_t i = 0; i < one.labels.size(); ++i) {
      EXPECT_EQ(several.labels[i].volume, one.labels[i].volume);
      EXPECT_EQ(several.labels[i].strain_energy, one.labels[i].strain_energy);
      EXPECT_EQ(several.labels[i].von_mises->percentile_95, one.labels[i].von_mises->percentile_95);
      EXPECT_EQ(several.labels[i].largest_strain->mean, one.labels[i].largest_strain->mean);
    }
  }
}

/// Volume of the body between its faces, each a bilinear patch: a sixth of the flux of x through the mean of
/// its two triangulations.
double volume_by_faces(const std::array<Vector3d, 8>& x) {
  constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                               {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  const auto det = [](const Vector3d& a, const Vector3d& b, const Vector3d& c) { return a.dot(b.cross(c)); };
  double volume = 0;
  for (const auto& f : faces) {
    const Vector3d p[4] = {x[static_cast<std::size_t>(f[0])], x[static_cast<std::size_t>(f[1])],
                           x[static_cast<std::size_t>(f[2])], x[static_cast<std::size_t>(f[3])]};
    volume +=
        (det(p[0], p[1], p[2]) + det(p[0], p[2], p[3]) + det(p[0], p[1], p[3]) + det(p[1], p[2], p[3])) / 12;
  }
  return volume;
}

TEST(MechanicsOracle, VolumesAreThoseBetweenBilinearFaces) {
  const Scene scene = two_labels();
  const Displacement u = random_displacement(scene, 4e-4, 2);
  double volume = 0;
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    std::array<Vector3d, 8> x;
    for (int corner = 0; corner < 8; ++corner) {
      const std::int64_t node = grid.corner(grid.cell_at(cell), corner);
      const Vec3 rest = scene.specimen.position(grid.node_at(node));
      for (int b = 0; b < 3; ++b)
        x[static_cast<std::size_t>(corner)][b] = rest[static_cast<std::size_t>(b)] + u(b, node);
    }
    volume += volume_by_faces(x);
  }
  EXPECT_NEAR(mechanics_of(scene, answer_of(u)).body.volume, volume, 1e-13 * volume);
}

// Truth: the cells in ascending order, until so much of the volume has gone by.
TEST(MechanicsOracle, PercentilesCountVolume) {
  Scene scene = test::box_scene(1, {101, 1, 1});
  const Displacement u = random_displacement(scene, 1e-4, 3);
  const Mechanics found = mechanics_of(scene, answer_of(u));
  std::vector<double> strain;
  for (std::int64_t cell = 0; cell < 101; ++cell)
    strain.push_back((u(0, cell + 1) - u(0, cell)) / 1e-3);
  std::vector<double> pressure = strain;
  std::ranges::sort(pressure, std::greater());
  for (double& p : pressure)
    p *= -10e3 / 3;
  const auto percentile = [&](double part) {
    double gone = 0;
    for (const double p : pressure)
      if ((gone += 1e-3) >= part * 0.101 * (1 - 1e-12))
        return p;
    return std::numeric_limits<double>::quiet_NaN();
  };
  ASSERT_TRUE(found.body.pressure.has_value());
  const Spread& spread = *found.body.pressure;
  EXPECT_NEAR(spread.percentile_5, percentile(0.05), 1e-9);
  EXPECT_NEAR(spread.median, percentile(0.5), 1e-9);
  EXPECT_NEAR(spread.percentile_95, percentile(0.95), 1e-9);
  EXPECT_NEAR(spread.least, pressure.front(), 1e-9);
  EXPECT_NEAR(spread.most, pressure.back(), 1e-9);
}

// Truth: forces node by node, cross products of lever arms, in a world of the other handedness.
TEST(MechanicsOracle, MomentsAreSumsOverNodes) {
  Scene scene = two_labels();
  scene.specimen.placement = mirrored();
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-4, 0, 0});
  scene.conditions = {{"hold[1]", "\"x-\""}, {"move[1]", "\"x+\""}};
  for (Prescribed& p : scene.prescribed)
    p.condition = p.held ? 0 : 1;
  Answer answer = answer_of(Displacement(scene.specimen.grid));
  std::mt19937 random(4);
  tests::Dice dice{random};
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    answer.reaction.push_back(dice.between(-1, 1));
  const Mechanics found = mechanics_of(scene, answer);
  const Matrix3d Q = matrix(scene.specimen.placement.direction);
  const auto place = [&](std::int64_t node) -> Vector3d {
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node));
    return Vector3d(0.1, -0.2, 0.3) + Q * Vector3d(x[0], x[1], x[2]);
  };
  for (const bool held : {true, false}) {
    std::map<std::int64_t, Vector3d> forces;
    for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
      if (const Prescribed& p = scene.prescribed[i]; p.held == held)
        forces.try_emplace(p.node, Vector3d::Zero()).first->second[p.component] = answer.reaction[i];
    Vector3d centroid = Vector3d::Zero(), force = Vector3d::Zero(), moment = Vector3d::Zero();
    for (const auto& [node, f] : forces)
      centroid += place(node) / static_cast<double>(forces.size());
    for (const auto& [node, f] : forces) {
      force += Q * f;
      moment += (place(node) - centroid).cross(Q * f);
    }
    const auto& list = held ? found.holds : found.moves;
    ASSERT_EQ(list.size(), 1u);
    EXPECT_EQ(list[0].name, held ? "hold[1]" : "move[1]");
    for (int b = 0; b < 3; ++b) {
      const auto i = static_cast<std::size_t>(b);
      EXPECT_NEAR(list[0].centroid[i], centroid[b], 1e-15);
      EXPECT_NEAR(list[0].force[i], force[b], 1e-13);
      EXPECT_NEAR(list[0].moment[i], moment[b], 1e-15);
    }
  }
}

// Truth: what is as large as the reference and a tenth is a tenth off, its energy by 21 %.
TEST(MechanicsErrorsAnalytic, ATenthMoreIsATenthOff) {
  Scene scene = two_labels();
  test::hold_face(scene, 0, false);
  test::move_face(scene, 0, true, {1e-4, 0, 0});
  Answer reference = answer_of(random_displacement(scene, 1e-4, 5), "fem_q1");
  reference.strain_energy = 2e-6;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    reference.reaction.push_back(1e-3 * static_cast<double>(i % 5));
  Answer answer = reference;
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
    for (int b = 0; b < 3; ++b)
      answer.displacement(b, node) *= 1.1;
  for (double& force : answer.reaction)
    force *= 1.1;
  answer.strain_energy = 2.42e-6;
  const MechanicsErrors errors = compare_mechanics(scene, answer, reference);
  EXPECT_NEAR(errors.force.value(), 0.1, 1e-12);
  EXPECT_NEAR(errors.strain_energy.value(), 0.21, 1e-12);
  EXPECT_NEAR(errors.strain.value(), 0.1, 1e-12);
  EXPECT_NEAR(errors.stress.value(), 0.1, 1e-12);
}

TEST(MechanicsErrorsContract, ForcesThatCancelAndMethodsWithoutForcesHaveNone) {
  Scene scene = two_labels();
  test::hold_face(scene, 0, false);
  Answer reference = answer_of(random_displacement(scene, 1e-4, 6), "fem_q1");
  reference.strain_energy = 0;
  for (const Prescribed& p : scene.prescribed)
    reference.reaction.push_back(scene.specimen.grid.node_at(p.node)[1] % 2 == 0 ? 1 : -1);
  Answer answer = answer_of(reference.displacement, "limits");
  const MechanicsErrors errors = compare_mechanics(scene, answer, reference);
  EXPECT_FALSE(errors.force || errors.strain_energy || errors.stress);
  EXPECT_EQ(errors.strain, 0.0);
  answer.reaction = reference.reaction;
  EXPECT_FALSE(compare_mechanics(scene, answer, reference).force) << "rows of +1 and -1 pull at nothing";
}

// Truth: counted by hand. A fixed face loses its rim, a part of a face its border.
TEST(MechanicsErrorsAnalytic, CellsAtEdgesAreThoseOfTheRim) {
  Scene face = test::box_scene(3, {5, 5, 5});
  test::hold_face(face, 0, false);
  const auto count = [](const Scene& scene) { return std::ranges::count(cells_at_edges(scene), true); };
  EXPECT_EQ(count(face), 16); // of the 25 cells of the layer
  EXPECT_FALSE(cells_at_edges(face)[static_cast<std::size_t>(face.specimen.grid.cell({0, 2, 2}))]);
  Scene patch = test::box_scene(3, {5, 5, 5});
  for (const int z : {1, 2, 3, 4})
    for (const int y : {1, 2, 3, 4})
      patch.prescribed.push_back({patch.specimen.grid.node({0, y, z}), 0, 1e-4, false});
  EXPECT_EQ(count(patch), 24); // all but the one in the middle
  EXPECT_FALSE(cells_at_edges(patch)[static_cast<std::size_t>(patch.specimen.grid.cell({0, 2, 2}))]);
  Scene plane = test::box_scene(2, {4, 6, 1});
  test::hold_face(plane, 0, false);
  EXPECT_EQ(count(plane), 2);
  Scene bar = test::box_scene(1, {4, 1, 1});
  test::hold_face(bar, 0, false);
  EXPECT_EQ(count(bar), 0);
}

TEST(MechanicsContract, MethodsWithoutStressSayVolumeAndStrainAlone) {
  const Scene scene = two_labels();
  for (const char* method : {"limits", "literal", "dijkstra", "sweep"}) {
    const Mechanics found = mechanics_of(scene, answer_of(random_displacement(scene, 1e-4, 7), method));
    EXPECT_TRUE(found.holds.empty() && found.moves.empty());
    EXPECT_TRUE(found.body.largest_strain && found.body.smallest_strain);
    EXPECT_FALSE(found.body.fibre_strain) << "isotropic";
    EXPECT_FALSE(found.body.von_mises || found.body.pressure || found.body.fibre_stress ||
                 found.body.strain_energy);
    EXPECT_FALSE(found.energy_is_of_means);
  }
}

TEST(MechanicsContract, NumbersThatAreNoneStayWhereTheyAre) {
  const Scene scene = two_labels();
  Displacement u(scene.specimen.grid);
  u(1, 0) = std::numeric_limits<double>::quiet_NaN(); // at a corner of label 5
  const Mechanics found = mechanics_of(scene, answer_of(u));
  EXPECT_TRUE(std::isnan(found.labels[0].von_mises->median));
  expect_uniform(found.labels[1].von_mises, 0, 1e-12);
}

} // namespace
} // namespace maille
