#include "control/method.hpp"
#include "elastic/finite/finite_minimum.hpp"
#include "elastic/ladder/ladder.hpp"
#include "maille/deform/solve.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "support/bodies/bent_bar.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/solved.hpp"

namespace maille::deform {
namespace {

using std::numbers::pi;
using test::bent_bar;
using test::relative_difference;

/// All that a relaxation goes through.
struct Trace {
  Answer answer;
  std::vector<std::pair<double, double>> energies; ///< fraction, energy
  std::int64_t n_inverted = 0;
};

Trace traced(const Scene& scene) {
  ThreadTeam team(1);
  const Clock clock;
  const Control control;
  const CoupledTask task{scene, control, scene.prescribed, team, clock, [] { return false; }};
  FiniteCourse course(scene, scene.prescribed, team, make_operator);
  FiniteMinimum minimum(task, course);
  Trace trace;
  minimum.watch = [&](double fraction, double energy) { trace.energies.emplace_back(fraction, energy); };
  EXPECT_TRUE(minimum.solve(trace.answer));
  trace.n_inverted = minimum.n_inverted();
  return trace;
}

/// While handles stay.
void expect_falling(const Trace& trace) {
  for (std::size_t i = 1; i < trace.energies.size(); ++i)
    if (trace.energies[i].first == trace.energies[i - 1].first) {
      EXPECT_LE(trace.energies[i].second, trace.energies[i - 1].second);
    }
}

bool is_finite(const Displacement& u) {
  return std::ranges::all_of(u.values(), [](double value) { return std::isfinite(value); });
}

/// Fibres across the grid's axes, ten times as stiff along as across.
void make_fibrous(Scene& scene) {
  scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(100e3, 10e3, 7e3, 0.3, 0.4);
  scene.specimen.fibre = {0.8, 0.6, 0};
}

// Truth: a body that nothing strains is as it was, but elsewhere.
TEST(FiniteStrainAnalytic, ATurnOfAllHandlesIsATurnOfTheBody) {
  for (const int dimension : {2, 3})
    for (const double angle : {0.4, pi / 2, 3.0, 5.5}) {
      Scene scene = test::straight_bar(dimension, 2);
      make_fibrous(scene);
      Turn turn;
      turn.angle = angle;
      turn.axis = dimension == 3 ? Vec3{0.6, 0, 0.8} : Vec3{0, 0, 1};
      turn.about = {0.01, 0.02, 0};
      turn.by = {0.003, -0.004, 0};
      test::turn_face(scene, false, turn);
      turn.nodes.clear();
      test::turn_face(scene, true, turn);
      const Answer answer = test::solved(scene, "coupled");
      for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
        const Vec3 u = turn.displacement(scene.specimen.position(scene.specimen.grid.node_at(node)));
        for (int b = 0; b < dimension; ++b)
          EXPECT_NEAR(answer.displacement(b, node), u[static_cast<std::size_t>(b)], 1e-12);
      }
      EXPECT_NEAR(*answer.strain_energy, 0, 1e-20);
    }
}

// Truth: `coupled` in the object's frame, the first order of the same question.
TEST(FiniteStrainConsistent, SmallMovesAreThoseOfCoupledToSecondOrder) {
  for (const int dimension : {2, 3}) {
    double last = 0;
    for (const double angle : {0.04, 0.004}) {
      Scene scene = bent_bar(dimension, 4, angle);
      make_fibrous(scene);
      scene.relaxation.tolerance = 1e-6;
      const Answer blocks = solve(scene, "coupled");
      scene.strain = Strain::small;
      scene.relaxation.tolerance = 1e-9;
      const Answer object = solve(scene, "coupled");
      ASSERT_EQ(blocks.status, Status::done) << blocks.message;
      ASSERT_EQ(object.status, Status::done) << object.message;
      const double difference = relative_difference(blocks.displacement, object.displacement);
      EXPECT_LT(difference, angle); // of the displacement, which is of first order
      EXPECT_NEAR(*blocks.strain_energy, *object.strain_energy, 2 * angle * *object.strain_energy);
      if (last > 0) {
        EXPECT_NEAR(last / difference, 10, 2);
      }
      last = difference;
    }
  }
}

// Truth: a circular arc with no strain along its axis, energy E I angle^2 / (2 L) (Euler and Bernoulli; with
// Biot's strain exact but for the stress across, of the order of the surface's strain squared: 0.2^2 at
// most).
TEST(FiniteStrainAnalytic, ABarBentToAQuarterIsAnArc) {
  for (const int dimension : {2, 3}) {
    const double angle = pi / 2;
    Scene scene = bent_bar(dimension, 4, angle);
    const Answer blocks = test::solved(scene, "coupled");
    EXPECT_NEAR(*blocks.strain_energy, test::beam_energy(scene, angle),
                0.02 * test::beam_energy(scene, angle));
    const double off = test::distance_from_arc(scene, blocks.displacement, angle);
    EXPECT_LT(off, 0.02 * test::bar_length);
    scene.strain = Strain::small;
    const Answer object = test::solved(scene, "coupled");
    EXPECT_GT(test::distance_from_arc(scene, object.displacement, angle), 5 * off);
    EXPECT_GT(*object.strain_energy, 3 * *blocks.strain_energy);
  }
}

// Truth: the elastica, a cantilever under a dead load at its tip: deflection and shortening over the length
// (Mattiasson 1981, table 1). Nothing says in how many increments the load is to be put on.
TEST(FiniteStrainAnalytic, ACantileverUnderALargeLoadIsAnElastica) {
  struct Point {
    double load, deflection, shortening; ///< load: P L^2 / (E I)
  };
  for (const Point& point : {Point{2, 0.49346, 0.16064}, Point{5, 0.71379, 0.38763}}) {
    constexpr int length = 60, across = 2;
    Scene scene = test::box_scene(2, {length, across, 1});
    scene.materials[0].elasticity = ElasticConstants::isotropic(1e6, 0);
    scene.strain = Strain::finite;
    test::hold_face(scene, 0, false);
    const double h = across * 1e-3, L = length * 1e-3, traction = point.load * 1e6 * h * h / (12 * L * L);
    for (int y = 0; y < across; ++y)
      scene.tractions.push_back({scene.specimen.grid.cell({length - 1, y, 0}), 0, true, {0, -traction, 0}});
    const Answer answer = solve(scene, "coupled");
    SCOPED_TRACE(testing::Message() << "P L^2 / E I = " << point.load << ": " << answer.algorithm << ' '
                                    << answer.message);
    ASSERT_EQ(answer.status, Status::done);
    const std::int64_t tip = scene.specimen.grid.node({length, across / 2, 0});
    EXPECT_NEAR(-answer.displacement(1, tip) / L, point.deflection, 0.005);
    EXPECT_NEAR(-answer.displacement(0, tip) / L, point.shortening, 0.005);
  }
}

// Truth: Clapeyron's theorem by differences: the moment that the moved end takes is the derivative of the
// energy by its angle.
TEST(FiniteStrainOracle, ReactionsAreTheDerivativeOfTheEnergy) {
  const double angle = pi / 3, step = 1e-3;
  const auto twisted = [](double by) {
    Scene scene = test::twisted_bar(2, by);
    make_fibrous(scene);
    scene.relaxation.tolerance = 1e-6;
    return scene;
  };
  const double above = *solve(twisted(angle + step), "coupled").strain_energy,
               below = *solve(twisted(angle - step), "coupled").strain_energy;
  const Scene scene = twisted(angle);
  const Answer answer = solve(scene, "coupled");
  double moment = 0;
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i) {
    const Prescribed& p = scene.prescribed[i];
    if (p.held)
      continue;
    const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(p.node));
    const double y = x[1] + answer.displacement(1, p.node) - test::bar_height / 2,
                 z = x[2] + answer.displacement(2, p.node) - test::bar_height / 2;
    moment += p.component == 1 ? -z * answer.reaction[i] : p.component == 2 ? y * answer.reaction[i] : 0;
  }
  EXPECT_NEAR(moment, (above - below) / (2 * step), 1e-4 * std::abs(moment));
}

// Truth: energy never rises while handles stay (docs/theory.md, section 4); and more increments, which lead
// to the same state.
TEST(FiniteStrainConsistent, AlmostHalfATurnInIncrementsEndsWhereMoreIncrementsDo) {
  for (const bool twists : {false, true})
    for (const bool is_fibrous : {false, true}) {
      Scene scene = twists ? test::twisted_bar(3, 170 * pi / 180) : bent_bar(3, 3, 170 * pi / 180);
      if (is_fibrous)
        make_fibrous(scene);
      scene.relaxation.tolerance = 1e-5;
      const Trace few = traced(scene);
      expect_falling(few);
      EXPECT_TRUE(is_finite(few.answer.displacement));
      EXPECT_EQ(few.n_inverted, 0);
      scene.relaxation.increments = 10;
      const Trace many = traced(scene);
      expect_falling(many);
      EXPECT_LT(relative_difference(few.answer.displacement, many.answer.displacement), 1e-4)
          << twists << is_fibrous;
      EXPECT_NEAR(*few.answer.strain_energy, *many.answer.strain_energy, 1e-6 * *many.answer.strain_energy);
    }
}

// Truth: the same, settled further.
TEST(FiniteStrainConsistent, TheEstimatedErrorIsNearTheTrueOne) {
  Scene scene = bent_bar(3, 4, pi / 2);
  make_fibrous(scene);
  scene.relaxation.tolerance = 1e-6;
  const Answer exact = test::solved(scene, "coupled");
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    scene.relaxation.tolerance = tolerance;
    const Answer answer = solve(scene, "coupled");
    EXPECT_LE(answer.residual, tolerance);
    // Energy is off by the square of the error in the energy norm.
    EXPECT_LE(*answer.strain_energy - *exact.strain_energy, tolerance * tolerance * *exact.strain_energy);
    EXPECT_LE(relative_difference(answer.displacement, exact.displacement), tolerance);
  }
}

// Truth: E I angle^2 / (2 L) needs no material to be the same everywhere: halves of stiffness 1 and 4 in
// series turn as 4 to 1.
TEST(FiniteStrainAnalytic, HalvesOfOtherStiffnessTurnInverselyToIt) {
  Scene scene = test::straight_bar(3, 4);
  scene.materials.push_back(scene.materials[0]);
  scene.materials[1].elasticity = ElasticConstants::isotropic(40e3, 0);
  Specimen& body = scene.specimen;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    body.material_id.push_back(body.grid.cell_at(cell)[0] < 8 ? 0 : 1);
  test::hold_face(scene, 0, false);
  scene.gravity = {};
  // A pair of opposite tractions on the far face turns it freely: M = traction couple.
  const double stress = 600;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (const Index3 at = body.grid.cell_at(cell); at[0] == 15 && (at[1] == 0 || at[1] == 3))
      scene.tractions.push_back({cell, 0, true, {at[1] == 0 ? stress : -stress, 0, 0}});
  const Answer answer = test::solved(scene, "coupled");
  EXPECT_TRUE(is_finite(answer.displacement));
  const auto frames = block_rotations(scene, answer.displacement);
  const auto angle_at = [&](int x) {
    return 2 * std::asin(frames[static_cast<std::size_t>(body.grid.cell({x, 1, 1}))].vec().norm());
  };
  // Away from the ends and from the border between the halves.
  EXPECT_NEAR((angle_at(5) - angle_at(2)) / (angle_at(12) - angle_at(9)), 4, 0.2);
}

// Truth: balance of forces and moments, in which a pressure counts on the deformed face.
TEST(FiniteStrainAnalytic, APressureThatFollowsIsInBalance) {
  for (const int dimension : {2, 3}) {
    Scene scene = test::straight_bar(dimension, 2);
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
      if (scene.specimen.grid.cell_at(cell)[1] == 0)
        scene.tractions.push_back({cell, 1, false, {0, 10, 0}, -1, true});
    test::hold_face(scene, 0, false);
    const Answer answer = test::solved(scene, "coupled");
    EXPECT_GT(largest_entry(answer.displacement), 0.1 * test::bar_length);
    EXPECT_EQ(check_forces(scene, answer).value().caveats, std::vector<std::string>{});
  }
}

// Truth: balance. Nothing pulls at a strip that contracts with a free end, so what holds it carries no force.
TEST(FiniteStrainAnalytic, AFreeContractionPullsAtNothing) {
  Scene scene = test::straight_bar(3, 2);
  scene.materials[0].law = NeoHookean{4e3, 40e3};
  const double stress = 30e3;
  scene.active_stress.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), stress);
  test::hold_face(scene, 0, false);
  const Answer answer = test::solved(scene, "coupled");
  Vec3 force{};
  for (std::size_t p = 0; p < answer.reaction.size(); ++p)
    force[scene.prescribed[p].component] += answer.reaction[p];
  const Vec3& h = scene.specimen.grid.spacing();
  EXPECT_LE(std::hypot(force[0], force[1], force[2]), 1e-3 * stress * 4 * h[1] * h[2]);
}

TEST(FiniteStrainContract, AnyNumberOfThreadsGivesTheSameBits) {
  Scene scene = bent_bar(3, 10, 1); // enough nodes for threads to be used
  make_fibrous(scene);
  scene.relaxation.tolerance = 1e-2;
  test::expect_bits_of_any_threads(scene, "coupled", {2, 5});
}

TEST(FiniteStrainContract, StoppedAnyTimeLeavesAUsableState) {
  const Scene scene = bent_bar(3, 3, 170 * pi / 180);
  for (const int polls : {0, 3, 15, 40}) {
    Control control;
    int left = polls;
    control.stop_requested = [&left] { return left-- <= 0; };
    const Answer answer = solve(scene, "coupled", control);
    EXPECT_EQ(answer.status, Status::interrupted);
    EXPECT_TRUE(is_finite(answer.displacement));
    EXPECT_TRUE(answer.reaction.empty());
    const auto handles_at = [&](double fraction) {
      const Scene step = scaled(scene, fraction);
      return std::ranges::all_of(step.prescribed, [&](const Prescribed& p) {
        return std::abs(answer.displacement(p.component, p.node) - p.value) < 1e-12;
      });
    };
    // Handles are at their ends, or the message says that they are not.
    const bool is_said = answer.message.find("% of moves and loads were on") != std::string::npos;
    EXPECT_NE(is_said, handles_at(1)) << polls << ' ' << answer.message;
    bool is_an_increment = false;
    for (int i = 0; i <= 16; ++i) // halves of halves
      is_an_increment = is_an_increment || handles_at(i / 16.0);
    EXPECT_TRUE(is_an_increment) << polls;
  }
}

TEST(FiniteStrainContract, ContractionWithinLimitsIsRefused) {
  Scene scene = bent_bar(3, 2, pi / 8);
  scene.relaxation.extrapolation = Extrapolation::nested;
  EXPECT_NE(solve(scene, "coupled").message.find("nothing is extrapolated"), std::string::npos);
  scene.active_stress.assign(static_cast<std::size_t>(scene.specimen.grid.n_cells()), 1e3);
  scene.limits.from = LimitSource::given;
  const Answer refused = solve(scene, "coupled");
  EXPECT_EQ(refused.status, Status::refused);
  EXPECT_NE(refused.message.find("contract"), std::string::npos);
}

} // namespace
} // namespace maille::deform
