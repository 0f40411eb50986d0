/// Fixed, rigid and deformable objects in one map.

#include "maille/deform/world/world.hpp"
#include "support/kit.hpp"
#include "support/worlds/feasible_world.hpp"
#include "support/worlds/worlds.hpp"
#include "world/occupancy/posed_lattice.hpp"
#include "world/voxels/hand_on.hpp"

namespace maille::deform {
namespace {

using test::box_object;
using test::elastic_object;
using test::empty_world;
using test::even_limits;
using test::expect_feasible;
using test::expect_map_in_step;
using test::face_nodes;
using test::hold_face;

Drive drive_of(int object, const Eigen::Vector3d& by, std::vector<std::int64_t> nodes = {}) {
  Drive drive;
  drive.object = object;
  drive.motion.by = by;
  drive.nodes = std::move(nodes);
  return drive;
}

FrameResult advance(World& world, const Drive& drive, const FrameBudget& budget = {}) {
  return world.advance({&drive, 1}, budget);
}

// Analytic: Gibson 1995, figure 7. Pushed, voxels follow at the least separation; pulled, at the largest.
TEST(WorldAnalytic, ABarIsPushedAndPulledAsInFigure7) {
  for (const double step : {0.3, 3.0}) {
    WorldScene scene = empty_world({40}, "limits");
    scene.objects = {box_object("bar", ObjectKind::deformable, {10}, {9.5, 0, 0}, even_limits(1.4, 0.75, 0))};
    World pushed(scene), pulled(scene);
    for (double done = 0; done < 3 - 1e-9; done += step) {
      EXPECT_EQ(advance(pushed, drive_of(0, {step, 0, 0}, {0})).status, Status::done);
      EXPECT_EQ(advance(pulled, drive_of(0, {-step, 0, 0}, {0})).status, Status::done);
    }
    for (int i = 0; i <= 10; ++i) {
      EXPECT_NEAR(pushed.displacement(0)(0, i), std::max(0.0, 3 - 0.25 * i), 1e-12);
      EXPECT_NEAR(pulled.displacement(0)(0, i), -std::max(0.0, 3 - 0.4 * i), 1e-12);
    }
    expect_feasible(pushed);
    expect_map_in_step(pushed);
  }
}

// Analytic: two stiff bars and a wall. All movement that is asked for is made by one bar or the other until
// the wall is met, and not after.
TEST(WorldAnalytic, MovementThatIsHandedOnAddsUp) {
  WorldScene scene = empty_world({30}, "limits");
  scene.objects = {box_object("a", ObjectKind::deformable, {3}, {2.5, 0, 0}),
                   box_object("b", ObjectKind::deformable, {3}, {8.5, 0, 0}),
                   box_object("wall", ObjectKind::fixed, {2}, {20, 0, 0})};
  World world(scene);
  double asked = 0, refused = 0;
  for (int frame = 0; frame < 60; ++frame) {
    const double before = world.position(1, 0)[0];
    const auto result = advance(world, drive_of(0, {0.375, 0, 0}, {0}));
    asked += 0.375;
    double received = 0;
    for (const HandOver& hand_over : result.handed_on) {
      ASSERT_EQ(hand_over.to, 1);
      received += hand_over.moved;
      refused += hand_over.refused();
    }
    ASSERT_NEAR(world.position(1, 0)[0] - before, received, 1e-12);
    expect_feasible(world);
  }
  const double a = world.position(0, 0)[0] - 2.5, b = world.position(1, 0)[0] - 8.5;
  EXPECT_NEAR(a + b + refused, asked, 1e-7); // contacts keep a billionth of a cell each
  EXPECT_GT(refused, 1);
  EXPECT_NEAR(world.position(1, 3)[0], 20, 1e-7); // at the wall
  EXPECT_NEAR(world.position(0, 3)[0], 16,
              1e-7); // at the face of cell 16, which the other's first node is in, just below 17
}

// Analytic: a bar between a held end and a rigid plane, nu = 0: the ramp, and its force E A strain.
TEST(WorldAnalytic, ARigidPlanePressesABarEvenly) {
  for (const char* method : {"coupled", "relaxed"}) {
    WorldScene scene = empty_world({12, 24}, method);
    scene.objects = {elastic_object("bar", {4, 8}, {4, 4, 0}),
                     box_object("plane", ObjectKind::rigid, {10, 2}, {1, 14, 0})};
    scene.objects[0].scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0);
    hold_face(scene.objects[0], 1, false);
    World world(scene);
    for (int frame = 0; frame < 8; ++frame)
      ASSERT_EQ(advance(world, drive_of(1, {0, -0.5, 0})).status, Status::done);
    // The plane's lower voxels have gone from cell 14 to cell 10: the top is at 10, 2 below rest.
    for (int y = 0; y <= 8; ++y)
      EXPECT_NEAR(world.displacement(0)(1, 2 + 5 * y), -0.25 * y, 1e-4); // the method's tolerance
    const auto result = advance(world, drive_of(1, {0, -1e-3, 0}));
    EXPECT_EQ(result.contacts.size(), 5u);
    EXPECT_NEAR(result.drives[0].force[1], -1e4 * 0.25 * 4, 20); // E strain width
    expect_feasible(world);
    // Let go of, it comes back all the way.
    for (int frame = 0; frame < 8; ++frame)
      advance(world, drive_of(1, {0, 0.5, 0}));
    EXPECT_NEAR(world.displacement(0)(1, 2 + 5 * 8), 0, 1e-12);
  }
}

// Analytic: Coulomb. A plane pressed on a bar and shifted along it takes it along up to friction times the
// pressing force, and no further.
TEST(WorldAnalytic, FrictionHoldsUpToItsCoefficient) {
  for (const double friction : {0.0, 0.05, 5.0}) {
    WorldScene scene = empty_world({16, 24}, "coupled");
    scene.friction = friction;
    scene.objects = {elastic_object("bar", {4, 8}, {4.5, 4, 0}),
                     box_object("plane", ObjectKind::rigid, {10, 2}, {1, 14, 0})};
    scene.objects[0].scene.materials[0].elasticity = ElasticConstants::isotropic(1e4, 0);
    hold_face(scene.objects[0], 1, false);
    World world(scene);
    for (int frame = 0; frame < 4; ++frame)
      ASSERT_EQ(advance(world, drive_of(1, {0, -1, 0})).status, Status::done);
    FrameResult result;
    for (int frame = 0; frame < 4; ++frame) {
      result = advance(world, drive_of(1, {0.25, 0, 0}));
      ASSERT_EQ(result.status, Status::done) << result.message;
      expect_feasible(world);
    }
    const double pressing = -result.drives[0].force[1], along = result.drives[0].force[0];
    const double carried = world.displacement(0)(0, 2 + 5 * 8);
    EXPECT_GT(pressing, 5e3);
    EXPECT_LE(along, friction * pressing * 1.02 + 1e-6);
    if (friction == 0.05) { // the shift of 1 asks for 809 where 500 hold it: slips
      EXPECT_GE(along, friction * pressing * 0.9);
      EXPECT_LT(carried, 0.9);
      EXPECT_GT(carried, 0.01);
    } else
      EXPECT_NEAR(carried, friction > 0 ? 1 : 0, 0.02); // sticks, or feels nothing
  }
}

// Contract: two soft bodies pressed together, as the prototype that Gibson 1995 announces: neither enters the
// other, both yield alike.
TEST(WorldContract, TwoSoftBodiesPressedTogetherYieldAlike) {
  WorldScene scene = empty_world({40, 16}, "coupled");
  scene.objects = {elastic_object("a", {8, 8}, {4.5, 3.5, 0}), elastic_object("b", {8, 8}, {13.5, 3.5, 0})};
  hold_face(scene.objects[1], 0, true);
  World world(scene);
  FrameResult result;
  for (int frame = 0; frame < 8; ++frame) {
    result = advance(world, drive_of(0, {0.5, 0, 0}, face_nodes(scene.objects[0], 0, false)));
    ASSERT_EQ(result.status, Status::done) << result.message;
    ASSERT_LT(result.rounds, 60);
    expect_feasible(world);
    expect_map_in_step(world);
  }
  // 4 of movement less a gap of 1: 3 to be shared. Truth: alike bodies press alike.
  double on_a = 0, on_b = 0;
  for (const WorldContact& contact : result.contacts)
    (contact.object == 0 ? on_a : on_b) += contact.force[0];
  EXPECT_NEAR(on_a, -on_b, 1e-3 * on_b);
  EXPECT_GT(on_b, 1e4);
  const double shortened_a = 8 - (world.position(0, 8)[0] - world.position(0, 0)[0]),
               shortened_b = 8 - (world.position(1, 8)[0] - world.position(1, 0)[0]);
  EXPECT_NEAR(shortened_a, 1.5, 0.01);
  EXPECT_NEAR(shortened_b, 1.5, 0.01);
}

// Contract: a tool goes into a body as far as the limits let it, exactly, and no further.
TEST(WorldContract, LimitsStopARigidTool) {
  WorldScene scene = empty_world({24, 24}, "limits");
  scene.objects = {
      box_object("body", ObjectKind::deformable, {8, 8}, {4.5, 4.5, 0}, even_limits(1.3, 0.75, 0.3)),
      box_object("punch", ObjectKind::rigid, {3, 3}, {6, 14, 0})};
  hold_face(scene.objects[0], 1, false);
  World world(scene);
  FrameResult result;
  for (int frame = 0; frame < 20; ++frame) {
    result = advance(world, drive_of(1, {0, -0.25, 0}));
    expect_feasible(world);
  }
  EXPECT_EQ(result.status, Status::clamped);
  EXPECT_FALSE(result.message.empty());
  // Eight links of 1 - 0.75 below the tool: 2, from 12.5 to 10.5 at most; the tool cannot enter cell 10, its
  // face is at 11.
  EXPECT_NEAR(world.position(0, 9 * 8 + 2)[1], 10.5, 1e-7);
  EXPECT_GT(world.pose(1).position[1], 10.5 - 1e-6); // its lowest centres still in cell 11
}

// Contract: dense regions. Many nodes share a cell, the map keeps in step, and who enters the cell moves them
// all.
TEST(WorldContract, NodesThatShareACellArePushedTogether) {
  WorldScene scene = empty_world({12, 12}, "limits");
  scene.objects = {
      box_object("fine", ObjectKind::deformable, {8, 8}, {4.1, 4.1, 0}, even_limits(1.5, 0.5, 0.5)),
      box_object("tool", ObjectKind::rigid, {2, 4}, {0, 4, 0})};
  scene.objects[0].scene.specimen.grid = Grid(2, {8, 8, 1}, {0.25, 0.25, 1}); // 16 nodes a cell
  World world(scene);
  EXPECT_EQ(world.voxels_in({4, 4, 0}).size(), 16u);
  expect_map_in_step(world);
  for (int frame = 0; frame < 12; ++frame) {
    advance(world, drive_of(1, {0.4, 0.05, 0}));
    expect_feasible(world);
    expect_map_in_step(world);
  }
  EXPECT_GT(world.position(0, 0)[0], 5); // it has been pushed along
}

// Contract: whatever ends a frame, the state is feasible, and a frame with all the time settles
// what was left.
TEST(WorldContract, AFrameMayEndAtAnyTime) {
  WorldScene scene = empty_world({40, 16}, "coupled");
  scene.objects = {elastic_object("a", {8, 8}, {4.5, 3.5, 0}), elastic_object("b", {8, 8}, {13.5, 3.5, 0})};
  hold_face(scene.objects[1], 0, true);
  const auto left = face_nodes(scene.objects[0], 0, false);
  for (int rounds = 1; rounds < 12; ++rounds) {
    World world(scene);
    FrameBudget budget;
    budget.rounds = rounds;
    const auto result = advance(world, drive_of(0, {4, 0.75, 0}, left), budget);
    ASSERT_EQ(result.status, Status::budget_reached);
    ASSERT_LE(result.rounds, rounds);
    expect_feasible(world);
    for (int frame = 0; frame < 10; ++frame) {
      advance(world, drive_of(0, {0.1, 0, 0}, left), budget);
      expect_feasible(world);
    }
    EXPECT_EQ(world.advance({}).status, Status::done); // with all the time
    EXPECT_EQ(world.advance({}).rounds, 0);            // nothing is left to do
    expect_feasible(world);
  }
  World world(scene);
  FrameBudget budget;
  budget.stop_requested = [] { return true; };
  EXPECT_EQ(advance(world, drive_of(0, {4, 0, 0}, left), budget).status, Status::interrupted);
  budget = {};
  budget.seconds = 0;
  EXPECT_EQ(advance(world, drive_of(0, {4, 0, 0}, left), budget).status, Status::budget_reached);
  EXPECT_EQ(world.displacement(0)(0, 0), 0);
}

TEST(WorldContract, AFreeRigidObjectIsPushed) {
  WorldScene scene = empty_world({30, 6}, "limits");
  scene.objects = {box_object("hand", ObjectKind::rigid, {2, 2}, {1, 2, 0}),
                   box_object("first", ObjectKind::rigid, {2, 2}, {5, 2, 0}),
                   box_object("second", ObjectKind::rigid, {2, 2}, {10, 2, 0}),
                   box_object("wall", ObjectKind::fixed, {1, 6}, {20, 0, 0})};
  World world(scene);
  for (int frame = 0; frame < 10; ++frame) {
    advance(world, drive_of(0, {3.5, 0, 0}));
    expect_feasible(world);
  }
  // Three objects of two cells before the wall at 20; centres may come up to half a cell nearer than faces.
  EXPECT_NEAR(world.pose(2).position[0], 18.5, 1.01);
  EXPECT_NEAR(world.pose(0).position[0], 14.5, 1.51);
  // A driven object stays in place until it is released.
  const double before = world.pose(0).position[0];
  advance(world, drive_of(1, {-3, 0, 0}));
  EXPECT_EQ(world.pose(0).position[0], before);
  world.release(0);
  advance(world, drive_of(1, {-3, 0, 0}));
  EXPECT_LT(world.pose(0).position[0], before - 2);
}

TEST(WorldContract, RequestsThatMakeNoSenseAreRefusedBeforeAnythingMoves) {
  WorldScene scene = empty_world({12, 12}, "limits");
  scene.objects = {
      box_object("body", ObjectKind::deformable, {2, 2}, {2.5, 2.5, 0}, even_limits(1.2, 0.8, 0.1)),
      box_object("wall", ObjectKind::fixed, {1, 1}, {8, 8, 0})};
  World world(scene);
  EXPECT_THROW(advance(world, drive_of(1, {1, 0, 0})), std::invalid_argument);
  EXPECT_THROW(advance(world, drive_of(7, {1, 0, 0})), std::invalid_argument);
  EXPECT_THROW(advance(world, drive_of(0, {1, 0, 0}, {100})), std::invalid_argument);
  EXPECT_THROW(advance(world, drive_of(0, {std::nan(""), 0, 0}, {0})), std::invalid_argument);
  WorldScene bad = scene;
  bad.objects[1].position = {3, 3, 0};
  EXPECT_THROW(World{bad}, std::invalid_argument);
  bad = scene;
  bad.objects[0].scene.limits = {}; // taut
  EXPECT_THROW(World{bad}, std::invalid_argument);
  bad = scene;
  bad.method = "fem_q1";
  EXPECT_THROW(World{bad}, std::invalid_argument);
  bad = scene;
  test::prescribe(bad.objects[0].scene, 0, 0, 1, false);
  EXPECT_THROW(World{bad}, std::invalid_argument);
}

/// Bodies that nothing holds, one on another, pressed to the floor until their limits stop the tool.
class StackedBodiesAnalytic : public testing::TestWithParam<const char*> {};

// Analytic: a body of six links of 0.7 is 4.2 high at least. The lower one stands on the floor, so its top
// comes to 4.2, in cell 4; the upper one stands on the face at 5, so its top comes to 9.2, in cell 9. The
// tool's lowest centres stop at 10.
TEST_P(StackedBodiesAnalytic, EachHandsOnWhatItCannotTake) {
  WorldScene scene = empty_world({12, 24}, GetParam());
  const NeighbourLimits limits = even_limits(1.3, 0.7, 0.3);
  scene.objects = {box_object("lower", ObjectKind::deformable, {6, 6}, {2.5, 1.5, 0}, limits),
                   box_object("upper", ObjectKind::deformable, {6, 6}, {2.5, 9.5, 0}, limits),
                   box_object("tool", ObjectKind::rigid, {10, 2}, {1, 20, 0})};
  World world(scene);
  Drive down;
  down.object = 2;
  down.motion.by = {0, -0.25, 0};
  FrameResult result;
  for (int frame = 0; frame < 60; ++frame) {
    result = world.advance({&down, 1});
    expect_feasible(world);
  }
  EXPECT_EQ(result.status, Status::clamped); // 15 would be too much
  EXPECT_NEAR(world.pose(2).position[1], 9.5, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(Methods, StackedBodiesAnalytic, testing::Values("coupled", "relaxed", "limits"),
                         [](const auto& method) { return std::string(method.param); });

/// The rule of Gibson 1995 for the transfer of momentum.

/// hand_on without a map: searches all voxels for each cell. Oracle of who is met; the chain is a copy.
namespace literally {

/// Gap at which a voxel stops before a face [cells], the same as for nodes in contact.
constexpr double skin = 1e-9;

Index3 cell_of(const FreeVoxel& voxel) {
  return cell_at({voxel.place[0], voxel.place[1], voxel.place[2]});
}

/// The voxel met on a straight way, and the time; `next` is the empty id at the border.
struct Met {
  double time;
  VoxelId next;
};

/// How far along its way a voxel goes that is stopped at a time.
Eigen::Vector3d before_face(const Eigen::Vector3d& movement, double time) {
  return std::max(0.0, time - skin / movement.cwiseAbs().maxCoeff()) * movement;
}

/// Contents of a cell.
struct Look {
  bool is_blocked = false;
  VoxelId voxel = no_voxel; ///< the voxel there when blocked; the empty id outside the world
};

/// The chain of transfers, whatever finds who is in the way. @param meet finds what a voxel meets on its way;
/// @param look what is in a cell;
/// @param place puts a voxel elsewhere
template<class Meet, class LookAt, class Place>
Transfer follow_chain(std::span<FreeVoxel> voxels, VoxelId first, const Eigen::Vector3d& movement,
                      const Meet& meet, const LookAt& look, const Place& place) {
  Transfer transfer;
  Eigen::Vector3d rest = movement;
  for (VoxelId voxel = first; !rest.isZero(0);) {
    FreeVoxel& moving = voxels[static_cast<std::size_t>(voxel)];
    if (moving.is_fixed) {
      transfer.refused = rest;
      transfer.refused_by = voxel;
      break;
    }
    std::optional<Met> met = meet(voxel, rest);
    // A way that ends on a face, or is rounded across one.
    const Look end = look(cell_of({moving.place + rest, false}));
    if (!met && end.is_blocked && end.voxel != voxel)
      met = Met{1, end.voxel};
    VoxelMove move{voxel, rest, met ? before_face(rest, met->time) : rest};
    place(voxel, Eigen::Vector3d(moving.place + move.moved));
    transfer.moves.push_back(move);
    if (!met)
      break;
    rest -= move.moved;
    if (met->next == no_voxel) {
      transfer.refused = rest;
      break;
    }
    voxel = met->next;
  }
  return transfer;
}

Transfer hand_on(const Index3& cells, std::span<FreeVoxel> voxels, VoxelId voxel,
                 const Eigen::Vector3d& movement) {
  const auto look = [&](const Index3& cell) {
    for (std::size_t a = 0; a < 3; ++a)
      if (cell[a] < 0 || cell[a] >= cells[a])
        return Look{true, no_voxel};
    for (std::size_t i = 0; i < voxels.size(); ++i)
      if (cell_of(voxels[i]) == cell)
        return Look{true, static_cast<VoxelId>(i)};
    return Look{};
  };
  const auto meet = [&](VoxelId moving, const Eigen::Vector3d& rest) -> std::optional<Met> {
    const FreeVoxel& from = voxels[static_cast<std::size_t>(moving)];
    Index3 cell = cell_of(from);
    for (double now = 0;;) {
      double first = 2; // when the line leaves the cell, and along which axis
      std::size_t axis = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        const auto i = static_cast<Eigen::Index>(a);
        const double face = cell[a] + (rest[i] > 0 ? 1 : 0),
                     crossing = rest[i] == 0 ? 2 : std::max((face - from.place[i]) / rest[i], now);
        if (crossing < first) {
          first = crossing;
          axis = a;
        }
      }
      if (!(first < 1))
        return std::nullopt;
      now = first;
      cell[axis] += rest[static_cast<Eigen::Index>(axis)] > 0 ? 1 : -1;
      if (const Look there = look(cell); there.is_blocked)
        return Met{now, there.voxel};
    }
  };
  const auto place = [&](VoxelId moving, const Eigen::Vector3d& to) {
    voxels[static_cast<std::size_t>(moving)].place = to;
  };
  return follow_chain(voxels, voxel, movement, meet, look, place);
}

} // namespace literally

OccupancyMap map_of(const Index3& cells, const std::vector<FreeVoxel>& voxels) {
  OccupancyMap map(cells);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const Eigen::Vector3d& x = voxels[i].place;
    map.put({int(x[0]), int(x[1]), int(x[2])}, static_cast<VoxelId>(i));
  }
  return map;
}

std::vector<FreeVoxel> row_of(int n, double first) {
  std::vector<FreeVoxel> voxels;
  for (int i = 0; i < n; ++i)
    voxels.push_back({{first + i, 0.5, 0.5}, false});
  return voxels;
}

double sum_of_moves(const Transfer& transfer, Eigen::Index axis) {
  double sum = 0;
  for (const VoxelMove& move : transfer.moves)
    sum += move.moved[axis];
  return sum;
}

// Analytic: every voxel of a row has half a cell before it; the movement is used up by as many as it takes.
TEST(HandOnAnalytic, ARowTakesTheMovementInTurn) {
  std::vector<FreeVoxel> voxels = row_of(6, 1.5);
  OccupancyMap map = map_of({20, 1, 1}, voxels);
  const Transfer transfer = hand_on(map, voxels, 0, {1.8, 0, 0});
  const double expected[] = {0.5, 0.5, 0.5, 0.3};
  ASSERT_EQ(transfer.moves.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(transfer.moves[i].voxel, static_cast<VoxelId>(i));
    EXPECT_NEAR(transfer.moves[i].moved[0], expected[i], 1e-8); // stops a billionth of a cell before a face
    EXPECT_NEAR(voxels[i].place[0], 1.5 + double(i) + expected[i], 1e-8);
  }
  EXPECT_EQ(voxels[4].place[0], 5.5);
  EXPECT_TRUE(transfer.refused.isZero(0));
  // The last of the row has room: it takes whatever is left, over several cells.
  const Transfer far = hand_on(map, voxels, 5, {7.25, 0, 0});
  ASSERT_EQ(far.moves.size(), 1u);
  EXPECT_EQ(voxels[5].place[0], 13.75);
}

// Analytic: "until either the sum of the voxel movements is equal to the desired movement or a fixed voxel is
// encountered".
TEST(HandOnAnalytic, AFixedVoxelAndTheBorderEndTheTransfer) {
  for (const bool at_border : {false, true}) {
    std::vector<FreeVoxel> voxels = row_of(4, 0.5);
    voxels[3].is_fixed = !at_border;
    OccupancyMap map = map_of({4, 1, 1}, voxels);
    const Transfer transfer = hand_on(map, voxels, 0, {3, 0, 0});
    const double moved = at_border ? 2 : 1.5; // half a cell each, of four voxels or of three
    EXPECT_EQ(transfer.moves.size(), at_border ? 4u : 3u);
    EXPECT_NEAR(sum_of_moves(transfer, 0), moved, 1e-8);
    EXPECT_NEAR(transfer.refused[0], 3 - moved, 1e-8);
    EXPECT_EQ(transfer.refused_by, at_border ? no_voxel : 3);
  }
}

// Oracle: every cell looked for among all voxels. And whatever happens, all that was asked is moved or
// refused, and no cell has two voxels.
TEST(HandOnOracle, TheMapFindsWhomASearchAmongAllVoxelsFinds) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  std::size_t longest = 0;
  int refused = 0;
  for (int round = 0; round < 60; ++round) {
    const int dimension = 1 + round % 3;
    const Index3 cells{dimension == 1 ? 60 : 9, dimension > 1 ? 9 : 1, dimension > 2 ? 5 : 1};
    std::vector<FreeVoxel> fast;
    for (int z = 0; z < cells[2]; ++z)
      for (int y = 0; y < cells[1]; ++y)
        for (int x = 0; x < cells[0]; ++x)
          if (unit(random) < 0.6) {
            FreeVoxel voxel{{x + unit(random), 0.5, 0.5}, unit(random) < 0.05};
            if (dimension > 1)
              voxel.place[1] = y + unit(random);
            if (dimension > 2)
              voxel.place[2] = z + unit(random);
            fast.push_back(voxel);
          }
    std::vector<FreeVoxel> literal = fast;
    OccupancyMap map = map_of(cells, fast);
    for (int push = 0; push < 50; ++push) {
      Eigen::Vector3d movement = Eigen::Vector3d::Zero();
      for (int a = 0; a < dimension; ++a)
        movement[a] = 8 * (unit(random) - 0.5) * unit(random);
      if (push % 7 == 0)
        movement[0] = std::round(movement[0]); // also ways that end on faces
      const auto voxel = static_cast<VoxelId>(random() % fast.size());
      const Transfer a = hand_on(map, fast, voxel, movement),
                     b = literally::hand_on(cells, literal, voxel, movement);
      ASSERT_EQ(a.moves.size(), b.moves.size()) << "round " << round << ", push " << push;
      ASSERT_EQ(a.refused_by, b.refused_by);
      Eigen::Vector3d sum = a.refused;
      for (std::size_t i = 0; i < a.moves.size(); ++i) {
        ASSERT_EQ(a.moves[i].voxel, b.moves[i].voxel);
        sum += a.moves[i].moved;
      }
      ASSERT_LT((sum - movement).norm(), 1e-14 * (1 + double(a.moves.size())));
      std::set<Index3> taken;
      for (std::size_t i = 0; i < fast.size(); ++i) {
        ASSERT_EQ(fast[i].place, literal[i].place) << "round " << round << ", push " << push;
        const Eigen::Vector3d& x = fast[i].place;
        const Index3 cell{int(std::floor(x[0])), int(std::floor(x[1])), int(std::floor(x[2]))};
        ASSERT_TRUE(taken.insert(cell).second) << "two voxels in one cell";
        ASSERT_EQ(map.occupant(cell), static_cast<VoxelId>(i));
      }
      longest = std::max(longest, a.moves.size());
      refused += a.refused.isZero(0) ? 0 : 1;
    }
  }
  EXPECT_GT(longest, 8u); // else nothing was tested
  EXPECT_GT(refused, 100);
}

} // namespace
} // namespace maille::deform
