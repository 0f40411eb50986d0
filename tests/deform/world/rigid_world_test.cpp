#include "maille/deform/world/rigid_world.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/images/image.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "support/bodies/rigid_bodies.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"
#include "world/occupancy/posed_shape.hpp"
#include "world/surface/skin.hpp"
#include "world/surface/smooth_surface.hpp"

#include <Eigen/Geometry>

namespace maille::deform {
namespace {

using std::numbers::pi;
using test::box_shape;
using test::Dice;
using test::porous_shape;
using test::random_motion;

/// The cells whose middles lie in a shape's voxels as boxes, looked for about each voxel.
std::set<Index3> cells_in_matter(const RigidShape& shape, const Pose& pose) {
  std::set<Index3> cells;
  for (std::int32_t voxel = 0; voxel < shape.n_voxels(); ++voxel) {
    const Index3 i = shape.index_of(voxel);
    const Eigen::Vector3d middle =
        pose.position + pose.rotation * Eigen::Vector3d(i[0] + 0.5, i[1] + 0.5, i[2] + 0.5);
    for (int near = 0; near < 27; ++near) {
      const Index3 cell{int(std::floor(middle[0])) + near % 3 - 1,
                        int(std::floor(middle[1])) + near / 3 % 3 - 1,
                        int(std::floor(middle[2])) + near / 9 - 1};
      const Eigen::Vector3d off =
          pose.rotation.transpose() * (Eigen::Vector3d(cell[0] + 0.5, cell[1] + 0.5, cell[2] + 0.5) - middle);
      if (off.cwiseAbs().maxCoeff() < 0.5)
        cells.insert(cell);
    }
  }
  return cells;
}

// Contract: the map always holds exactly the objects where they are, with the cells whose middles are in
// their boxes, and no two objects share a cell.
TEST(RigidWorldContract, NoObjectEverEntersAnother) {
  std::mt19937 random(8);
  Dice dice{random};
  RigidWorld world({48, 48, 48}, {1, 1, 1});
  for (int i = 0; i < 12; ++i) {
    Pose pose;
    pose.position = {dice.between(2, 36), dice.between(2, 36), dice.between(2, 36)};
    pose.rotation =
        Eigen::AngleAxisd(i % 3 == 0 ? 0 : dice.between(0, pi), dice.direction()).toRotationMatrix();
    world.add(porous_shape(dice, {8, 8, 8}, {1, 1, 1}), pose);
  }
  ASSERT_GT(world.n_objects(), 4);
  int contacts = 0;
  for (int round = 0; round < 400; ++round) {
    const int object = dice.below(world.n_objects());
    RigidMotion motion = random_motion(dice, 20, round % 2 == 0);
    motion.about = world.pose(object).position;
    const MoveResult result = world.move(object, motion);
    contacts += int(result.contacts.size());
    std::set<Index3> taken;
    for (int other = 0; other < world.n_objects(); ++other) {
      std::set<Index3> own;
      any_voxel(PosedShape(world.shape(other), world.pose(other), world.cell_size()), 0,
                world.shape(other).n_voxels(), [&](std::int32_t, const Index3& cell) {
                  EXPECT_TRUE(world.map().has_cell(cell));
                  EXPECT_EQ(world.object_of(world.map().occupant(cell)), other);
                  own.insert(cell);
                  return false;
                });
      for (const Index3& cell : cells_in_matter(world.shape(other), world.pose(other)))
        if (world.map().has_cell(cell)) // a voxel's box may reach over the border, its middle may not
          own.insert(cell);
      taken.merge(own);
      ASSERT_TRUE(own.empty()) << "two objects in one cell";
    }
    ASSERT_EQ(world.map().n_occupied(), std::int64_t(taken.size()));
  }
  EXPECT_GT(contacts, 130);
}

TEST(RigidWorldAnalytic, AThinWallStopsAnythingAtAnySpeed) {
  for (const double speed : {1.0, 7.5, 90.0}) {
    RigidWorld world({100, 9, 9}, {1, 1, 1});
    Pose wall;
    wall.position = {60, 0, 0};
    ASSERT_TRUE(world.add(box_shape({1, 9, 9}), wall).object);
    Pose start;
    start.position = {2, 3, 3};
    const int cube = *world.add(box_shape({3, 3, 3}), start).object;
    RigidMotion motion;
    motion.by = {speed, 0, 0};
    for (double done = 0; done < 95; done += speed)
      world.move(cube, motion);
    EXPECT_NEAR(world.pose(cube).position[0], 57.5,
                1e-6); // analytic: the last centre, 2.5 further, reaches 60
  }
}

TEST(RigidWorldAnalytic, ATurningBarMeetsAPegAtItsAngle) {
  RigidWorld world({64, 64, 1}, {1, 1, 1});
  // Centres at distance 1 to 20 from (32.5, 32.5) along x; the peg is the cell [45, 46) x [40, 41).
  const int bar = *world.add(box_shape({20, 1, 1}), Pose{.position = {33, 32, 0}}).object;
  ASSERT_TRUE(world.add(box_shape({1, 1, 1}), Pose{.position = {45, 40, 0}}).object);
  RigidMotion motion;
  motion.angle = pi / 2;
  motion.about = {32.5, 32.5, 0};
  const MoveResult result = world.move(bar, motion);
  ASSERT_EQ(result.contacts.size(), 1u);
  // Analytic: over all r = 1 to 20 the first time that 32.5 + r (cos, sin) lies in the peg.
  double expected = 2;
  for (int r = 1; r <= 20; ++r)
    for (const double angle : {std::asin(7.5 / r), std::acos(13.5 / r)}) {
      const double x = r * std::cos(angle), y = r * std::sin(angle), hair = 1e-9;
      if (x > 12.5 - hair && x < 13.5 + hair && y > 7.5 - hair && y < 8.5 + hair)
        expected = std::min(expected, angle / (pi / 2));
    }
  // And the first time that the bar's side, half a cell from its middle line, comes over the peg's middle,
  // which is (13, 8) away.
  expected = std::min(expected, (std::atan2(8, 13) - std::asin(0.5 / std::hypot(13, 8))) / (pi / 2));
  EXPECT_NEAR(result.contacts[0].time, expected, 1e-12);
}

TEST(RigidWorldContract, AMotionBackComesHome) {
  // Contract: a turn there and back again is the identity to rounding; without contact nothing is lost.
  RigidWorld world({64, 64, 64}, {1, 1, 1});
  const int cube = *world.add(box_shape({10, 4, 4}), Pose{.position = {30, 30, 30}}).object;
  const Pose before = world.pose(cube);
  RigidMotion motion;
  motion.axis = Eigen::Vector3d(1, 2, 3).normalized();
  motion.about = {33, 33, 33};
  motion.angle = 0.3;
  RigidMotion back = motion;
  back.angle = -0.3;
  for (int i = 0; i < 1000; ++i) {
    ASSERT_TRUE(world.move(cube, motion).contacts.empty());
    ASSERT_TRUE(world.move(cube, back).contacts.empty());
  }
  EXPECT_LT((world.pose(cube).position - before.position).norm(), 1e-11);
  EXPECT_LT((world.pose(cube).rotation - before.rotation).norm(), 1e-12);
}

TEST(RigidWorldContract, VectorsOfAnyLengthGiveTheSameCells) {
  std::mt19937 random(9);
  Dice dice{random};
  const RigidShape shape = porous_shape(dice, {33, 17, 9}, {0.7, 0.8, 0.9});
  Pose pose;
  pose.rotation = Eigen::AngleAxisd(1, dice.direction()).toRotationMatrix();
  pose.position = {20, 20, 20};
  std::vector<std::vector<Index3>> answers;
  for (const std::int64_t target : test::vector_targets()) {
    const test::ForcedVectors forced(target);
    std::vector<Index3>& cells = answers.emplace_back();
    any_voxel(PosedShape(shape, pose, {1, 1, 1}), 0, shape.n_voxels(), [&](std::int32_t, const Index3& cell) {
      cells.push_back(cell);
      return false;
    });
    EXPECT_EQ(cells, answers.front());
  }
}

TEST(RigidWorldContract, AnObjectIsNotPutWhereSomethingIs) {
  RigidWorld world({20, 20, 20}, {1, 1, 1});
  ASSERT_TRUE(world.add(box_shape({4, 4, 4}), Pose{.position = {8, 8, 8}}).object);
  const auto added = world.add(box_shape({4, 4, 4}), Pose{.position = {11, 8, 8}});
  EXPECT_FALSE(added.object);
  ASSERT_TRUE(added.refused_at);
  EXPECT_EQ(world.object_of(added.refused_at->other), 0);
  EXPECT_EQ(world.map().n_occupied(), 64);
  EXPECT_FALSE(world.add(box_shape({4, 4, 4}), Pose{.position = {17, 0, 0}}).object); // through the border
}

// Oracle: where a flood of whole steps can come to. A piece in a maze, thrown about in steps of any size, is
// never anywhere else.
TEST(RigidWorldOracle, APieceStaysInItsPartOfTheMaze) {
  const char* const rows[] = {"#####################", "#   #       #   #   #", "#   # ##### # # # # #",
                              "# #   #   # # # # # #", "# ##### # # # # # # #", "#       # #   #   # #",
                              "######### ######### #", "#       #           #", "# ##### #############",
                              "#     # #     #     #", "#####################"};
  const Index3 cells{21, 11, 1};
  std::vector<std::uint8_t> walls;
  for (const char* row : rows)
    for (const char* c = row; *c != 0; ++c)
      walls.push_back(*c == '#');
  RigidWorld world(cells, {1, 1, 1});
  ASSERT_TRUE(world.add(RigidShape(cells, {1, 1, 1}, walls), {}).object);
  const int piece = *world.add(box_shape({1, 1, 1}), Pose{.position = {1, 1, 0}}).object;
  std::set<Index3> reachable;
  std::vector<Index3> front{{1, 1, 0}};
  while (!front.empty()) {
    const Index3 at = front.back();
    front.pop_back();
    if (walls[std::size_t(at[0] + 21 * at[1])] != 0 || !reachable.insert(at).second)
      continue;
    for (const Index3 step : {Index3{1, 0, 0}, Index3{-1, 0, 0}, Index3{0, 1, 0}, Index3{0, -1, 0}})
      front.push_back({at[0] + step[0], at[1] + step[1], 0});
  }
  std::mt19937 random(12);
  Dice dice{random};
  std::set<Index3> visited;
  for (int round = 0; round < 20000; ++round) {
    const double angle = dice.between(0, 2 * pi), size = std::pow(10, dice.between(-2, 2));
    RigidMotion motion;
    motion.by = {size * std::cos(angle), size * std::sin(angle), 0};
    world.move(piece, motion);
    const Index3 cell = PosedShape(world.shape(piece), world.pose(piece), {1, 1, 1}).cell(0);
    ASSERT_TRUE(reachable.contains(cell)) << cell[0] << ' ' << cell[1] << " in round " << round;
    visited.insert(cell);
  }
  EXPECT_GT(visited.size(), reachable.size() / 3); // it does get about
  EXPECT_LT(reachable.size(), 120u);               // and there are parts that it must not come to
}

/// The smooth surface that voxels stand for.

/// Corners of a body's surface, from its grid's lower corner.
std::vector<Eigen::Vector3d> corners_of(const Specimen& body) {
  const Skin skin(body);
  std::vector<Eigen::Vector3d> corners;
  for (std::int32_t i = 0; i < skin.n_nodes(); ++i) {
    const Index3 at = body.grid.node_at(skin.node(i));
    Eigen::Vector3d corner = Eigen::Vector3d::Zero();
    for (int a = 0; a < body.grid.dimension(); ++a)
      corner[a] = at[std::size_t(a)] * body.grid.spacing()[std::size_t(a)];
    corners.push_back(corner);
  }
  return corners;
}

Specimen rigid_body(const std::string& shape, const std::string& cells) {
  return parse_world_scene(fmt::format("[world]\ncells = [99, 99, 99]\nspacing = \"1 mm\"\ncontact = "
                                       "\"surfaces\"\n[[object]]\nname = \"a\"\nkind = \"rigid\"\nshape = "
                                       "\"{}\"\ncells = [{}]\nspacing = [\"1 mm\", \"2 mm\", \"1 mm\"]\n",
                                       shape, cells))
      .objects[0]
      .scene.specimen;
}

// Analytic: an ellipsoid's equation, also where its box was cut down: no cell's middle is in its last layers.
TEST(SmoothSurfaceAnalytic, CornersOfAnEllipsoidComeToLieOnIt) {
  for (const Vec3& cells : {Vec3{16, 8, 12}, Vec3{60, 4, 4}}) {
    const Specimen body = rigid_body("ellipsoid", fmt::format("{}, {}, {}", cells[0], cells[1], cells[2]));
    std::vector<Eigen::Vector3d> corners = corners_of(body);
    const std::vector<Eigen::Vector3d> before = corners;
    make_smooth(body, corners);
    const Eigen::Vector3d axes(0.5e-3 * cells[0], 1e-3 * cells[1], 0.5e-3 * cells[2]),
        cut = Eigen::Vector3d::Map(body.position({0, 0, 0}).data());
    for (std::size_t i = 0; i < corners.size(); ++i)
      EXPECT_NEAR((corners[i] + cut - axes).cwiseQuotient(axes).norm(), 1, 1e-12);
    EXPECT_LT(body.grid.cells()[0], cells[0] == 60 ? 60 : 17);
    EXPECT_NE(before, corners);
  }
}

// Analytic: a plane of voxels is its own surface; around it edges are rounded.
TEST(SmoothSurfaceAnalytic, FlatFacesStay) {
  Specimen body = rigid_body("box", "15, 15, 15");
  std::vector<Eigen::Vector3d> corners = corners_of(body);
  const std::vector<Eigen::Vector3d> before = corners;
  make_smooth(body, corners);
  std::int64_t inner = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d cells = before[i].cwiseQuotient(Eigen::Vector3d(1e-3, 2e-3, 1e-3));
    int near_edge = 0;
    for (int a = 0; a < 3; ++a)
      near_edge += cells[a] < 6.5 || cells[a] > 8.5;
    if (near_edge == 1) { // in the middle of a face
      EXPECT_LT((corners[i] - before[i]).norm(), 1e-4 * 1e-3);
      ++inner;
    }
    EXPECT_LT((corners[i] - before[i]).cwiseQuotient(Eigen::Vector3d(1e-3, 2e-3, 1e-3)).norm(), 1.001);
  }
  EXPECT_EQ(inner, 6 * 4);
}

// Analytic: a ball's voxels, of which nothing tells that it is one. Corners lie up to 0.9 cells off it.
TEST(SmoothSurfaceAnalytic, VoxelsOfABallComeNearIt) {
  Specimen body = rigid_body("box", "24, 24, 24");
  body.grid = Grid(3, {24, 24, 24}, {1e-3, 1e-3, 1e-3});
  body.material_id.assign(std::size_t(body.grid.n_cells()), no_material);
  const double radius = 10.3e-3;
  const Eigen::Vector3d middle(12.1e-3, 11.8e-3, 12e-3);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell) {
    const Index3 at = body.grid.cell_at(cell);
    if ((1e-3 * Eigen::Vector3d(at[0] + 0.5, at[1] + 0.5, at[2] + 0.5) - middle).norm() < radius)
      body.material_id[std::size_t(cell)] = 0;
  }
  std::vector<Eigen::Vector3d> corners = corners_of(body);
  const auto off = [&] { // root of the mean square, in cells
    double sum = 0;
    for (const Eigen::Vector3d& corner : corners)
      sum += std::pow(((corner - middle).norm() - radius) / 1e-3, 2);
    return std::sqrt(sum / double(corners.size()));
  };
  const double before = off();
  make_smooth(body, corners);
  EXPECT_GT(before, 0.35);
  EXPECT_LT(off(), 0.1);
}

constexpr float bone = 1150;

/// Cells that one voxel can come to from `start`, through faces.
std::vector<bool> reachable_from(const OccupancyMap& map, const Index3& start) {
  const Index3& n = map.cells();
  const auto number = [&](const Index3& at) { return std::size_t(at[0] + n[0] * (at[1] + n[1] * at[2])); };
  std::vector<bool> seen(std::size_t(n[0] * n[1] * n[2]));
  std::vector<Index3> front{start};
  while (!front.empty()) {
    const Index3 at = front.back();
    front.pop_back();
    if (map.is_blocked(at) || seen[number(at)])
      continue;
    seen[number(at)] = true;
    for (std::size_t a = 0; a < 3; ++a)
      for (const int step : {-1, 1}) {
        Index3 next = at;
        next[a] += step;
        front.push_back(next);
      }
  }
  return seen;
}

// Real data: a head from CT. Truth: what can be reached through faces, found by a flood (oracle).
TEST(HeadData, AFingertipFeelsTheSkullAndNeverEntersIt) {
  const char* const data = std::getenv("MAILLE_DATA");
  const std::filesystem::path file =
      std::filesystem::path(data == nullptr ? "" : data) / "head_ct/headsq.mha";
  if (data == nullptr || !std::filesystem::exists(file))
    GTEST_SKIP() << "MAILLE_DATA names no folder with head_ct/headsq.mha";
  const Image image = read_image(file);
  std::vector<std::uint8_t> matter;
  for (const float value : image.values)
    matter.push_back(value > bone);
  const Index3& cells = image.info.size;
  RigidWorld world(cells, image.info.spacing);
  ASSERT_TRUE(world.add(RigidShape(cells, image.info.spacing, matter), {}).object);
  const RigidShape tip({1, 1, 1}, image.info.spacing, std::vector<std::uint8_t>{1});
  const int finger = *world.add(tip, {}).object;
  // The flood is of the world without the fingertip.
  RigidWorld without(cells, image.info.spacing);
  ASSERT_TRUE(without.add(RigidShape(cells, image.info.spacing, matter), {}).object);
  const std::vector<bool> reachable = reachable_from(without.map(), {0, 0, 0});

  std::mt19937 random(21);
  std::normal_distribution<double> normal;
  int felt = 0;
  for (int path = 0; path < 100'000; ++path) {
    RigidMotion motion;
    const double reach = std::pow(10, -3 + 3.0 * double(random() % 1000) / 1000); // 1 mm to 1 m
    motion.by = reach * Eigen::Vector3d(normal(random), normal(random), normal(random));
    const MoveResult result = world.move(finger, motion);
    for (const Contact& contact : result.contacts)
      felt += contact.other != no_voxel;
    const Index3 at = PosedShape(tip, world.pose(finger), world.cell_size()).cell(0);
    ASSERT_TRUE(reachable[std::size_t(at[0] + cells[0] * (at[1] + cells[1] * at[2]))]) << "in path " << path;
  }
  EXPECT_GT(felt, 1000); // it does come to the skull
}

} // namespace
} // namespace maille::deform
