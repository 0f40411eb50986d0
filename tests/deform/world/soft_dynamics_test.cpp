/// Deformable objects in worlds in which time passes.

#include "maille/deform/world/world.hpp"
#include "maille/scene/answer.hpp"
#include "support/kit.hpp"

#include <Eigen/Core>

namespace maille::deform {
namespace {

constexpr double mm = 1e-3;

World world_of(const std::string& dynamics, const std::string& objects) {
  return World(parse_world_scene("[world]\ncells = [60, 60]\nspacing = \"1 mm\"\ndynamics = { " + dynamics +
                                 " }\n" + objects));
}

std::string soft(const std::string& name, const std::string& cells, const std::string& position,
                 const std::string& more = "", double modulus = 10) {
  return fmt::format("[[object]]\nname = \"{}\"\nkind = \"deformable\"\nshape = \"box\"\ncells = "
                     "[{}]\nposition = [{}]\nmaterial = {{ youngs_modulus = \"{} kPa\", poisson_ratio = 0 "
                     "}}\n{}\n",
                     name, cells, position, modulus, more);
}

FrameBudget lasting(double seconds) {
  FrameBudget budget;
  budget.frame_seconds = seconds;
  return budget;
}

// Analytic: backward Euler of a free fall: after n steps of h the way is g h^2 n (n + 1) / 2, and nothing is
// strained.
TEST(SoftDynamicsAnalytic, AFreeBodyFallsUnstrained) {
  World world = world_of("gravity = [0, \"-9.81 m/s^2\"]", soft("body", "8, 6", "\"20 mm\", \"40 mm\""));
  for (int frame = 0; frame < 4; ++frame)
    EXPECT_EQ(world.advance({}, lasting(0.01)).status, Status::done);
  const double way = 9.81 * 1e-6 * 40 * 41 / 2;
  const Scene& body = world.scene().objects[0].scene;
  for (std::int64_t node = 0; node < body.specimen.grid.n_nodes(); ++node) {
    EXPECT_NEAR(world.displacement(0)(1, node), -way, 1e-9);
    EXPECT_NEAR(world.displacement(0)(0, node), 0, 1e-9);
  }
  EXPECT_NEAR(world.motion(0).velocity[1], -9.81 * 0.04, 1e-9);
  EXPECT_NEAR(world.motion(0).mass, 1000 * 8e-3 * 6e-3, 1e-12); // of 1 m of thickness
}

// Analytic: a bar without a Poisson ratio, held at one end and let go under gravity along it, sways about the
// stretch of its weight with a period of four lengths over the speed of sound, to what steps and cells take.
TEST(SoftDynamicsAnalytic, ABarSwaysWithFourLengthsOverTheSpeedOfSound) {
  World world = world_of("gravity = [\"9.81 m/s^2\", 0]",
                         soft("bar", "40, 2", "\"5 mm\", \"20 mm\"", "hold = [{ where = \"x-\" }]", 40));
  const double period = 4 * 40 * mm / std::sqrt(40e3 / 1000);
  const auto end = [&] { return world.displacement(0)(0, 40); };
  double before = 0, now = 0;
  int turned_at = 0;
  for (int step = 1; step <= 60 && turned_at == 0; ++step) { // steps of half a millisecond
    world.advance({}, lasting(0.5e-3));
    before = now;
    now = end();
    if (now < before)
      turned_at = step - 1;
  }
  EXPECT_NEAR(turned_at * 0.5e-3, 0.5 * period, 0.1 * period);
  // The end of a bar under its own weight goes to twice its rest, rho g l^2 / (2 E), less what is damped.
  const double rest = 1000 * 9.81 * 1.6e-3 / (2 * 40e3);
  EXPECT_GT(before, 1.4 * rest);
  EXPECT_LT(before, 2 * rest);
}

// Analytic: what has come to rest carries its weight: the static stretch, by steps that lose all that sways.
TEST(SoftDynamicsAnalytic, AHeldBodyComesToRestUnderItsWeight) {
  World world = world_of("gravity = [\"9.81 m/s^2\", 0], damping = 200",
                         soft("bar", "20, 2", "\"5 mm\", \"20 mm\"", "hold = [{ where = \"x-\" }]"));
  for (int frame = 0; frame < 12; ++frame)
    world.advance({}, lasting(0.05));
  EXPECT_NEAR(world.displacement(0)(0, 20), 1000 * 9.81 * 0.4e-3 / (2 * 10e3), 1e-6 * mm);
}

// Contract: an impact of two free bodies, one of them rigid, keeps momentum, and gives no energy.
TEST(SoftDynamicsContract, AnImpactKeepsMomentumAndGivesNoEnergy) {
  World world = world_of("damping = 0",
                         soft("soft", "10, 10", "\"30 mm\", \"20 mm\"") +
                             "[[object]]\nname = \"ball\"\nkind = \"rigid\"\nshape = \"ellipsoid\"\ncells = "
                             "[8, 8]\nposition = [\"18 mm\", \"24 mm\"]\nvelocity = [0.4, 0.05]\n");
  const auto momentum = [&] {
    return Eigen::Vector3d(world.motion(0).mass * world.motion(0).velocity +
                           world.motion(1).mass * world.motion(1).velocity);
  };
  const Eigen::Vector3d before = momentum();
  const double energy = world.energy();
  bool has_met = false;
  double least_x = world.motion(0).velocity[0];
  for (int frame = 0; frame < 12; ++frame) {
    const FrameResult result = world.advance({}, lasting(5e-3));
    ASSERT_EQ(result.status, Status::done) << result.message;
    has_met = has_met || !result.contacts.empty();
    EXPECT_LT((momentum() - before).norm(), 1e-10 * before.norm());
    EXPECT_LT(world.energy(), energy * (1 + 1e-9));
    EXPECT_EQ(world.n_penetrations(), 0);
  }
  EXPECT_TRUE(has_met);
  EXPECT_GT(world.motion(0).velocity[0], least_x + 0.05); // it was set in motion
  EXPECT_GT(std::abs(world.motion(0).spin[2]), 1e-3);     // and turns: it was not met in its middle
}

// Contract: a body that nothing holds turns as far as it likes and keeps its form.
TEST(SoftDynamicsContract, AFreeBodyThatTurnsKeepsItsForm) {
  World world =
      world_of("damping = 0", soft("soft", "16, 4", "\"20 mm\", \"25 mm\"", "", 40) +
                                  "[[object]]\nname = \"ball\"\nkind = \"rigid\"\nshape = \"box\"\ncells = "
                                  "[3, 8]\nposition = [\"33 mm\", \"14 mm\"]\nvelocity = [0, 0.6]\n");
  double turned = 0;
  const auto arm = [&] {
    const Grid& grid = world.scene().objects[0].scene.specimen.grid;
    return Eigen::Vector3d(world.position(0, grid.node({16, 2, 0})) -
                           world.position(0, grid.node({0, 2, 0})));
  };
  for (int frame = 0; frame < 30 && turned < 1; ++frame) {
    const FrameResult result = world.advance({}, lasting(5e-3));
    if (std::ranges::any_of(result.contacts, [](const auto& contact) { return contact.other < 0; }))
      break;
    turned = std::max(turned, std::abs(std::atan2(arm()[1], arm()[0])));
  }
  EXPECT_GT(turned, 0.5);
  EXPECT_NEAR(arm().norm(), 16 * mm,
              0.8 * mm); // linear strains in the first frame would make it 1 / cos longer
}

TEST(SoftDynamicsContract, RestitutionBesideDeformableObjectsIsRefused) {
  EXPECT_THROW(world_of("restitution = 0.5", soft("body", "8, 6", "\"20 mm\", \"40 mm\"")),
               std::invalid_argument);
}

} // namespace
} // namespace maille::deform
