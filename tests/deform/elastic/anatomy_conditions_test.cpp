/// Springs to the ground, sliding borders and contraction that turns, against closed forms by lattice
/// methods; ../../support/conditions_test.cpp has those that finite elements have too.

#include "maille/deform/solve.hpp"
#include "maille/mechanics/recovery.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/sliding.hpp"
#include "support/bodies/condition_bodies.hpp"
#include "support/bodies/layers.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

std::vector<maille::test::ConditionSolver> maille::test::condition_solvers() {
  const auto by = [](const char* method) {
    return [=](const Scene& scene) { return deform::solve(scene, method); };
  };
  return {{.name = "coupled", .solve = by("coupled"), .accuracy = 1e-5, .has_friction = true},
          {.name = "relaxed", .solve = by("relaxed"), .accuracy = 1e-5, .is_confined = true},
          {.name = "limits", .solve = by("limits"), .accuracy = 1e-5},
          {.name = "sweep", .solve = by("sweep"), .accuracy = 1e-5}};
}

namespace maille::deform {
namespace {

using test::column;

constexpr double h = 1e-3, E1 = 100e3, E2 = 40e3, nu1 = 0.3, nu2 = 0.45;

Scene two_blocks(int n, double shift) {
  return test::two_blocks(n, shift, h, test::isotropic(E1, nu1), test::isotropic(E2, nu2));
}

TEST(FoundationAnalytic, SpringsAloneKeepABodyInPlace) {
  Scene scene = column({3, 3, 3}, h, test::isotropic(E1, nu1));
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

// Truth: where the upper block slides as a whole along the border, the strain is zero, so that no cell has
// energy or changes volume, although the mean of both sides jumps at the border. Pressed, parts have the
// energy of columns, sigma^2 / (2 E) times their volume.
TEST(SlidingAnalytic, PartsHaveTheEnergyAndTheVolumeOfTheirOwnSide) {
  Scene scene = two_blocks(4, 0);
  test::draw_upper_block(scene, 1e-3);
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
  const auto label = [](const Vec3& at) {
    const double r = std::hypot(at[0] - n / 2.0, at[1] - n / 2.0);
    return r < 4 ? 2 : r < 8 ? 1 : 0;
  };
  const Material matter = test::isotropic(E1, nu1);
  Scene scene = test::labelled({n, n, length}, h, label, matter, matter).hold("z-", "z").build();
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

// Truth: below mu times the pressure nodes stick, and the blocks are one.
TEST(FrictionAnalytic, ABlockThatIsDrawnLittleIsGlued) {
  Scene scene = test::alike_layers({4, 4, 8}, h, E1, 0).move("z+", {2e-6, 0, -2e-4}, "xyz").build();
  scene.relaxation.tolerance = 1e-8;
  const Answer glued = solve(scene, "coupled");
  scene.sliding = {{1, 2, 0.3}};
  const Answer answer = test::solved(scene, "coupled");
  EXPECT_EQ(answer.rubbing.at(0).slipping, 0);
  double most = 0;
  for (std::size_t i = 0; i < answer.displacement.values().size(); ++i)
    most = std::max(most, std::abs(answer.displacement.values()[i] - glued.displacement.values()[i]));
  EXPECT_LT(most, 1e-6 * 2e-4);
  EXPECT_NEAR(test::force_of_moves(scene, answer, 0), test::force_of_moves(scene, glued, 0),
              1e-4 * test::force_of_moves(scene, glued, 0));
}

TEST(FrictionContract, MethodsThatKnowNoForcesRefuseItInWords) {
  Scene scene = test::alike_layers({2, 2, 8}, h, E1, 0).move("z+", {1e-4, 0, -1e-4}, "xyz").build();
  scene.sliding = {{1, 2, 0.3}};
  for (const char* method : {"limits", "relaxed", "sweep", "literal", "dijkstra"}) {
    const Answer answer = solve(scene, method);
    EXPECT_EQ(answer.status, Status::refused) << method;
    EXPECT_NE(answer.message.find("has friction"), std::string::npos) << answer.message;
  }
}

TEST(ContractionAnalytic, FibresThatTurnWithTheirCellsPullAlongThemselves) {
  Scene scene = column({3, 3, 6}, h, test::isotropic(E1, nu1));
  test::prescribe_face(scene, 2, false, 2, 0, true);
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
