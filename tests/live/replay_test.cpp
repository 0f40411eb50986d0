/// What the hand did, played by `maille play`'s own player.

#include "live/by_hand.hpp"
#include "play/play.hpp"
#include "support/kit.hpp"

namespace maille::live {
namespace {
using test::dragged;
using test::mm;
using test::world_folder;

TEST(LiveReplayContract, ARecordedSessionIsPlayedToTheSameBits) {
  const WorldScene scene = read_world_scene(world_folder / "bolt.toml");
  Session session(scene, {});
  double time = 0;
  for (const int object : {1, 2}) {
    session.grip({object, {}}, ++time);
    deform::Pose goal = session.goal();
    for (int i = 0; i < 12; ++i) {
      goal.position += Eigen::Vector3d(0.37, -0.11, -2.3) * mm;
      const double c = std::cos(0.05 * i), s = std::sin(0.05 * i);
      goal.rotation << c, -s, 0, s, c, 0, 0, 0, 1;
      session.reach(goal, ++time);
      ASSERT_TRUE(session.wait_idle(30));
    }
    session.let_go(false, ++time);
  }
  session.undo();
  session.redo();
  ASSERT_TRUE(session.wait_idle(30));
  const std::string text = session.text();
  studies::Player player(deform::World(scene), parse_trajectory(text, "hand.csv", scene));
  while (!player.is_at_end())
    player.next();
  const auto state = session.state();
  deform::TrajectoryDrives drives{deform::World(scene)};
  ASSERT_GT(player.trajectory().n_frames, 20);
  for (std::size_t object = 0; object < scene.objects.size(); ++object) {
    const deform::Pose pose = drives.frame_now(player.world(), object);
    EXPECT_EQ(pose.position, state->frames[object].position) << scene.objects[object].name;
    EXPECT_EQ(pose.rotation, state->frames[object].rotation) << scene.objects[object].name;
  }
}

TEST(LiveReplayContract, SoDoBodies) {
  for (const char* method : {"limits", "relaxed", "coupled"}) {
    const WorldScene scene = test::block_world(method);
    SessionSettings settings;
    settings.frame_budget = 0; // without one frames know nothing of the clock
    Session session(scene, settings);
    const std::int64_t node = test::top_middle(scene);
    session.grip({0, {node, node + 1, node + 9}}, 1);
    deform::Pose goal = session.goal();
    for (int i = 0; i < 6; ++i) {
      goal.position += Eigen::Vector3d(0.21, 0.13, 0.17) * mm;
      session.reach(goal, 2 + i);
      ASSERT_TRUE(session.wait_idle(30));
    }
    session.let_go(true, 9);
    session.change({0, "stiffness", "1.7"});
    ASSERT_TRUE(session.wait_idle(30));
    WorldScene changed = scene;
    const Trajectory trajectory = parse_trajectory(session.text(), "hand.csv", scene);
    apply_settings(trajectory.settings, changed);
    studies::Player player(deform::World(changed), trajectory);
    while (!player.is_at_end())
      player.next();
    EXPECT_EQ(player.world().displacement(0), *session.state()->displacements[0]) << method;
  }
}

} // namespace
} // namespace maille::live
