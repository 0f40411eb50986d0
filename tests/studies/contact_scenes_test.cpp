/// The scenes of contact of docs/world.md, played from their files.

#include "studies/prototype_scenes.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>

namespace maille::studies {
namespace {
using test::mm;
using test::object_named;
using test::play_to_the_end;
using test::player_of;

double lowest_of_grid(const deform::World& world, int body) {
  double depth = 0;
  for (const double u : world.displacement(body).component(2))
    depth = std::max(depth, -u);
  return depth;
}

// The block's top is at 40 mm; the tip, one voxel, is turned by nothing and led onto it between columns.
TEST(ContactScenesContract, ATurnedBlockHasNoHoleForAFingertip) {
  Player player = player_of("turned_block.toml", "turned_block_felt.toml");
  const int tip = object_named(player.world(), "tip");
  play_to_the_end(player);
  EXPECT_GT(player.world().pose(tip).position[2] + 0.5 * mm, 40 * mm - 0.87 * mm); // half a cell's diagonal
  EXPECT_LT(player.world().pose(tip).position[2], 41.5 * mm);                      // it did come down
}

// The stamp's lower face ends 2 mm under where the fat's surface was.
TEST(ContactScenesContract, InAFineWorldAThinStampDentsFatInPlaceOfSinkingIn) {
  Player player = player_of("fine.toml", "fine_pressed.toml");
  const int fat = object_named(player.world(), "fat");
  const auto frames = play_to_the_end(player);
  EXPECT_FALSE(frames.back().contacts.empty());
  EXPECT_GT(frames.back().drives[0].force.norm(), 0);
  EXPECT_GT(lowest_of_grid(player.world(), fat), 1.2 * mm); // under the stamp, between nodes more
}

TEST(ContactScenesContract, EightDiscsOfDifferentStiffnessAreInBalance) {
  Player player = player_of("eight.toml", "eight_pressed.toml");
  double softest = 0, hardest = 0;
  while (!player.is_at_end()) {
    const PlayedFrame frame = player.next();
    if (frame.number % 9 == 0) {
      ASSERT_EQ(player.world().n_penetrations(), 0) << "in frame " << frame.number;
    }
    ASSERT_EQ(frame.status, Status::done) << frame.message << ", frame " << frame.number;
  }
  const auto stretch =
      [&](int disc) { // of the disc's range of displacement along x, turns aside: of its links
        const deform::World& world = player.world();
        const Specimen& body = world.scene().objects[static_cast<std::size_t>(disc)].scene.specimen;
        double most = 0;
        for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
          const Index3 at = body.grid.node_at(node);
          const Index3 beside{at[0] + 1, at[1], 0};
          if (at[0] < body.grid.cells()[0] && body.is_node(at) && body.is_node(beside))
            most = std::max(
                most,
                std::abs((world.position(disc, body.grid.node(beside)) - world.position(disc, node)).norm() /
                             mm -
                         1));
        }
        return most;
      };
  softest = stretch(object_named(player.world(), "disc1"));
  hardest = stretch(object_named(player.world(), "disc6"));
  EXPECT_GT(softest, 2 * hardest); // 2 kPa and 64 kPa in a row
}

// Independent: each segment of the strip's outline against each that is far from it along the strip.
TEST(ContactScenesIndependent, AStripComesToLieOnItselfAndNotInItself) {
  Player player = player_of("strip.toml", "strip_folded.toml");
  const Grid& grid = player.world().scene().objects[0].scene.specimen.grid;
  const int nx = grid.nodes()[0], ny = grid.nodes()[1];
  std::vector<std::pair<std::int64_t, std::int64_t>> outline;
  for (int x = 0; x + 1 < nx; ++x)
    for (const int y : {0, ny - 1})
      outline.emplace_back(grid.node({x, y, 0}), grid.node({x + 1, y, 0}));
  const auto side = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
    return (q - p).cross(r - p)[2];
  };
  bool has_met = false;
  while (!player.is_at_end()) {
    const PlayedFrame frame = player.next();
    ASSERT_TRUE(has_displacement(frame.status)) << frame.message;
    for (const auto& contact : frame.contacts)
      has_met = has_met || contact.object == contact.other;
    std::vector<std::array<Eigen::Vector3d, 2>> at;
    for (const auto& [a, b] : outline)
      at.push_back({player.world().position(0, a), player.world().position(0, b)});
    for (std::size_t i = 0; i < at.size(); ++i)
      for (std::size_t j = i + 12; j < at.size(); ++j) // two sides, six cells along
        ASSERT_FALSE(side(at[i][0], at[i][1], at[j][0]) * side(at[i][0], at[i][1], at[j][1]) < 0 &&
                     side(at[j][0], at[j][1], at[i][0]) * side(at[j][0], at[j][1], at[i][1]) < 0)
            << "frame " << frame.number << ", segments " << i << " and " << j;
  }
  EXPECT_TRUE(has_met);
}

TEST(ContactScenesContract, ACClosedByAHandGivesWayToItself) {
  Player player = player_of("c.toml", "c_closed.toml");
  const auto frames = play_to_the_end(player);
  EXPECT_TRUE(std::ranges::any_of(frames.back().contacts,
                                  [](const auto& contact) { return contact.object == contact.other; }));
}

// Contract: the ball comes down, dents the fat by more than its weight at rest would, and is thrown back.
TEST(ContactScenesContract, ABallThatIsDroppedOnFatIsThrownBack) {
  Player player = player_of("ball_on_fat.toml", "ball_on_fat_dropped.toml");
  const int ball = object_named(player.world(), "ball");
  double fastest_down = 0, fastest_up = 0;
  bool has_met = false;
  while (!player.is_at_end()) {
    const PlayedFrame frame = player.next();
    ASSERT_EQ(frame.status, Status::done) << frame.message;
    ASSERT_EQ(player.world().n_penetrations(), 0) << "in frame " << frame.number;
    const double speed = player.world().motion(ball).velocity[1];
    has_met = has_met || !frame.contacts.empty();
    (has_met ? fastest_up : fastest_down) =
        has_met ? std::max(fastest_up, speed) : std::min(fastest_down, speed);
  }
  EXPECT_LT(fastest_down, -0.5); // [m/s]
  EXPECT_GT(fastest_up, 0.05);
}

// Two turns of 10 mm would lead it to 27 mm; it binds on the way where the hand tilts it.
TEST(ContactScenesContract, AnUnsteadyHandLeadsANutDownItsBoltUntilItBinds) {
  Player player = player_of("bolt.toml", "bolt_unsteady.toml");
  const int nut = object_named(player.world(), "nut");
  while (!player.is_at_end())
    player.next();
  EXPECT_EQ(player.world().n_penetrations(), 0); // looks at all of a turned nut: once
  const deform::Pose& pose = player.world().pose(nut);
  const Eigen::Vector3d middle = pose.position + pose.rotation * Eigen::Vector3d(12 * mm, 12 * mm, 5 * mm);
  EXPECT_LT(middle[2], 45 * mm); // it began at 52 mm, more than half a turn higher
  EXPECT_GT(middle[2], 30 * mm);
  // And is about its bolt: a millimetre of play, and stairs of half a face's diagonal on either side.
  const double room = (1 + std::sqrt(2.0)) * mm;
  EXPECT_NEAR(middle[0], 20 * mm, room);
  EXPECT_NEAR(middle[1], 20 * mm, room);
}

} // namespace
} // namespace maille::studies
