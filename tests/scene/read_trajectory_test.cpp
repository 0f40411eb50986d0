#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "support/kit.hpp"

namespace maille {
namespace {

using test::Mistake;
using test::says_only;

WorldScene world() {
  return parse_world_scene(
      test::world_text("[20, 10, 10]") + test::object_text("wall", "fixed", "[1, 1, 1]") +
      test::object_text("tool", "rigid", "[2, 2, 2]", "position = [\"3 mm\", 0, 0]\n") +
      test::object_text("soft", "deformable", "[4, 3, 2]",
                        "position = [\"10 mm\", 0, 0]\nmaterial = " + test::soft + "\n"));
}

std::vector<Fault> faults_of(const std::string& text, const char* file) {
  return test::faults_found_by([&] { parse_trajectory(text, file, world()); });
}

const std::string good = R"(frame_time = "20 ms"
[[drive]]
object = "tool"
by = ["2 mm", 0, 0]
frames = 4
slide = true
[[drive]]
object = "soft"
where = "x+"
by = [0, 0, "-1 mm"]
frames = 2
start = 3
[[drive]]
object = "tool"
to = ["1 mm", 0, 0]
turn = { angle = "90 deg", axis = [0, 0, 2], about = [0, 0, 0] }
[[drive]]
object = "soft"
release = true
)";

TEST(ReadTrajectoryContract, DrivesFollowOneAnotherUnlessTheySayWhenTheyStart) {
  const Trajectory trajectory = parse_trajectory(good, "a/path.toml", world());
  EXPECT_EQ(trajectory.name, "path");
  EXPECT_EQ(trajectory.frame_seconds, 0.02);
  EXPECT_EQ(trajectory.n_frames, 6);
  ASSERT_EQ(trajectory.spans.size(), 4u);
  const auto& spans = trajectory.spans;
  EXPECT_EQ(spans[0].object, 1u);
  EXPECT_EQ(spans[0].first_frame, 1);
  EXPECT_EQ(spans[0].n_frames, 4);
  EXPECT_EQ(spans[0].by, (Vec3{0.002, 0, 0}));
  EXPECT_TRUE(spans[0].slide);
  EXPECT_FALSE(spans[0].to);
  EXPECT_EQ(spans[1].object, 2u);
  EXPECT_EQ(spans[1].first_frame, 3);
  EXPECT_EQ(std::vector<std::int64_t>(spans[1].nodes).size(), 12u); // of the face of 3 x 2 cells
  EXPECT_EQ(spans[2].first_frame, 5);
  EXPECT_EQ(*spans[2].to, (Vec3{0.001, 0, 0}));
  EXPECT_NEAR(spans[2].angle, std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(spans[2].axis, (Vec3{0, 0, 1}));
  EXPECT_EQ(*spans[2].about, (Vec3{0, 0, 0}));
  EXPECT_TRUE(spans[3].release);
}

TEST(ReadTrajectoryContract, AHandMayLeadAnObjectByASpring) {
  const auto text = [](const std::string& keys) {
    return "[[drive]]\nobject = \"tool\"\nby = [\"1 mm\", 0, 0]\n" + keys;
  };
  const auto span = [&](const std::string& keys) {
    return parse_trajectory(text(keys), "path.toml", world()).spans[0];
  };
  EXPECT_FALSE(span("").follow);
  EXPECT_FALSE(span("follow = false\n").follow);
  EXPECT_EQ(span("follow = true\n").follow, 300);
  EXPECT_EQ(span("follow = true\nstiffness = 50\n").follow, 50);
  for (const char* wrong : {"follow = 1\n", "stiffness = 50\n", "follow = true\nstiffness = 0\n",
                            "follow = true\nslide = true\n"})
    EXPECT_EQ(faults_of(text(wrong), "path.toml").size(), 1u) << wrong;
  EXPECT_EQ(
      faults_of("[[drive]]\nobject = \"soft\"\nwhere = \"x+\"\nby = [0, 0, 0]\nfollow = true\n", "path.toml")
          .size(),
      1u);
}

TEST(ReadTrajectoryContract, RowsSayTheSameAsTables) {
  const Trajectory rows =
      parse_trajectory("# recorded\nframe,object,dx [mm],angle [deg],axis_z,slide,where,dz\n"
                       "2,tool,1,90,1,true,,\n1,soft,,,,,x+,-0.001\n",
                       "path.csv", world());
  EXPECT_EQ(rows.n_frames, 2);
  ASSERT_EQ(rows.spans.size(), 2u);
  EXPECT_EQ(rows.spans[0].first_frame, 1); // by frames, not by rows
  EXPECT_EQ(std::vector<std::int64_t>(rows.spans[0].nodes).size(), 12u);
  EXPECT_EQ(rows.spans[0].by, (Vec3{0, 0, -0.001}));
  EXPECT_EQ(rows.spans[1].by, (Vec3{0.001, 0, 0}));
  EXPECT_NEAR(rows.spans[1].angle, std::numbers::pi / 2, 1e-15);
  EXPECT_TRUE(rows.spans[1].slide);
}

const Mistake mistakes[] = {
    {"no_time", "20 ms", "0 ms", 1, "frame_time", "> 0"},
    {"unknown_object", "\"tool\"", "\"tol\"", 3, "drive[1].object", "\"tool\""},
    {"fixed_object", "\"tool\"", "\"wall\"", 3, "drive[1].object", "fixed"},
    {"no_frames", "frames = 4", "frames = 0", 5, "drive[1].frames", "whole number"},
    {"nothing_asked", "by = [\"2 mm\", 0, 0]\n", "", 2, "drive[1]", "turn"},
    {"both_by_and_to", "to = [\"1 mm\", 0, 0]", "to = [\"1 mm\", 0, 0]\nby = [0, 0, 0]", 15, "drive[3].to",
     "either"},
    {"region_of_what_is_rigid", "slide = true", "where = \"x-\"", 6, "drive[1].where", "whole"},
    {"no_region", "where = \"x+\"\n", "", 7, "drive[2].where", "a face"},
    {"nodes_that_turn", "start = 3", "slide = true", 12, "drive[2].slide", "shifted"},
    {"turn_of_more_than_half", "90 deg", "200 deg", 16, "drive[3].turn", "half a turn"},
    {"unknown_key", "slide", "slid", 6, "drive[1].slid", "slide"},
};

TEST(TrajectoryMistakeContract, IsReportedWithItsLineAndKey) {
  for (const Mistake& mistake : mistakes) {
    SCOPED_TRACE(mistake.name);
    test::expect_only(mistake, faults_of(with_mistake(good, mistake), "path.toml"));
  }
}

TEST(ReadTrajectoryContract, EveryFaultOfATableIsFound) {
  const auto faults =
      faults_of("frame,object,dx [mm],slide\n0,tool,1,\n1,nobody,1,\n2,tool,far,\n3,tool,1,perhaps\n4,tool\n",
                "path.csv");
  ASSERT_EQ(faults.size(), 5u) << InputError(faults).what();
  const std::array<const char*, 4> keys{"frame", "object", "dx", "slide"};
  for (int i = 0; i < 5; ++i)
    EXPECT_TRUE(
        test::says(faults[std::size_t(i)], {.line = 2 + i, .key = i < 4 ? keys[std::size_t(i)] : ""}));
}

// Analytic: "[1]" says that there is no unit, and no unit is glued to digits.
TEST(ReadTrajectoryAnalytic, UnitsOfColumnsStandAlone) {
  const Trajectory rows =
      parse_trajectory("\xEF\xBB\xBF"
                       "frame,object,angle [deg],axis_x [1],axis_y [1],axis_z [1]\n1,tool,90,0,0,1\n",
                       "path.csv", world());
  EXPECT_EQ(rows.spans[0].axis, (Vec3{0, 0, 1}));
  for (const char* header : {"dx [1]", "dx [3 mm]", "dx []", "slide [1]"}) {
    const auto faults = faults_of("frame,object," + std::string(header) + "\n1,tool,1\n", "path.csv");
    EXPECT_TRUE(says_only(faults, {.line = 1})) << header;
  }
}

TEST(ReadTrajectoryContract, FramesBeyondWhatIsKeptAreRefused) {
  for (const char* frame : {"3000000000", "9223372036854775807", "1000001"}) {
    const auto faults = faults_of("frame,object,dx [mm]\n" + std::string(frame) + ",tool,1\n", "path.csv");
    EXPECT_TRUE(says_only(faults, {.key = "frame"})) << frame;
  }
  std::string drives;
  for (int i = 0; i < 3; ++i)
    drives += "[[drive]]\nobject = \"tool\"\nby = [\"2 mm\", 0, 0]\nframes = 400000\n";
  EXPECT_TRUE(says_only(faults_of(drives, "path.toml"), {.key = "frames"}));
}

TEST(ReadTrajectoryContract, ColumnsAreCheckedFirst) {
  const auto faults = faults_of("frame,dx [kPa],speed\n1,2,3\n", "path.csv");
  ASSERT_EQ(faults.size(), 3u) << InputError(faults).what();
  for (const Fault& fault : faults)
    EXPECT_EQ(fault.line, 1) << to_string(fault);
}

/// What a hand writes down, and what is read of it.

WorldScene some_world() {
  const std::string position = "position = [\"2.5 mm\", \"2.5 mm\", \"2.5 mm\"]\nmaterial = ";
  return parse_world_scene(
      test::world_text("[30, 30, 30]") +
      test::object_text("a \\\"soft\\\", body", "deformable", "[4, 4, 4]", position + test::soft + "\n") +
      test::object_text("tool", "rigid", "[2, 2, 2]", "position = [\"20 mm\", \"20 mm\", \"20 mm\"]\n"));
}

// Random spans, numbers of all sizes: what is read is what was written, to the bit.
TEST(TrajectoryRowsContract, SpansAreReadBackToTheBit) {
  WorldScene world = some_world();
  world.objects[1].name = "=tool, \"drawn\"";
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
  EXPECT_TRUE(test::has(text, ",\"'=tool")) << "a formula of spreadsheets";
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
  const std::string text = "frame,object,nodes,dx [mm],release,set,value\n"
                           "1,\"a \"\"soft\"\", body\",3 3,1,,,\n" // twice
                           "1,\"a \"\"soft\"\", body\",5-2,1,,,\n" // backwards
                           "1,\"a \"\"soft\"\", body\",125,1,,,\n" // none
                           "1,tool,4,1,,,\n"                       // rigid
                           "1,tool,,1,true,,\n"                    // moved and released
                           "0,,,,,method,guess\n"
                           "0,tool,,,,stiffness,2\n" // rigid
                           "3,,,,,method,limits\n"   // not of all frames
                           "0,,,,,colour,red\n";
  const auto faults = test::faults_found_by([&] { parse_trajectory(text, "hand.csv", some_world()); });
  ASSERT_EQ(faults.size(), 9u);
  for (std::size_t i = 0; i < faults.size(); ++i)
    EXPECT_EQ(faults[i].line, static_cast<int>(i) + 2);
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
  const Scene scene = parse_scene(test::pulled_box_text("[4, 4, 4]", "[\"1 mm\", 0, 0]") +
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
