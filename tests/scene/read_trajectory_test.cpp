#include "maille/scene/world/trajectory.hpp"

#include "maille/materials/fault.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "support/mistake.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace maille {
namespace {

using test::expect_only;
using test::Mistake;
using test::with_mistake;

WorldScene world() {
  return parse_world_scene(R"([world]
cells = [20, 10, 10]
spacing = "1 mm"
[[object]]
name = "wall"
kind = "fixed"
shape = "box"
cells = [1, 1, 1]
[[object]]
name = "tool"
kind = "rigid"
shape = "box"
cells = [2, 2, 2]
position = ["3 mm", 0, 0]
[[object]]
name = "soft"
kind = "deformable"
shape = "box"
cells = [4, 3, 2]
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
position = ["10 mm", 0, 0]
)");
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

class TrajectoryMistakeContract : public testing::TestWithParam<Mistake> {};

TEST_P(TrajectoryMistakeContract, IsReportedWithItsLineAndKey) {
  expect_only(GetParam(), faults_of(with_mistake(good, GetParam()), "path.toml"));
}

INSTANTIATE_TEST_SUITE_P(
    OneAtATime, TrajectoryMistakeContract,
    testing::Values(
        Mistake{"no_time", "20 ms", "0 ms", 1, "frame_time", "> 0"},
        Mistake{"unknown_object", "\"tool\"", "\"tol\"", 3, "drive[1].object", "\"tool\""},
        Mistake{"fixed_object", "\"tool\"", "\"wall\"", 3, "drive[1].object", "fixed"},
        Mistake{"no_frames", "frames = 4", "frames = 0", 5, "drive[1].frames", "whole number"},
        Mistake{"nothing_asked", "by = [\"2 mm\", 0, 0]\n", "", 2, "drive[1]", "turn"},
        Mistake{"both_by_and_to", "to = [\"1 mm\", 0, 0]", "to = [\"1 mm\", 0, 0]\nby = [0, 0, 0]", 15,
                "drive[3].to", "either"},
        Mistake{"region_of_what_is_rigid", "slide = true", "where = \"x-\"", 6, "drive[1].where", "whole"},
        Mistake{"no_region", "where = \"x+\"\n", "", 7, "drive[2].where", "a face"},
        Mistake{"nodes_that_turn", "start = 3", "slide = true", 12, "drive[2].slide", "shifted"},
        Mistake{"turn_of_more_than_half", "90 deg", "200 deg", 16, "drive[3].turn", "half a turn"},
        Mistake{"unknown_key", "slide", "slid", 6, "drive[1].slid", "slide"}),
    [](const auto& each) { return std::string(each.param.name); });

TEST(ReadTrajectoryContract, EveryFaultOfATableIsFound) {
  const auto faults =
      faults_of("frame,object,dx [mm],slide\n0,tool,1,\n1,nobody,1,\n2,tool,far,\n3,tool,1,perhaps\n4,tool\n",
                "path.csv");
  ASSERT_EQ(faults.size(), 5u) << InputError(faults).what();
  EXPECT_EQ(faults[0].line, 2);
  EXPECT_EQ(faults[0].key, "frame");
  EXPECT_EQ(faults[1].key, "object");
  EXPECT_EQ(faults[2].key, "dx");
  EXPECT_EQ(faults[3].key, "slide");
  EXPECT_EQ(faults[4].line, 6);
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
    ASSERT_EQ(faults.size(), 1u) << header;
    EXPECT_EQ(faults[0].line, 1);
  }
}

TEST(ReadTrajectoryContract, FramesBeyondWhatIsKeptAreRefused) {
  for (const char* frame : {"3000000000", "9223372036854775807", "1000001"}) {
    const auto faults = faults_of("frame,object,dx [mm]\n" + std::string(frame) + ",tool,1\n", "path.csv");
    ASSERT_EQ(faults.size(), 1u) << frame;
    EXPECT_EQ(faults[0].key, "frame");
  }
  std::string drives;
  for (int i = 0; i < 3; ++i)
    drives += "[[drive]]\nobject = \"tool\"\nby = [\"2 mm\", 0, 0]\nframes = 400000\n";
  const auto faults = faults_of(drives, "path.toml");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0].key, "frames");
}

TEST(ReadTrajectoryContract, ColumnsAreCheckedFirst) {
  const auto faults = faults_of("frame,dx [kPa],speed\n1,2,3\n", "path.csv");
  ASSERT_EQ(faults.size(), 3u) << InputError(faults).what();
  for (const Fault& fault : faults)
    EXPECT_EQ(fault.line, 1) << to_string(fault);
}

} // namespace
} // namespace maille
