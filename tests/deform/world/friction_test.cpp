/// Coulomb friction between surfaces: what sticks, what slides, and with which force.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/worlds.hpp"
#include "world/surface/friction_program.hpp"

namespace maille::deform {
namespace {

using test::box_object;
using test::elastic_object;
using test::empty_world;
using test::hold_face;

WorldScene rough(std::initializer_list<int> cells, double friction) {
  WorldScene scene = empty_world(cells, "coupled");
  scene.contact = ContactLaw::surfaces;
  scene.friction = friction;
  return scene;
}

/// Sum of what acts on an object, but for the hand.
Eigen::Vector3d force_on(const FrameResult& result, int object) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const WorldContact& contact : result.contacts)
    if (contact.object == object)
      sum += contact.force;
  return sum;
}

/// A block on a floor that a spring draws down by `down` and along by `along` [cells].
double gone_along(bool is_3d, double friction, double down, double along, double& normal, double& rubbing) {
  constexpr double stiffness = 100;
  WorldScene scene = is_3d ? rough({20, 20, 20}, friction) : rough({20, 20}, friction);
  scene.objects = {is_3d ? box_object("floor", ObjectKind::fixed, {10, 2, 6}, {1, 1, 3})
                         : box_object("floor", ObjectKind::fixed, {18, 2}, {1, 1, 0}),
                   is_3d ? box_object("block", ObjectKind::rigid, {3, 1, 2}, {4, 3 + 1e-4, 5})
                         : box_object("block", ObjectKind::rigid, {6, 2}, {4, 3 + 1e-4, 0})};
  World world(scene);
  const Pose start = world.pose(1);
  Drive drive;
  drive.object = 1;
  drive.lead = Drive::Lead{start, stiffness};
  drive.motion.by = {0, -down, 0};
  world.advance({&drive, 1});
  drive.lead->hand.position[1] -= down;
  drive.motion.by = {along, 0, 0};
  const FrameResult result = world.advance({&drive, 1});
  // Where friction keeps it from where the hand is, its way was cut.
  EXPECT_TRUE(is_converged(result.status)) << result.message;
  const Eigen::Vector3d force = force_on(result, 1);
  normal = force[1] / stiffness;
  rubbing = force[0] / stiffness;
  return world.pose(1).position[0] - start.position[0];
}

// Analytic: a spring of stiffness k that draws down by D and along by L: the block sticks while k L is below
// friction k D, else it goes until the spring draws with just that.
TEST(FrictionAnalytic, ABlockSticksBelowItsFrictionAndSlidesAboveIt) {
  for (const bool is_3d : {false, true})
    for (const double along : is_3d ? std::vector{0.3, 0.6} : std::vector{0.1, 0.35, 0.45, 2.0}) {
      double normal = 0, rubbing = 0;
      const double way = gone_along(is_3d, 0.4, 1, along, normal, rubbing);
      EXPECT_NEAR(normal, 1, 1e-3) << "along " << along;
      EXPECT_NEAR(way, std::max(0.0, along - 0.4), 2e-3) << "along " << along << (is_3d ? ", 3D" : ", 2D");
      EXPECT_NEAR(rubbing, -std::min(along, 0.4), 2e-3) << "along " << along;
    }
}

// Analytic: below friction times the normal force the top of an elastic block goes with the plate; above it
// the plate slides, and draws with friction times the normal force, no more.
TEST(FrictionAnalytic, APlateTakesABlockAlongUntilItSlides) {
  WorldScene scene = rough({24, 16}, 0.3);
  scene.objects = {elastic_object("block", {8, 4}, {6, 2, 0}),
                   box_object("plate", ObjectKind::rigid, {14, 2}, {3, 6.05, 0})};
  scene.objects[0].scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0);
  hold_face(scene.objects[0], 1, false);
  World world(scene);
  Drive down;
  down.object = 1;
  down.motion.by = {0, -0.4, 0};
  FrameResult result = world.advance({&down, 1});
  ASSERT_EQ(result.status, Status::done) << result.message;
  const std::int64_t node = world.scene().objects[0].scene.specimen.grid.node({4, 4, 0});
  const double before = world.position(0, node)[0];
  Drive along;
  along.object = 1;
  along.motion.by = {0.02, 0, 0};
  result = world.advance({&along, 1});
  ASSERT_EQ(result.status, Status::done) << result.message;
  EXPECT_NEAR(world.position(0, node)[0] - before, 0.02, 1e-4); // it sticks
  along.motion.by = {3, 0, 0};
  result = world.advance({&along, 1});
  ASSERT_EQ(result.status, Status::done) << result.message;
  EXPECT_LT(world.position(0, node)[0] - before, 2);
  const Eigen::Vector3d force = force_on(result, 0);
  EXPECT_LT(force[1], 0);
  // Faces that are pressed askew have normals a little off the vertical.
  EXPECT_NEAR(force[0], -0.3 * force[1], 1e-4 * force.norm());
  EXPECT_NEAR((force + force_on(result, 1)).norm(), 0, 1e-9 * force.norm());
}

// Oracle: Coulomb's law itself, looked at contact by contact.
TEST(FrictionProgramOracle, ForcesObeyCoulombsLaw) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  int slipping = 0, sticking = 0, unsettled = 0;
  for (int question = 0; question < 300; ++question) {
    const int tangents = 1 + question % 2, contacts = 1 + int(random() % 4), n = contacts * (1 + tangents);
    const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return 0.3 * normal(random); });
    const Eigen::MatrixXd compliance = root * root.transpose() + Eigen::MatrixXd::Identity(n, n);
    Eigen::VectorXd gap = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
    std::vector<char> may_pull(std::size_t(n), 0), active;
    std::vector<FrictionRows> rows;
    for (int i = 0; i < contacts; ++i)
      rows.push_back({i, contacts + i * tangents, tangents});
    const double friction = 0.3;
    const Eigen::VectorXd force = frictional_forces(compliance, gap, may_pull, active, rows, friction);
    const Eigen::VectorXd after = gap + compliance * force;
    bool is_answer = true;
    for (const FrictionRows& row : rows) {
      const double press = force[row.normal];
      const auto rub = force.segment(row.first, tangents), slip = after.segment(row.first, tangents);
      is_answer = is_answer && press >= 0 && after[row.normal] > -1e-9 &&
                  std::abs(press * after[row.normal]) < 1e-8 && rub.norm() <= friction * press + 1e-9;
      if (slip.norm() > 1e-9 && press > 0) { // what slips is held by all that friction has, against its way
        is_answer = is_answer && (rub + friction * press * slip.normalized()).norm() < 1e-5 * (1 + press);
        ++slipping;
      } else if (press > 0) {
        ++sticking;
      }
    }
    unsettled += !is_answer;
  }
  EXPECT_EQ(unsettled, 0);
  EXPECT_GT(slipping, 50);
  EXPECT_GT(sticking, 20);
}

} // namespace
} // namespace maille::deform
