/// Springs to the ground, weights of cells, sliding borders and contraction that turns, against closed forms.

#include "maille/deform/solve.hpp"
#include "maille/mechanics/recovery.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/scene_builder.hpp"
#include "maille/scene/sliding.hpp"
#include "support/bodies/layers.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

namespace maille::deform {
namespace {

constexpr double h = 1e-3, E1 = 100e3, E2 = 40e3, nu1 = 0.3, nu2 = 0.45;

/// A column whose lower end glides on a plane, with what it takes to keep it from moving sideways.
Scene column(const Index3& cells, double E, double nu) {
  Scene scene;
  scene.specimen.shape = "box";
  scene.specimen.grid = Grid(3, cells, {h, h, h});
  scene.materials = {test::isotropic(E, nu)};
  scene.relaxation.tolerance = 1e-9;
  test::add_prescribed(scene, {0, 0, 0}, 0, 0, true);
  test::add_prescribed(scene, {0, 0, 0}, 1, 0, true);
  test::add_prescribed(scene, {cells[0], 0, 0}, 1, 0, true);
  return scene;
}

/// Components along z of a whole plane of nodes.
void prescribe_plane(Scene& scene, int plane, double value, bool held) {
  const Index3& n = scene.specimen.grid.nodes();
  for (int y = 0; y < n[1]; ++y)
    for (int x = 0; x < n[0]; ++x)
      test::add_prescribed(scene, {x, y, plane}, 2, value, held);
}

/// A pressed column on springs: it sinks by p / k and is pressed together by p L / E.
void expect_column_on_springs(const char* method, double modulus) {
  constexpr double p = 2e3, k = 1e7;
  const Index3 cells{3, 4, 6};
  Scene scene = column(cells, E1, nu1);
  for (int y = 0; y < cells[1]; ++y)
    for (int x = 0; x < cells[0]; ++x) {
      scene.springs.push_back({scene.specimen.grid.cell({x, y, 0}), 2, false, k, {0, 0, 1}});
      scene.tractions.push_back({scene.specimen.grid.cell({x, y, cells[2] - 1}), 2, true, {0, 0, -p}});
    }
  test::sort_prescribed(scene);
  const Answer answer = test::solved(scene, method);
  for (int z = 0; z <= cells[2]; ++z) {
    const double expected = -p / k - p * z * h / modulus;
    EXPECT_NEAR(answer.displacement(2, scene.specimen.grid.node({1, 2, z})), expected, 1e-6 * p / k)
        << method;
  }
  const double volume = cells[0] * cells[1] * cells[2] * h * h * h;
  EXPECT_NEAR(*answer.strain_energy, 0.5 * p * p / modulus * volume, 1e-6 * p * p / modulus * volume);
}

TEST(FoundationAnalytic, AColumnOnSpringsSinksAsHookeSays) {
  expect_column_on_springs("coupled", E1);
  // `relaxed` lets nothing give way sideways.
  expect_column_on_springs("relaxed", E1 * (1 - nu1) / ((1 + nu1) * (1 - 2 * nu1)));
}

TEST(FoundationAnalytic, SpringsAloneKeepABodyInPlace) {
  Scene scene = column({3, 3, 3}, E1, nu1);
  scene.prescribed.clear();
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x)
      scene.springs.push_back({scene.specimen.grid.cell({x, y, 0}), 2, false, 1e6, {}});
  scene.gravity = {0, 0, -10};
  EXPECT_EQ(remaining_rigid_motion(scene), "");
  const Answer answer = test::solved(scene, "coupled");
  const double weight = scene.materials[0].density * 10 * 27 * h * h * h;
  double carried = 0;
  for (const NodalSpring& spring : nodal_springs(scene))
    carried += pull_of(spring, answer.displacement)[2];
  EXPECT_NEAR(carried, weight, 1e-6 * weight);
  for (FaceSpring& spring : scene.springs)
    spring.direction = {0, 0, 1};
  EXPECT_NE(remaining_rigid_motion(scene), "");
  EXPECT_EQ(solve(scene, "coupled").status, Status::refused);
  EXPECT_EQ(solve(scene, "limits").status, Status::refused);
}

TEST(CellWeightsAnalytic, ColumnsOfUnequalStiffnessAreInSeries) {
  Scene scene = column({3, 3, 6}, E1, 0);
  prescribe_plane(scene, 0, 0, true);
  prescribe_plane(scene, 6, 1e-4, false);
  test::sort_prescribed(scene);
  scene.specimen.stiffness_ratio.assign(54, 1);
  for (std::size_t cell = 27; cell < 54; ++cell)
    scene.specimen.stiffness_ratio[cell] = 4;
  const double expected = 1e-4 * 9 * h * h / (3 * h / E1 + 3 * h / (4 * E1));
  for (const char* method : {"coupled", "relaxed"}) {
    const Answer answer = test::solved(scene, method);
    EXPECT_NEAR(test::force_of_moves(scene, answer), expected, 1e-6 * expected) << method;
  }
}

TEST(CellWeightsAnalytic, CellsThatAreTissueInPartCarryTheirPart) {
  Scene scene = column({4, 3, 5}, E1, nu1);
  prescribe_plane(scene, 0, 0, true);
  prescribe_plane(scene, 5, 1e-4, false);
  test::sort_prescribed(scene);
  scene.specimen.tissue.assign(60, 1);
  for (std::size_t cell = 3; cell < 60; cell += 4)
    scene.specimen.tissue[cell] = 0.25F;
  const Answer answer = test::solved(scene, "coupled");
  const double expected = E1 * 1e-4 / (5 * h) * 3.25 * 3 * h * h; // one stress everywhere, whatever Poisson's
  EXPECT_NEAR(test::force_of_moves(scene, answer), expected, 1e-6 * expected);
  const CellFields fields = cell_fields(scene, answer);
  EXPECT_NEAR(fields.stress[3][2], E1 * 1e-4 / (5 * h), 1); // of the tissue
}

/// Two blocks of n x n x 4 and n x n x 6 cells on each other, labels 1 and 2, pressed by `shift` on top.
Scene two_blocks(int n, double shift) {
  std::vector<std::uint8_t> labels(static_cast<std::size_t>(n * n * 10), 1);
  std::fill(labels.begin() + n * n * 4, labels.end(), std::uint8_t{2});
  Scene scene = SceneBuilder("blocks")
                    .labels(std::span<const std::uint8_t>(labels), ArrayLayout::x_fastest({n, n, 10}),
                            affine_of({h, h, h}))
                    .material(1, test::isotropic(E1, nu1))
                    .material(2, test::isotropic(E2, nu2))
                    .hold("z-", "z")
                    .move("z+", {0, 0, shift}, "z")
                    .build();
  for (const int z : {0, 10}) { // neither block moves sideways or turns
    test::add_prescribed(scene, {0, 0, z}, 0, 0, true);
    test::add_prescribed(scene, {0, 0, z}, 1, 0, true);
    test::add_prescribed(scene, {n, 0, z}, 1, 0, true);
  }
  test::sort_prescribed(scene);
  scene.relaxation.tolerance = 1e-8;
  return scene;
}

TEST(SlidingAnalytic, BlocksThatSlideArePressedAsColumnsInSeries) {
  constexpr double shift = -2e-4;
  Scene scene = two_blocks(4, shift);
  const Answer glued = solve(scene, "coupled");
  scene.sliding = {{1, 2}};
  ASSERT_EQ(remaining_rigid_motion(scene), "");
  const Answer answer = test::solved(scene, "coupled");
  const double stress = shift / (4 * h / E1 + 6 * h / E2), expected = stress * 16 * h * h;
  EXPECT_NEAR(test::force_of_moves(scene, answer), expected, 1e-5 * std::abs(expected));
  EXPECT_GT(std::abs(test::force_of_moves(scene, glued) / expected), 1.01); // glued blocks hinder each other
  // Each block widens by its own Poisson ratio.
  const std::int64_t corner = scene.specimen.grid.node({4, 4, 4});
  for (const SplitNode& node : answer.split)
    if (node.node == corner) {
      const double strain = node.label == 1 ? -nu1 * stress / E1 : -nu2 * stress / E2;
      EXPECT_NEAR(node.displacement[0], 4 * h * strain, 1e-5 * 4 * h * std::abs(strain));
    }
  EXPECT_EQ(answer.split.size(), 2 * 25U);
  const CellFields fields = cell_fields(scene, answer);
  EXPECT_NEAR(fields.stress[0][2], stress, 1e-4 * std::abs(stress));
  EXPECT_NEAR(fields.stress[0][0], 0, 1e-4 * std::abs(stress));
}

TEST(SlidingAnalytic, NothingOfAMoveAlongTheBorderGoesAcrossIt) {
  Scene scene = two_blocks(4, 0);
  for (Prescribed& p : scene.prescribed) // the upper block is drawn along x as a whole
    if (p.component == 0 && scene.specimen.grid.node_at(p.node)[2] == 10)
      p.value = 1e-3, p.held = false;
  scene.sliding = {{1, 2}};
  for (const char* method : {"coupled", "relaxed", "limits", "sweep"}) {
    const Answer answer = solve(scene, method);
    ASSERT_TRUE(has_displacement(answer.status)) << method << answer.message;
    if (has_stress(method)) {
      EXPECT_NEAR(test::force_of_moves(scene, answer), 0, 1e-6) << method;
    }
    double lower = 0, upper = 0;
    for (const SplitNode& node : answer.split)
      (node.label == 1 ? lower : upper) =
          std::max(node.label == 1 ? lower : upper, std::abs(node.displacement[0]));
    EXPECT_NEAR(lower, 0, 1e-8) << method;
    EXPECT_GT(upper, has_stress(method) ? 9e-4 : 1e-5) << method;
  }
}

// Truth: where the upper block slides as a whole along the border, the strain is zero, so that no cell has
// energy or changes volume, although the mean of both sides jumps at the border. Pressed, parts have the
// energy of columns, sigma^2 / (2 E) times their volume.
TEST(SlidingAnalytic, PartsHaveTheEnergyAndTheVolumeOfTheirOwnSide) {
  Scene scene = two_blocks(4, 0);
  for (Prescribed& p : scene.prescribed)
    if (p.component == 0 && scene.specimen.grid.node_at(p.node)[2] == 10)
      p.value = 1e-3, p.held = false;
  scene.sliding = {{1, 2}};
  for (const char* method : {"coupled", "relaxed"}) {
    const Answer drawn = solve(scene, method);
    ASSERT_TRUE(has_displacement(drawn.status)) << drawn.message;
    const Mechanics mechanics = mechanics_of(scene, drawn, cell_energies(scene, drawn));
    ASSERT_EQ(mechanics.labels.size(), 2U);
    const double glued = 0.5 * E1 * 1e-3 * 1e-3 * 16 * h; // the order of what a joined border would store
    for (const PartMechanics& part : mechanics.labels) {
      EXPECT_NEAR(*part.strain_energy, 0, 1e-6 * glued) << method;
      EXPECT_NEAR(part.volume_change(), 0, 1e-6) << method;
    }
  }
  constexpr double shift = -2e-4;
  scene = two_blocks(4, shift);
  scene.sliding = {{1, 2}};
  const Answer pressed = solve(scene, "coupled");
  const Mechanics mechanics = mechanics_of(scene, pressed, cell_energies(scene, pressed));
  const double stress = shift / (4 * h / E1 + 6 * h / E2), area = 16 * h * h;
  const auto expect_column = [&](const PartMechanics& part, double E, double nu, double height) {
    const double energy = stress * stress / (2 * E) * area * height, strain = stress / E;
    EXPECT_NEAR(*part.strain_energy, energy, 1e-4 * energy);
    EXPECT_NEAR(part.volume_change(), (1 + strain) * (1 - nu * strain) * (1 - nu * strain) - 1, 1e-6);
  };
  expect_column(mechanics.labels[0], E1, nu1, 4 * h);
  expect_column(mechanics.labels[1], E2, nu2, 6 * h);
}

TEST(SlidingAnalytic, ABlockThatNothingHoldsIsNamedWithItsMotion) {
  Scene scene = two_blocks(4, 0);
  std::erase_if(scene.prescribed, [&](const Prescribed& p) {
    return scene.specimen.grid.node_at(p.node)[2] == 10 && p.component < 2;
  });
  EXPECT_EQ(remaining_rigid_motion(scene), "");
  scene.sliding = {{1, 2}};
  const std::string motion = remaining_rigid_motion(scene);
  EXPECT_NE(motion.find("label 2"), std::string::npos) << motion;
  EXPECT_NE(motion.find("move along x, y and turn about z"), std::string::npos) << motion;
  EXPECT_EQ(solve(scene, "coupled").status, Status::refused);
}

/// A cylinder of radius 4 cells, label 2, in a tube to radius 8, label 1, held outside; the cylinder is
/// turned.
Scene cylinder_in_tube(double angle) {
  constexpr int n = 18, length = 3;
  std::vector<std::uint8_t> labels;
  const auto radius = [](double x, double y) { return std::hypot(x - n / 2.0, y - n / 2.0); };
  for (int z = 0; z < length; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x) {
        const double r = radius(x + 0.5, y + 0.5);
        labels.push_back(r < 4 ? 2 : r < 8 ? 1 : 0);
      }
  Scene scene = SceneBuilder("tube")
                    .labels(std::span<const std::uint8_t>(labels), ArrayLayout::x_fastest({n, n, length}),
                            affine_of({h, h, h}))
                    .material(1, test::isotropic(E1, nu1))
                    .material(2, test::isotropic(E1, nu1))
                    .hold("z-", "z")
                    .build();
  scene.prescribed.clear();
  const Index3 first = first_cell(scene.specimen);
  const Grid& grid = scene.specimen.grid;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    if (!scene.specimen.is_node(at))
      continue;
    const double x = at[0] + first[0] - n / 2.0, y = at[1] + first[1] - n / 2.0;
    scene.prescribed.push_back({node, 2, 0, true}); // plane strain
    if (std::hypot(x, y) < 2.5) {
      scene.prescribed.push_back({node, 0, -angle * y * h, false});
      scene.prescribed.push_back({node, 1, angle * x * h, false});
    } else if (std::hypot(x, y) > 7) {
      scene.prescribed.push_back({node, 0, 0, true});
      scene.prescribed.push_back({node, 1, 0, true});
    }
  }
  test::sort_prescribed(scene);
  scene.relaxation.tolerance = 1e-6;
  return scene;
}

double torque(const Scene& scene, const Answer& answer) {
  const Grid& grid = scene.specimen.grid;
  const double cx = (grid.cells()[0]) / 2.0, cy = grid.cells()[1] / 2.0;
  double sum = 0;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i) {
    const Prescribed& p = scene.prescribed[i];
    if (p.held || p.component > 1)
      continue;
    const Index3 at = grid.node_at(p.node);
    sum += p.component == 0 ? -(at[1] - cy) * h * answer.reaction[i] : (at[0] - cx) * h * answer.reaction[i];
  }
  return sum;
}

TEST(SlidingAnalytic, ACylinderTurnsInATubeThatDoesNotFeelIt) {
  constexpr double angle = 0.01;
  Scene scene = cylinder_in_tube(angle);
  const Answer glued = solve(scene, "coupled");
  scene.sliding = {{1, 2}};
  const Answer answer = test::solved(scene, "coupled");
  // Between a shaft of radius a and a wall of radius b turning takes 4 pi G angle / (1/a^2 - 1/b^2) a length.
  const double G = E1 / (2 * (1 + nu1)), a = std::sqrt(5.0) * h,
               b = std::sqrt(50.0) * h; // the outermost, innermost node
  const double stuck = 4 * std::numbers::pi * G * angle / (1 / (a * a) - 1 / (b * b)) * 3 * h;
  EXPECT_NEAR(torque(scene, glued), stuck, 0.25 * stuck); // steps of voxels
  EXPECT_LT(std::abs(torque(scene, answer)), 0.03 * stuck);
  for (const char* method : {"sweep", "literal", "dijkstra"}) { // its border is not flat
    const Answer refused = solve(scene, method);
    EXPECT_EQ(refused.status, Status::refused);
    EXPECT_NE(refused.message.find("limits, relaxed, coupled"), std::string::npos) << refused.message;
  }
}

// Truth: a shaft that is pressed evenly and turned slips all around, and friction resists with mu times what
// presses it at the radius of the border.
TEST(SlidingAnalytic, FrictionOfACylinderInATube) {
  Scene scene = cylinder_in_tube(0.1);
  const Index3 first = first_cell(scene.specimen);
  for (Prescribed& p : scene.prescribed) { // the wall of the tube moves inwards
    const Index3 at = scene.specimen.grid.node_at(p.node);
    const std::array<double, 2> x{at[0] + first[0] - 9.0, at[1] + first[1] - 9.0};
    if (p.held && p.component < 2)
      p.value = -0.1 * h * x[static_cast<std::size_t>(p.component)] / std::hypot(x[0], x[1]);
  }
  scene.sliding = {{1, 2, 0.2}};
  scene.relaxation.tolerance = 1e-4;
  const Answer answer = test::solved(scene, "coupled");
  ASSERT_EQ(answer.rubbing.size(), 1U);
  EXPECT_EQ(answer.rubbing[0].slipping, 1);
  EXPECT_NEAR(answer.rubbing[0].rubbed, 0.2 * answer.rubbing[0].pressed, 1e-3 * answer.rubbing[0].rubbed);
  const double expected = 0.2 * answer.rubbing[0].pressed * 4 * h;
  EXPECT_NEAR(torque(scene, answer), expected, 0.06 * expected); // steps of voxels
}

TEST(ContractionAnalytic, FibresThatTurnWithTheirCellsPullAlongThemselves) {
  Scene scene = column({3, 3, 6}, E1, nu1);
  prescribe_plane(scene, 0, 0, true);
  test::sort_prescribed(scene);
  scene.specimen.fibre = {0, 0, 1};
  scene.active_stress.assign(54, 10e3);
  scene.strain = Strain::finite;
  const Answer answer = test::solved(scene, "coupled");
  EXPECT_NEAR(answer.displacement(2, scene.specimen.grid.node({1, 1, 6})), -6 * h * 10e3 / E1,
              1e-4 * 6 * h * 0.1);
  EXPECT_EQ(check_forces(scene, answer).value().caveats, std::vector<std::string>{}); // they are free
}

} // namespace
} // namespace maille::deform
