/// Limits where strains are measured cell by cell.

#include "elastic/finite/finite_elasticity.hpp"
#include "elastic/finite/turned_limits.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/block_frames.hpp"
#include "support/bodies/bent_bar.hpp"
#include "support/bodies/lattice_scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"

#include <Eigen/Eigenvalues>

namespace maille::deform {
namespace {

using std::numbers::pi;
using test::bent_bar;

/// Stretch and compression up to `strain`.
Scene with_strains(const Scene& scene, double strain, double shear) {
  return test::with_limits(scene, test::even_limits(1 + strain, 1 - strain, shear));
}

/// Energy and its gradient, whatever limits say.
struct Elastic {
  double energy = 0;
  Displacement gradient;
};
Elastic elastic_at(const Scene& scene, const Displacement& u) {
  ThreadTeam team(1);
  const LatticeElasticity linear(scene);
  FiniteElasticity elasticity(scene, linear);
  Elastic at{0, Displacement(scene.specimen.grid)};
  at.energy = elasticity.evaluate(u, at.gradient, team);
  return at;
}

// Truth: the energy's own differences.
TEST(TurnedLimitsOracle, TheirForcesAreTheDerivativeOfTheirEnergy) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const int dimension : {2, 3})
    for (const bool has_hole : {false, true}) {
      Scene scene = with_strains(bent_bar(dimension, 2, 1), 0.02, 0.03);
      if (has_hole) {
        scene.specimen.material_id.assign(std::size_t(scene.specimen.grid.n_cells()), 0);
        scene.specimen.material_id[3] = no_material;
      }
      const LinkLimits limits(scene);
      const LatticeElasticity linear(scene);
      FiniteElasticity elasticity(scene, linear);
      ThreadTeam team(1);
      TurnedLimits constraints(scene, limits, team);
      const double h = scene.specimen.grid.spacing()[0];
      Displacement u(scene.specimen.grid), along = u, unused = u;
      for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
        const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node)), there = test::on_arc(x, 2);
        for (int b = 0; b < dimension; ++b) {
          u(b, node) = there[std::size_t(b)] - x[std::size_t(b)] + 0.1 * h * uniform(random);
          along(b, node) = h * uniform(random);
        }
      }
      const auto at = [&](double step, Displacement& forces) {
        Displacement v = u;
        for (std::size_t i = 0; i < v.values().size(); ++i)
          v.values()[i] += step * along.values()[i];
        elasticity.turn_frames(v, team);
        return constraints.evaluate(v, elasticity, forces);
      };
      Displacement forces(scene.specimen.grid);
      at(0, forces);
      constraints.improve_multipliers();
      std::ranges::fill(forces.values(), 0.0);
      ASSERT_GT(at(0, forces), 0);
      double slope = 0;
      for (std::size_t i = 0; i < forces.values().size(); ++i)
        slope += forces.values()[i] * along.values()[i];
      constexpr double step = 1e-6;
      const double difference = (at(step, unused) - at(-step, unused)) / (2 * step);
      EXPECT_NEAR(slope, difference, 1e-6 * std::abs(difference)) << dimension << has_hole;
    }
}

// Truth: halves of stiffness 1 and 4 in series, E A / L each; the soft one ends at its limit, the stiff one
// takes the rest. By strain e: energy per volume E e^2 / 2, force E e A.
TEST(TurnedLimitsAnalytic, TheStiffHalfTakesTheRestAtAnyTurn) {
  for (const int dimension : {2, 3})
    for (const double angle : {0.0, 2.0}) {
      Scene scene = test::straight_bar(dimension, 2);
      scene.materials.push_back(scene.materials[0]);
      scene.materials[1].elasticity = ElasticConstants::isotropic(40e3, 0);
      Specimen& body = scene.specimen;
      for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
        body.material_id.push_back(body.grid.cell_at(cell)[0] < 4 ? 0 : 1);
      Turn turn;
      turn.angle = angle;
      test::turn_face(scene, false, turn);
      turn.nodes.clear();
      constexpr double mean = 0.05, soft = 0.06, stiff = 2 * mean - soft;
      turn.by = {mean * test::bar_length * std::cos(angle), mean * test::bar_length * std::sin(angle), 0};
      test::turn_face(scene, true, turn);
      scene.relaxation.tolerance = 1e-4;
      const Scene limited = with_strains(scene, soft, 0.5);
      const Answer answer = solve(limited, "coupled");
      ASSERT_EQ(answer.status, Status::done) << answer.message;
      const double area = std::pow(test::bar_height, dimension - 1), half = area * test::bar_length / 2;
      const double energy = 0.5 * half * (10e3 * soft * soft + 40e3 * stiff * stiff);
      EXPECT_NEAR(*answer.strain_energy, energy, 5e-3 * energy) << answer.residual;
      double pull = 0;
      for (std::size_t i = 0; i < limited.prescribed.size(); ++i) {
        const Prescribed& p = limited.prescribed[i];
        if (body.grid.node_at(p.node)[0] > 0)
          pull += answer.reaction[i] * (p.component == 0   ? std::cos(angle)
                                        : p.component == 1 ? std::sin(angle)
                                                           : 0);
      }
      EXPECT_NEAR(pull, 40e3 * stiff * area, 5e-3 * 40e3 * stiff * area);
    }
}

/// By node: whether a cell at it has a link that is at a limit, or nearly so.
std::vector<bool> is_at_limits(const Scene& scene, const Displacement& u) {
  const Grid& grid = scene.specimen.grid;
  const LinkLimits limits(scene);
  const auto frames = block_rotations(scene, u);
  std::vector<bool> is_near(std::size_t(grid.n_nodes()), false);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node)
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      const Index3 at = grid.node_at(node);
      const auto link = limits.intervals(at, axis);
      if (at[std::size_t(axis)] + 1 >= grid.nodes()[std::size_t(axis)] || !link)
        continue;
      const Eigen::Vector3d rest = grid.spacing()[std::size_t(axis)] * Eigen::Vector3d::Unit(axis);
      Eigen::Vector3d now = rest;
      for (int b = 0; b < grid.dimension(); ++b)
        now[b] += u(b, node + grid.stride(axis)) - u(b, node);
      MeanRotation mean;
      scene.specimen.for_each_cell_at_link(at, axis,
                                           [&](std::int64_t cell) { mean.add(frames[std::size_t(cell)]); });
      const Eigen::Vector3d change = mean.value().conjugate() * now - rest;
      bool is_active = false;
      for (int b = 0; b < grid.dimension(); ++b) {
        const auto i = std::size_t(b);
        const double near = 0.01 * (link->high[i] - link->low[i]);
        is_active = is_active || change[b] < link->low[i] + near || change[b] > link->high[i] - near;
      }
      scene.specimen.for_each_cell_at_link(at, axis, [&](std::int64_t cell) {
        for (int corner = 0; is_active && corner < grid.corners_per_cell(); ++corner)
          is_near[std::size_t(grid.corner(grid.cell_at(cell), corner))] = true;
      });
    }
  return is_near;
}

/// Halves of stiffness 1 and 4 in series, pulled by `strain` until the soft one is at its limit; the far end
/// is turned, too.
Scene pulled_halves(int dimension, int cells, double poisson_ratio, double strain, double angle) {
  Scene scene = test::straight_bar(dimension, cells);
  scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, poisson_ratio);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(40e3, poisson_ratio);
  Specimen& body = scene.specimen;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    body.material_id.push_back(body.grid.cell_at(cell)[0] < 2 * cells ? 0 : 1);
  test::hold_face(scene, 0, false);
  Turn turn;
  turn.angle = angle;
  turn.about = {test::bar_length, test::bar_height / 2, test::bar_height / 2};
  turn.by = {strain * test::bar_length, 0, 0};
  test::turn_face(scene, true, turn);
  scene.relaxation.tolerance = 1e-4;
  return with_strains(scene, 1.4 * strain, 10 * strain);
}

// Truth: what must hold of a minimum, by the energy's own gradient: it is below that of the elastic state
// brought within the limits, and where no link is at a limit free nodes are in balance.
TEST(TurnedLimitsOracle, WithinLimitsTheEnergyIsLeast) {
  for (const Scene& scene : {with_strains(bent_bar(2, 3, pi / 2), 0.19, 1),
                             pulled_halves(2, 3, 0.3, 0.05, 0.04), pulled_halves(3, 2, 0.3, 0.05, 0.04)}) {
    Scene unlimited = scene;
    unlimited.limits.from = LimitSource::none;
    const Answer elastic = solve(unlimited, "coupled"), answer = solve(scene, "coupled");
    SCOPED_TRACE(answer.message);
    ASSERT_EQ(answer.status, Status::done);
    Displacement projected = elastic.displacement;
    ASSERT_TRUE(project_in_turned_frames(scene, LinkLimits(scene), projected, 1e-2));
    const auto [energy, force] = elastic_at(scene, answer.displacement);
    EXPECT_NEAR(energy, *answer.strain_energy, 1e-12 * energy);
    EXPECT_GT(energy, *elastic.strain_energy);
    EXPECT_LT(energy, elastic_at(scene, projected).energy);
    std::vector<bool> is_near = is_at_limits(scene, answer.displacement), is_free(is_near.size(), true);
    for (const Prescribed& p : scene.prescribed)
      is_free[std::size_t(p.node)] = false;
    double most = 0;
    for (std::size_t node = 0; node < is_near.size(); ++node)
      for (std::size_t b = 0; b < force.n_components() && is_free[node] && !is_near[node]; ++b)
        most = std::max(most, std::abs(force(b, node)));
    EXPECT_EQ(most > 0, scene.materials.size() > 1); // bent to a quarter, all of the bar is at limits
    EXPECT_LT(most, 0.01 * *std::ranges::max_element(answer.reaction));
  }
}

// Truth: `coupled` in the object's frame within the same limits, the first order of the same question.
TEST(TurnedLimitsConsistent, SmallMovesWithinLimitsAreThoseOfCoupled) {
  for (const int dimension : {2, 3}) {
    Scene scene = pulled_halves(dimension, dimension == 2 ? 4 : 2, 0.3, 1e-3, 1e-3);
    const Answer blocks = solve(scene, "coupled");
    scene.strain = Strain::small;
    const Answer object = solve(scene, "coupled");
    ASSERT_EQ(blocks.status, Status::done) << blocks.message;
    ASSERT_EQ(object.status, Status::done) << object.message;
    EXPECT_NE(object.message.find("least energy within"), std::string::npos);
    EXPECT_NE(blocks.message.find("least energy within"), std::string::npos);
    EXPECT_NEAR(*blocks.strain_energy, *object.strain_energy, 5e-3 * *object.strain_energy);
    EXPECT_LT(test::relative_difference(blocks.displacement, object.displacement), 3e-3);
  }
}

// Truth: largest_violation_in_blocks, which knows nothing of how limits are enforced.
TEST(TurnedLimitsContract, EveryAnswerIsWithinTheLimits) {
  for (const int dimension : {2, 3})
    for (const auto& [strain, shear] : {std::pair(0.19, 1.0), std::pair(0.15, 0.5), std::pair(0.02, 0.02)}) {
      const Scene scene = with_strains(bent_bar(dimension, 3, pi / 2), strain, shear);
      const Answer answer = solve(scene, "coupled");
      SCOPED_TRACE(answer.message);
      ASSERT_TRUE(is_converged(answer.status));
      EXPECT_LE(largest_violation_in_blocks(scene, LinkLimits(scene), answer.displacement), 1e-9);
      EXPECT_NE(answer.message.find("limits"), std::string::npos); // the surface would be strained by 0.196
      const bool is_cut = answer.status == Status::clamped;
      EXPECT_EQ(is_cut, answer.message.find("limits grant") != std::string::npos);
      double off = 0;
      for (const Prescribed& p : scene.prescribed)
        off = std::max(off, std::abs(answer.displacement(p.component, p.node) - p.value));
      EXPECT_EQ(off > 0, is_cut);
      EXPECT_TRUE(is_cut || !answer.reaction.empty());
    }
}

// Truth: the elastic answer, which none of the limits touches.
TEST(TurnedLimitsContract, WideLimitsChangeNothing) {
  const Scene free = bent_bar(3, 2, pi / 2), limited = with_strains(free, 0.5, 1);
  const Answer expected = solve(free, "coupled"), answer = solve(limited, "coupled");
  ASSERT_EQ(answer.status, Status::done) << answer.message;
  EXPECT_EQ(answer.displacement, expected.displacement);
  EXPECT_EQ(answer.reaction, expected.reaction);
  EXPECT_EQ(answer.message, expected.message);
}

TEST(TurnedLimitsContract, ItIsWithinTheLimitsWheneverItIsStopped) {
  const Scene scene = with_strains(bent_bar(3, 2, pi / 2), 0.18, 1);
  for (const int polls : {0, 3, 15, 25}) {
    Control control;
    int left = polls;
    control.stop_requested = [&left] { return left-- <= 0; };
    const Answer answer = solve(scene, "coupled", control);
    EXPECT_EQ(answer.status, Status::interrupted) << answer.message;
    EXPECT_LE(largest_violation_in_blocks(scene, LinkLimits(scene), answer.displacement), 1e-9) << polls;
  }
}

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * double(random()) / double(std::mt19937::max());
}

/// Turned fibres, a hole, oblong cells.
Scene odd_body(int dimension) {
  Scene scene =
      test::box_scene(dimension, {3, 3, dimension == 3 ? 2 : 1}, {1e-3, 1.4e-3, dimension == 3 ? 0.7e-3 : 1});
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  scene.specimen.fibre = {0.8, 0.6, 0};
  scene.specimen.material_id.assign(std::size_t(scene.specimen.grid.n_cells()), 0);
  scene.specimen.material_id[4] = no_material;
  return scene;
}

/// A turn of everything, and large uneven strains.
Displacement turned_and_strained(const Scene& scene, double angle, double strain, unsigned seed) {
  std::mt19937 random(seed);
  Turn turn;
  turn.angle = angle;
  turn.axis = scene.dimension() == 3 ? Vec3{2.0 / 3, -1.0 / 3, 2.0 / 3} : Vec3{0, 0, 1};
  turn.by = {0.3, -0.2, 0.1};
  const Grid& grid = scene.specimen.grid;
  Displacement u(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    Vec3 x = scene.specimen.position(grid.node_at(node)), w{};
    for (std::size_t b = 0; b < std::size_t(scene.dimension()); ++b) {
      w[b] = strain * grid.spacing()[b] * uniform(random, -1, 1);
      x[b] += w[b];
    }
    const Vec3 turned = turn.displacement(x);
    for (int b = 0; b < scene.dimension(); ++b)
      u(b, node) = w[std::size_t(b)] + turned[std::size_t(b)];
  }
  return u;
}

class EveryDimension : public testing::TestWithParam<int> {};
using FiniteElasticityAnalytic = EveryDimension;
using FiniteElasticityOracle = EveryDimension;
INSTANTIATE_TEST_SUITE_P(Dimensions, FiniteElasticityAnalytic, testing::Values(2, 3));
INSTANTIATE_TEST_SUITE_P(Dimensions, FiniteElasticityOracle, testing::Values(2, 3));

// Truth: a frame that turns with the body sees nothing of its turn.
TEST_P(FiniteElasticityAnalytic, ATurnChangesNoEnergyAndTurnsTheForces) {
  const Scene scene = odd_body(GetParam());
  const LatticeElasticity linear(scene);
  ThreadTeam team(1);
  Displacement forces(scene.specimen.grid), turned_forces(forces);
  FiniteElasticity elasticity(scene, linear);
  const double energy = elasticity.evaluate(turned_and_strained(scene, 0, 0.2, 7), forces, team);
  for (const double angle : {0.3, 1.7, 3.1, -2.5}) {
    FiniteElasticity other(scene, linear);
    EXPECT_NEAR(other.evaluate(turned_and_strained(scene, angle, 0.2, 7), turned_forces, team), energy,
                1e-11 * energy); // 0.3 m away from rest, in cells of a millimetre
    Turn turn{{0, 0, 1}, angle, {}, {}, {true, true, true}, {}};
    if (GetParam() == 3)
      turn.axis = {2.0 / 3, -1.0 / 3, 2.0 / 3};
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
      Vec3 force{};
      for (int b = 0; b < GetParam(); ++b)
        force[std::size_t(b)] = forces(b, node);
      const Vec3 change = turn.displacement(force);
      for (int b = 0; b < GetParam(); ++b)
        EXPECT_NEAR(turned_forces(b, node), force[std::size_t(b)] + change[std::size_t(b)],
                    1e-9 * 10e3 * 1e-6);
    }
    EXPECT_NEAR(other.evaluate(turned_and_strained(scene, angle, 0, 7), turned_forces, team), 0,
                1e-18 * 10e3);
  }
}

// Truth: differences of the energy itself.
TEST_P(FiniteElasticityOracle, ForcesAreTheGradientOfTheEnergy) {
  const Scene scene = odd_body(GetParam());
  const LatticeElasticity linear(scene);
  ThreadTeam team(1);
  FiniteElasticity elasticity(scene, linear);
  Displacement forces(scene.specimen.grid), unused(forces);
  Displacement u = turned_and_strained(scene, 1.1, 0.3, 3);
  elasticity.evaluate(u, forces, team);
  const double largest = test::largest(forces);
  for (int b = 0; b < GetParam(); ++b)
    for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
      const double there = u(b, node), step = 1e-8;
      u(b, node) = there + step;
      const double above = elasticity.evaluate(u, unused, team);
      u(b, node) = there - step;
      const double below = elasticity.evaluate(u, unused, team);
      u(b, node) = there;
      EXPECT_NEAR(forces(b, node), (above - below) / (2 * step), 1e-6 * largest) << b << ' ' << node;
    }
}

// Truth: LatticeElasticity, of which this is the same for small displacements.
TEST_P(FiniteElasticityOracle, SmallDisplacementsCostWhatTheyCostInCoupled) {
  const Scene scene = odd_body(GetParam());
  const LatticeElasticity linear(scene);
  ThreadTeam team(1);
  Displacement forces(scene.specimen.grid), of_linear(forces);
  double last = 0;
  for (const double size : {1e-2, 1e-3, 1e-4}) {
    const Displacement u = turned_and_strained(scene, 0, size, 11);
    Displacement small = u;
    for (int b = 0; b < GetParam(); ++b) { // without the shift of turned_and_strained
      const double shift = small(b, 0);
      for (double& value : small.component(b))
        value -= shift;
    }
    FiniteElasticity elasticity(scene, linear);
    elasticity.evaluate(small, forces, team);
    linear.apply(small, of_linear, team);
    const double difference = test::relative_difference(forces, of_linear);
    EXPECT_LT(difference, 3 * size); // relative to the force: second order
    if (last > 0) {
      EXPECT_NEAR(last / difference, 10, 1);
    }
    last = difference;
  }
}

// Truth: the definition, by singular values.
TEST(NearestRotationOracle, MakesTheStretchSymmetricAndTheDistanceLeast) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    Eigen::Matrix3d F;
    for (Eigen::Index k = 0; k < 9; ++k)
      F(k) = uniform(random, -1, 1);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> squares(F.transpose() * F);
    const Eigen::Vector3d values = squares.eigenvalues().cwiseMax(0).cwiseSqrt(); // ascending
    const double most = values[2] + values[1] + (F.determinant() < 0 ? -values[0] : values[0]);
    const Eigen::Quaterniond guess =
        Eigen::Quaterniond(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1), 0.1)
            .normalized();
    const Eigen::Matrix3d R = nearest_rotation(3, F, guess).toRotationMatrix();
    EXPECT_NEAR((R.transpose() * F).trace(), most, 1e-12); // nearest: the largest trace
  }
}

} // namespace
} // namespace maille::deform
