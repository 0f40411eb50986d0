#include "deform/probe/probe_scenes.hpp"
#include "maille/deform/probe/touch.hpp"
#include "support/dice.hpp"
#include "support/kit.hpp"
#include "world/touch/allowed_twist.hpp"

#include <Eigen/Geometry>

namespace maille::deform {
namespace {

using test::Dice;

RigidShape solid(const Index3& size, const Vec3& spacing = {1, 1, 1}) {
  return {size, spacing, std::vector<std::uint8_t>(std::size_t(size[0] * size[1] * size[2]), 1)};
}

Pose at(const Eigen::Vector3d& position) {
  return Pose{.position = position};
}

// Oracle: very many steps tried; none that is allowed lies nearer.
TEST(AllowedStepOracle, NoAllowedStepIsNearer) {
  std::mt19937 random(2);
  Dice dice{random};
  for (int round = 0; round < 400; ++round) {
    std::vector<Constraint> constraints(std::size_t(dice.below(6)));
    for (Constraint& constraint : constraints)
      constraint.obstacle.normal = dice.direction();
    const Eigen::Vector3d wanted = dice.between(0.1, 3) * dice.direction();
    const AllowedStep allowed = allowed_step(wanted, constraints);
    Eigen::Vector3d rebuilt = wanted;
    for (std::size_t i = 0; i < constraints.size(); ++i) {
      EXPECT_GE(allowed.depth[i], 0);
      EXPECT_GE(constraints[i].obstacle.normal.dot(allowed.step), -1e-11);
      rebuilt += allowed.depth[i] * constraints[i].obstacle.normal;
    }
    EXPECT_LT((rebuilt - allowed.step).norm(), 1e-9 * wanted.norm()); // to the conditioning of three normals
    const double distance = (allowed.step - wanted).norm();
    for (int trial = 0; trial < 300; ++trial) {
      const Eigen::Vector3d other = allowed.step + dice.between(0, 0.5) * dice.direction();
      bool is_allowed = true;
      for (const Constraint& constraint : constraints)
        is_allowed = is_allowed && constraint.obstacle.normal.dot(other) >= 0;
      if (is_allowed) {
        EXPECT_GE((other - wanted).norm(), distance - 1e-9);
      }
    }
  }
}

class RoomAnalytic : public testing::Test {
protected:
  // A floor of ten cells and a wall on it: a step up at x = 20.
  RoomAnalytic() : world({40, 40, 40}, {1, 1, 1}) {
    world.add(solid({40, 40, 10}), {});
    world.add(solid({20, 40, 10}), at({20, 0, 10}));
  }
  RigidWorld world;
};

TEST_F(RoomAnalytic, OnAPlaneTheProxyIsTheFootOfThePerpendicular) {
  const Surroundings room(&world.map(), {1, 1, 1});
  Proxy proxy(point_tool({1, 1, 1}), at({5, 5, 12}));
  for (const Eigen::Vector3d& goal :
       {Eigen::Vector3d(6, 7, 9), Eigen::Vector3d(12.3, 3, 4), Eigen::Vector3d(3, 30, 9.9)}) {
    proxy.follow(room, at(goal));
    EXPECT_LT((proxy.middle() - Eigen::Vector3d(goal[0], goal[1], 10)).norm(), 1e-6); // the skin
    ASSERT_EQ(proxy.constraints().size(), 1u);
    EXPECT_EQ(proxy.constraints()[0].obstacle.normal, Eigen::Vector3d::UnitZ());
    EXPECT_NEAR(proxy.constraints()[0].depth, 10 - goal[2], 1e-6);
  }
  proxy.follow(room, at({6, 6, 15})); // and it lets go
  EXPECT_EQ(proxy.middle(), Eigen::Vector3d(6, 6, 15));
  EXPECT_TRUE(proxy.constraints().empty());
}

TEST_F(RoomAnalytic, InACornerTwoPlanesHoldIt) {
  const Surroundings room(&world.map(), {1, 1, 1});
  Proxy proxy(point_tool({1, 1, 1}), at({5, 5, 12}));
  proxy.follow(room, at({23, 9, 8})); // behind the step and below the floor
  EXPECT_LT((proxy.middle() - Eigen::Vector3d(20, 9, 10)).norm(), 1e-6);
  Eigen::Vector3d drawn = Eigen::Vector3d::Zero();
  for (const Constraint& constraint : proxy.constraints())
    drawn += constraint.depth * constraint.obstacle.normal;
  EXPECT_LT((drawn - Eigen::Vector3d(-3, 0, 2)).norm(), 1e-5);
  // Up the wall and over its edge, as the hand goes on: the god-object comes out round the edge.
  for (int tick = 0; tick <= 100; ++tick)
    proxy.follow(room, at({23, 9, 8 + 0.15 * tick}));
  EXPECT_LT((proxy.middle() - Eigen::Vector3d(23, 9, 23)).norm(), 1e-6);
}

TEST_F(RoomAnalytic, ATurnedPlaneOfABodyIsFeltAlongItsNormal) {
  const Scene scene = test::box_scene(3, {6, 6, 6}, {1, 1, 1});
  const Pose pose = test::turned_pose(0.5, Eigen::Vector3d::UnitY(), {10, 10, 10});
  const Surroundings body(nullptr, {1, 1, 1}, {std::make_shared<BodySurface>(scene, Displacement(), pose)});
  const auto in_world = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector3d(pose.position + pose.rotation * p);
  };
  Proxy proxy(point_tool({1, 1, 1}), at(in_world({3, 3, 9})));
  for (const Eigen::Vector3d& goal :
       {Eigen::Vector3d(3, 3, 5.5), Eigen::Vector3d(1.1, 4.7, 5), Eigen::Vector3d(4.9, 1.2, 5.9)}) {
    proxy.follow(body, at(in_world(goal)));
    // Analytic: the foot of the perpendicular on the turned plane.
    EXPECT_LT((proxy.middle() - in_world({goal[0], goal[1], 6})).norm(), 1e-5); // the surface's skin
    Eigen::Vector3d drawn = Eigen::Vector3d::Zero();
    for (const Constraint& constraint : proxy.constraints())
      drawn += constraint.depth * constraint.obstacle.normal;
    EXPECT_LT((drawn - (6 - goal[2]) * (pose.rotation * Eigen::Vector3d::UnitZ())).norm(), 1e-5);
  }
}

// Contract: the proxy is never in matter, on random paths of all speeds, with a point and with a tool, which
// also turns.
TEST(ProxyContract, NeverEntersMatterOnRandomPaths) {
  std::mt19937 random(7);
  Dice dice{random};
  RigidWorld world({48, 48, 48}, {1, 1, 1});
  for (int i = 0; i < 40; ++i) // walls one cell thick, with holes between them
    world.add(solid({i % 3 == 0 ? 1 : 11, i % 3 == 1 ? 1 : 11, i % 3 == 2 ? 1 : 11}),
              at({dice.between(0, 36), dice.between(0, 36), dice.between(0, 36)}));
  const Scene scene = test::carved_body({7, 8, 9}, {1.3, 1.3, 1.3});
  const auto surface = std::make_shared<BodySurface>(scene, test::bent(scene, 0.6),
                                                     test::turned_pose(0.3, {1, 1, 0}, {18, 18, 18}));
  const Surroundings all(&world.map(), {1, 1, 1}, {surface});
  for (const bool is_point : {true, false}) {
    const RigidShape tool = is_point ? point_tool({1, 1, 1}) : solid({3, 2, 4}, {0.9, 0.9, 0.9});
    std::optional<Proxy> proxy;
    while (!proxy) {
      Proxy somewhere(tool, at({dice.between(5, 43), dice.between(5, 43), dice.between(5, 43)}));
      if (all.n_inside(tool, somewhere.pose()) == 0)
        proxy = somewhere;
    }
    int touched_map = 0, touched_body = 0;
    Pose hand = at({24, 24, 24});
    for (int tick = 0; tick < (is_point ? 6000 : 1500); ++tick) {
      hand.position += std::pow(10, dice.between(-3, 1)) * dice.direction();
      for (int a = 0; a < 3; ++a)
        hand.position[a] = std::clamp(hand.position[a], -5.0, 53.0);
      if (!is_point)
        hand.rotation =
            Eigen::AngleAxisd(dice.between(-0.05, 0.05), dice.direction()).toRotationMatrix() * hand.rotation;
      const Eigen::Vector3d before = proxy->middle();
      proxy->follow(all, hand);
      ASSERT_EQ(all.n_inside(tool, proxy->pose()), 0) << "tick " << tick;
      if (is_point) { // and comes nearer to the hand or stays
        ASSERT_LE((proxy->middle() - hand.position).norm(), (before - hand.position).norm() + 1e-9);
      }
      for (const Constraint& constraint : proxy->constraints())
        ++(constraint.obstacle.body >= 0 ? touched_body : touched_map);
    }
    EXPECT_GT(touched_map, 100); // else nothing was tested
    EXPECT_GT(touched_body, 50);
  }
}

// Oracle: the solid angle of a body's skin. A rod that is turned by large angles in one tick, beside a body
// and in its way, is never in it.
TEST(ProxyOracle, ATurningRodNeverEntersABody) {
  const Scene scene = test::box_scene(3, {5, 5, 5}, {1, 1, 1});
  int n_blocked = 0;
  for (const bool is_bent : {false, true}) {
    const auto body =
        std::make_shared<BodySurface>(scene, is_bent ? test::bent(scene, 0.6) : Displacement(),
                                      is_bent ? test::turned_pose(0.3, {1, 1, 0}, {0, 0, 0}) : Pose{});
    const Surroundings around(nullptr, {1, 1, 1}, {body});
    const RigidShape rod = solid({1, 1, 6});
    const auto is_inside = [&](const Pose& pose) {
      for (int i = 0; i < 6; ++i)
        if (body->is_inside_of_every_triangle(pose.position +
                                              pose.rotation * Eigen::Vector3d(0.5, 0.5, i + 0.5)))
          return true;
      return false;
    };
    std::mt19937 random(3);
    Dice dice{random};
    for (int trial = 0; trial < 120; ++trial) {
      Proxy proxy(rod, at(Eigen::Vector3d(2.5, 2.5, 2.5) + dice.between(4, 8) * dice.direction()));
      if (is_inside(proxy.pose()))
        continue;
      for (int tick = 0; tick < 12; ++tick) {
        Pose hand = at(proxy.middle() + dice.between(0, 1) * dice.direction());
        hand.rotation = Eigen::AngleAxisd(dice.between(-1.5, 1.5), dice.direction()).toRotationMatrix() *
                        proxy.pose().rotation;
        proxy.follow(around, hand);
        n_blocked += proxy.is_turn_blocked();
        ASSERT_FALSE(is_inside(proxy.pose())) << "trial " << trial << ", tick " << tick;
      }
    }
  }
  EXPECT_GT(n_blocked, 100); // else nothing was tested
}

// Analytic: a tip between the middles of a turned block's voxels, straight above it, stops at its upper face
// to half a cell.
TEST(ProxyAnalytic, APointStopsOnATurnedBlock) {
  RigidWorld world({70, 70, 60}, {1, 1, 1});
  Pose block;
  block.rotation = Eigen::AngleAxisd(std::acos(-1.0) / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  block.position = {35, 5, 20};
  world.add(solid({40, 40, 20}), block);
  const Surroundings around(&world.map(), {1, 1, 1}, {});
  for (int x = 20; x < 50; x += 3)
    for (int y = 24; y < 44; y += 3) {
      Proxy proxy(point_tool({1, 1, 1}), at({x + 0.5, y + 0.5, 55.5}));
      proxy.follow(around, at({x + 0.5, y + 0.5, 5.5}));
      ASSERT_NEAR(proxy.middle()[2], 40, 0.5 + 1e-6) << x << ' ' << y;
    }
}

// Oracle: cells that a flood through faces can come to. Through walls one cell thick nothing is ever reached,
// at any speed.
TEST(ProxyOracle, AClosedRoomIsNeverLeft) {
  RigidWorld world({30, 30, 30}, {1, 1, 1});
  std::vector<std::uint8_t> shell(20 * 20 * 20, 0);
  for (const auto& [x, y, z] : test::all_below({20, 20, 20}))
    shell[std::size_t(x + 20 * (y + 20 * z))] = x == 0 || y == 0 || z == 0 || x == 19 || y == 19 || z == 19;
  world.add(RigidShape({20, 20, 20}, {1, 1, 1}, shell), at({5, 5, 5}));
  const Scene scene = test::box_scene(3, {3, 3, 3}, {1, 1, 1});
  const auto body = std::make_shared<BodySurface>(scene, Displacement(), at({12, 12, 12}));
  const Surroundings room(&world.map(), {1, 1, 1}, {body});
  std::mt19937 random(9);
  Dice dice{random};
  Proxy proxy(point_tool({1, 1, 1}), at({9, 9, 9}));
  for (int tick = 0; tick < 20'000; ++tick) {
    proxy.follow(room,
                 at(Eigen::Vector3d(15, 15, 15) + std::pow(10, dice.between(-1, 3)) * dice.direction()));
    for (int a = 0; a < 3; ++a) {
      ASSERT_GT(proxy.middle()[a], 6) << tick;
      ASSERT_LT(proxy.middle()[a], 24) << tick;
    }
    ASSERT_FALSE(body->is_inside(proxy.middle())) << tick;
  }
}

struct Place {
  Eigen::Vector3d normal, point;
  double gap = 0;
};

/// How far a place goes along its normal, by the velocity of its point.
double along(const Place& place, const Twist& twist, double arm) {
  const Eigen::Vector3d angle = twist.tail<3>() / arm;
  return place.normal.dot(twist.head<3>() + angle.cross(place.point));
}

// Oracle: very many twists tried; none that every place allows lies nearer to the wanted one.
TEST(AllowedTwistOracle, NoAllowedTwistIsNearer) {
  std::mt19937 random(4);
  Dice dice{random};
  int n_bound = 0;
  for (int round = 0; round < 200; ++round) {
    const double arm = dice.between(1, 5);
    std::vector<Place> places(std::size_t(dice.below(30)));
    TwistConstraints constraints(arm);
    for (Place& place : places) {
      place = {dice.direction(), dice.between(1, 6) * dice.direction(), dice.between(0, 1e-3)};
      // Far arms ask for tiny turns only, so that straight and bent ways hardly differ.
      constraints.add(place.normal, place.point, place.gap);
    }
    Twist wanted;
    wanted << 1e-3 * dice.direction(), 1e-3 * dice.direction();
    const Twist allowed = constraints.allowed(wanted, 0);
    double bend = 0; // an arc's, at most, with a fifth more for what it is counted in with
    for (const Place& place : places) {
      EXPECT_GE(along(place, allowed, arm), -place.gap - 1e-10);
      bend = std::max(bend, 1e-6 * place.point.norm() / (arm * arm) * 4);
    }
    const double distance = (allowed - wanted).norm();
    n_bound += distance > 1e-6;
    for (int trial = 0; trial < 300; ++trial) {
      Twist other;
      other << dice.direction(), dice.direction();
      other = allowed + dice.between(0, 1e-3) * other;
      bool is_allowed = true;
      for (const Place& place : places)
        is_allowed = is_allowed && along(place, other, arm) >= -place.gap;
      if (is_allowed) {
        EXPECT_GE((other - wanted).norm(), distance - 30 * bend) << round;
      }
    }
  }
  EXPECT_GT(n_bound, 100); // else nothing was tested
}

// Analytic: one place on a floor beside the middle. The multiplier is that of the one row, so the shift and
// the tilt share what is refused as 1 to the square of the place's arm over the arm.
TEST(AllowedTwistAnalytic, AShiftThatIsRefusedTiltsTheTool) {
  constexpr double arm = 2, beside = 4, down = 1e-6;
  TwistConstraints constraints(arm);
  constraints.add(Eigen::Vector3d::UnitZ(), {beside, 0, 0}, 0);
  Twist wanted = Twist::Zero();
  wanted[2] = -down;
  const Twist allowed = constraints.allowed(wanted, 0);
  const double share = (beside / arm) * (beside / arm);
  EXPECT_NEAR(allowed[2], -down * share / (1 + share), 1e-10);
  EXPECT_NEAR(allowed[4], -down * (beside / arm) / (1 + share), 1e-10); // the place goes up about y
}

/// Where a path first comes in, and the face there: all triangles are asked (Moeller and Trumbore 1997).
std::optional<std::pair<double, std::int32_t>>
first_of_all_triangles(const BodySurface& surface, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  std::optional<std::pair<double, std::int32_t>> first;
  const Eigen::Vector3d path = to - from;
  for (std::int32_t face = 0; face < std::ssize(surface.faces()); ++face)
    for (const int half : {0, 1}) {
      const auto& corners = surface.faces()[std::size_t(face)].corners;
      const Eigen::Vector3d a = surface.position(corners[0]),
                            ab = surface.position(corners[half == 0 ? 1 : 2]) - a,
                            ac = surface.position(corners[half == 0 ? 2 : 3]) - a, across = path.cross(ac),
                            turned = (from - a).cross(ab);
      const double size = ab.dot(across), u = (from - a).dot(across) / size, v = path.dot(turned) / size,
                   time = ac.dot(turned) / size;
      if (size > 0 && u >= 0 && v >= 0 && u + v <= 1 && time >= 0 && time <= 1 &&
          (!first || time < first->first))
        first = {time, face};
    }
  return first;
}

// Oracle: every triangle asked.
TEST(BodySurfaceOracle, TheFirstHitIsThatOfEveryTriangle) {
  const Scene scene = test::carved_body({7, 6, 8}, {1e-3, 1.2e-3, 0.9e-3});
  const BodySurface surface(scene, test::bent(scene, 0.7),
                            test::turned_pose(0.4, {1, 2, 3}, {0.02, 0.01, 0.03}));
  std::mt19937 random(4);
  Dice dice{random};
  int hits = 0;
  for (int path = 0; path < 8000; ++path) {
    const Eigen::Vector3d middle =
        surface.pose().position + surface.pose().rotation * Eigen::Vector3d(3.5e-3, 3.5e-3, 3.5e-3);
    const Eigen::Vector3d from = middle + dice.between(0, 0.012) * dice.direction();
    const Eigen::Vector3d to = from + std::pow(10, dice.between(-4, -1)) * dice.direction();
    const auto fast = surface.first_hit(from, to);
    const auto every = first_of_all_triangles(surface, from, to);
    ASSERT_EQ(fast.has_value(), every.has_value()) << "path " << path;
    if (!fast)
      continue;
    ++hits;
    ASSERT_NEAR(fast->time, every->first,
                1e-12 + 1e-15 / (to - from).norm()); // rounding, of lengths below 0.1 m
    ASSERT_EQ(fast->face, every->second);
  }
  EXPECT_GT(hits, 500);
}

// Oracle: which cells hold matter.
TEST(BodySurfaceOracle, AtRestInsideIsWhereMatterIs) {
  const Scene scene = test::carved_body({6, 5, 7}, {1, 1, 1});
  const BodySurface surface(scene, {}, {});
  std::mt19937 random(5);
  Dice dice{random};
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d at(dice.between(-1, 7), dice.between(-1, 6), dice.between(-1, 8));
    const Index3 cell{int(std::floor(at[0])), int(std::floor(at[1])), int(std::floor(at[2]))};
    const Grid& grid = scene.specimen.grid;
    ASSERT_EQ(surface.is_inside(at), grid.has_cell(cell) && scene.specimen.is_matter(grid.cell(cell)));
  }
}

// Oracle: the solid angle of every triangle.
TEST(BodySurfaceOracle, InsideIsWhatTheSolidAngleSays) {
  const Scene scene = test::carved_body({6, 5, 7}, {1, 1.2, 0.9});
  const BodySurface surface(scene, test::bent(scene, 0.6), test::turned_pose(0.4, {1, 2, 3}, {1, 2, 3}));
  Eigen::AlignedBox3d box;
  for (const BodySurface::Face& face : surface.faces())
    for (const std::int32_t corner : face.corners)
      box.extend(surface.position(corner));
  std::mt19937 random(9);
  Dice dice{random};
  int n_inside = 0;
  for (int i = 0; i < 5000; ++i) {
    const Eigen::Vector3d unit(dice.between(0, 1), dice.between(0, 1), dice.between(0, 1));
    const Eigen::Vector3d at = box.min() + box.sizes().cwiseProduct(unit);
    const bool expected = surface.is_inside_of_every_triangle(at);
    n_inside += expected;
    ASSERT_EQ(surface.is_inside(at), expected) << "point " << i;
  }
  EXPECT_GT(n_inside, 1000);
}

TEST(BodySurfaceAnalytic, APathComesInThroughTheFaceInItsWay) {
  const Scene scene = test::box_scene(3, {4, 4, 4}, {1, 1, 1});
  Displacement stretched(scene.specimen.grid);
  for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node)
    stretched(2, node) = 0.25 * scene.specimen.grid.node_at(node)[2];
  const BodySurface surface(scene, stretched, {});
  EXPECT_EQ(surface.faces().size(), 6u * 16u);
  // Analytic: the upper face is at 4 * 1.25 = 5.
  const auto hit = surface.first_hit({1.3, 2.6, 9}, {1.3, 2.6, 1});
  ASSERT_TRUE(hit);
  EXPECT_DOUBLE_EQ(hit->time, 0.5);
  EXPECT_LT((hit->normal - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  const auto& face = surface.faces()[std::size_t(hit->face)];
  EXPECT_EQ(face.axis, 2);
  EXPECT_TRUE(face.upper);
  EXPECT_EQ(scene.specimen.grid.cell_at(face.cell), (Index3{1, 2, 3}));
  EXPECT_FALSE(surface.first_hit({1.3, 2.6, 2}, {1.3, 2.6, 9})); // out is free
  // Paths through edges and corners of triangles come in too.
  for (const double x : {0.0, 1.0, 2.5, 4.0})
    for (const double y : {0.0, 2.0, 2.5, 4.0})
      EXPECT_TRUE(surface.first_hit({x, y, 9}, {x, y, 1})) << x << ' ' << y;
}

TEST(BodySurfaceContract, OnlyBodiesOfThreeDimensionsHaveOne) {
  EXPECT_THROW(BodySurface(test::box_scene(2, {4, 4, 1}), {}, {}), std::invalid_argument);
}

} // namespace
} // namespace maille::deform
