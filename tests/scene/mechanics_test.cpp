/// What an answer says of forces, strain, stress and energy.

#include "maille/mechanics/recovery.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "support/bodies/scenes.hpp"
#include "support/dice.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>

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
  test::Dice dice{random};
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
  test::Dice dice{random};
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

/// Strain and stress at nodes, recovered from those of cells.

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
  const auto n = std::size_t(specimen.grid.n_cells());
  CellFields cells{std::vector<Tensor>(n), std::vector<Tensor>(n), std::vector<double>(n)};
  for (std::size_t c = 0; c < n; ++c) {
    const auto cell = std::int64_t(c);
    for (std::size_t k = 0; k < 6 && specimen.is_matter(cell); ++k) {
      cells.stress[c][k] =
          double(k + 1) * field(place(specimen.grid.cell_at(cell), 0.5), specimen.material(cell));
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
        const double expected = double(k + 1) * field(place(at, 0), scene.specimen.material(cell));
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
  test::Dice dice{random};
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
  CellFields cells = cells_of(
      scene, [](const Vec3& x, int) { return (int(x[0]) + int(x[1]) + int(x[2])) % 2 == 0 ? 1.0 : -1.0; });
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
      raw += volume * std::pow(fields.stress[std::size_t(cell)][0] - expected, 2);
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
  test::Dice dice{random};
  const Index3 cells{5, 6, 7};
  std::vector<double> value;
  std::vector<std::uint8_t> material;
  for (int i = 0; i < 5 * 6 * 7; ++i) {
    value.push_back(dice.between(-1, 1));
    material.push_back(dice.between(0, 1) < 0.35 ? no_material : std::uint8_t{0});
  }
  const auto number = [&](const Index3& at) {
    return std::size_t(at[0] + cells[0] * (at[1] + cells[1] * at[2]));
  };
  const auto unturned = [](const Index3& at) { return Index3{at[2], at[0], at[1]}; };
  const auto recover = [&](const Index3& size, const std::function<Index3(const Index3&)>& own) {
    Scene scene = body(3, size, [&](const Index3& at) { return material[number(own(at))]; });
    const auto field = [&](const Vec3& x, int) {
      return value[number(own({int(x[0]), int(x[1]), int(x[2])}))];
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
  EXPECT_NEAR(shown.stress[std::size_t(grid.node({2, 1, 0}))][0], 1, 1e-12) << "three of four";
  EXPECT_NEAR(shown.stress[std::size_t(grid.node({0, 0, 0}))][0], 2, 1e-12);
  EXPECT_NEAR(shown.stress[std::size_t(grid.node({1, 1, 0}))][0], 2, 1e-12) << "the first of two";
}

} // namespace
} // namespace maille
