/// What a hand writes down, and what is read of it.

#include "maille/materials/fault.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace maille {
namespace {

WorldScene some_world() {
  return parse_world_scene(
      "[world]\ncells = [30, 30, 30]\nspacing = \"1 mm\"\n"
      "[[object]]\nname = \"a \\\"soft\\\", body\"\nkind = \"deformable\"\nshape = \"box\"\n"
      "cells = [4, 4, 4]\nposition = [\"2.5 mm\", \"2.5 mm\", \"2.5 mm\"]\n"
      "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
      "[[object]]\nname = \"tool\"\nkind = \"rigid\"\nshape = \"box\"\ncells = [2, 2, 2]\n"
      "position = [\"20 mm\", \"20 mm\", \"20 mm\"]\n",
      "world.toml");
}

// Random spans, numbers of all sizes: what is read is what was written, to the bit.
TEST(TrajectoryRowsContract, SpansAreReadBackToTheBit) {
  const WorldScene world = some_world();
  std::mt19937_64 random(4);
  std::normal_distribution<double> number;
  const auto any = [&] { return number(random) * std::pow(10, static_cast<double>(random() % 9) - 6); };
  std::string text = trajectory_header();
  std::vector<DriveSpan> written;
  for (std::int64_t frame = 1; frame <= 200; ++frame) {
    DriveSpan span;
    span.first_frame = frame;
    span.object = random() % 2;
    if (random() % 5 == 0) {
      span.release = true;
    } else if (span.object == 0) {
      std::vector<std::int64_t> nodes;
      for (std::int64_t node = 0; node < 124; ++node)
        if (random() % 3 == 0)
          nodes.push_back(node);
      nodes.push_back(124);
      if (random() % 2 == 0)
        std::ranges::reverse(nodes);
      span.nodes = nodes;
      span.by = {any(), any(), any()};
    } else {
      span.to = Vec3{any(), any(), any()};
      span.angle = 0.1 * number(random);
      span.slide = random() % 2 == 0;
    }
    written.push_back(span);
    text += trajectory_row(span, world);
  }
  text += trajectory_row(std::int64_t{207});
  const Trajectory read = parse_trajectory(text, "hand.csv", world);
  ASSERT_EQ(read.spans.size(), written.size());
  EXPECT_EQ(read.n_frames, 207);
  for (std::size_t i = 0; i < written.size(); ++i) {
    EXPECT_EQ(read.spans[i].object, written[i].object);
    EXPECT_EQ(read.spans[i].nodes, written[i].nodes);
    EXPECT_EQ(read.spans[i].release, written[i].release);
    EXPECT_EQ(read.spans[i].by, written[i].by);
    EXPECT_EQ(read.spans[i].to, written[i].to);
    EXPECT_EQ(read.spans[i].angle, written[i].angle);
    EXPECT_EQ(read.spans[i].slide, written[i].slide);
  }
}

TEST(TrajectoryRowsContract, FaultsOfTheNewColumnsAreAllFound) {
  try {
    parse_trajectory("frame,object,nodes,dx [mm],release,set,value\n"
                     "1,\"a \"\"soft\"\", body\",3 3,1,,,\n" // twice
                     "1,\"a \"\"soft\"\", body\",5-2,1,,,\n" // backwards
                     "1,\"a \"\"soft\"\", body\",125,1,,,\n" // none
                     "1,tool,4,1,,,\n"                       // rigid
                     "1,tool,,1,true,,\n"                    // moved and released
                     "0,,,,,method,guess\n"
                     "0,tool,,,,stiffness,2\n" // rigid
                     "3,,,,,method,limits\n"   // not of all frames
                     "0,,,,,colour,red\n",
                     "hand.csv", some_world());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(error.faults().size(), 9u) << error.what();
    for (std::size_t i = 0; i < error.faults().size(); ++i)
      EXPECT_EQ(error.faults()[i].line, static_cast<int>(i) + 2);
  }
}

TEST(TrajectoryRowsContract, SettingsChangeTheWorldTheyAreFor) {
  WorldScene world = some_world();
  const std::vector<WorldSetting> settings{{std::nullopt, "method", "limits"},
                                           {0, "stiffness", "3"},
                                           {0, "limits", "1.5 0.5 0.2"},
                                           {std::nullopt, "tool", "0.003 0.015 0.01 0.01"}};
  // A world that has a `tool` already has no place for another of that name.
  EXPECT_THROW(apply_settings(settings, world), InputError);
  world = some_world();
  world.objects.pop_back();
  const double before = world.objects[0].scene.materials[0].elasticity.G12;
  std::string text = trajectory_header();
  for (const WorldSetting& setting : settings)
    text += trajectory_row(setting, world);
  text += "1,tool,,,,,0.015,0.01,0.009,,,,,true,,,\n"; // the tool is driven by name
  const Trajectory read = parse_trajectory(text, "hand.csv", world);
  EXPECT_EQ(read.settings, settings);
  apply_settings(read.settings, world);
  EXPECT_EQ(world.method, "limits");
  EXPECT_DOUBLE_EQ(world.objects[0].scene.materials[0].elasticity.G12, 3 * before);
  EXPECT_EQ(world.objects[0].scene.limits.from, LimitSource::given);
  EXPECT_EQ(world.objects[0].scene.limits.given.stretch[1], 1.5);
  ASSERT_EQ(world.objects.size(), 2u);
  EXPECT_EQ(world.objects[1].kind, ObjectKind::rigid);
  EXPECT_EQ(world.objects[1].scene.specimen.grid.cells(), (Index3{6, 6, 6}));
  EXPECT_EQ(read.spans.at(0).object, 1u);
}

TEST(TrajectoryRowsContract, ABodysWorldSaysWhatItLeavesOut) {
  const Scene scene =
      parse_scene("[specimen]\nshape = \"box\"\ncells = [4, 4, 4]\nspacing = \"1 mm\"\n"
                  "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n"
                  "[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n"
                  "[[load]]\ngravity = [0, 0, -9.81]\n",
                  "body.toml");
  std::vector<std::string> left_out;
  const WorldScene world = world_of_body(scene, "coupled", left_out);
  EXPECT_EQ(left_out.size(), 2u);
  EXPECT_TRUE(world.is_open);
  EXPECT_FALSE(world.objects[0].scene.has_loads());
  EXPECT_EQ(world.objects[0].scene.prescribed.size(), 75u); // the hold alone
}

} // namespace
} // namespace maille
