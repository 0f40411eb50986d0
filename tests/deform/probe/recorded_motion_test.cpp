#include "maille/deform/probe/device.hpp"

#include "maille/materials/fault.hpp"
#include "support/mistake.hpp"
#include "support/temporary_folder.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace maille::deform {
namespace {

TEST(RecordedMotionAnalytic, PlacesAndTurnsLieEvenlyBetweenSamples) {
  const RecordedMotion motion =
      parse_recorded_motion("# a hand\n"
                            "time, x, y, z, turn_x, turn_y, turn_z\n"
                            "0.5, 0, 0, 0, 0, 0, 0\n"
                            "\n"
                            "1.5, 0.1, -0.2, 0.3, 0, 0, 1.5707963267948966  # a quarter\n");
  EXPECT_EQ(motion.duration(), 1.5);
  EXPECT_EQ(motion.at(0).position, Eigen::Vector3d::Zero());
  // Analytic: a quarter of the way, and of the quarter turn.
  const Pose pose = motion.at(0.75);
  EXPECT_LT((pose.position - Eigen::Vector3d(0.025, -0.05, 0.075)).norm(), 1e-15);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(std::numbers::pi / 8, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_LT((pose.rotation - turn).norm(), 1e-14);
  EXPECT_EQ(motion.at(9).position, motion.samples().back().pose.position);
}

TEST(RecordedMotionContract, EveryFaultIsReportedWithItsLine) {
  try {
    parse_recorded_motion("time,x,y,z\n0,1,2,3\n0,1,2\n-1,0,0,0\n1,nan,0,0\n2,0,0,0,5\n3,0,0,0\n",
                          "hand.csv");
    FAIL() << "no fault";
  } catch (const InputError& error) {
    ASSERT_EQ(error.faults().size(), 4u) << error.what();
    const int lines[] = {3, 4, 5, 6};
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_EQ(error.faults()[i].line, lines[i]);
      EXPECT_EQ(error.faults()[i].file, "hand.csv");
    }
  }
  for (const char* text : {"", "time,x,y,z\n", "t,x,y\n0,0,0\n"})
    EXPECT_THROW(parse_recorded_motion(text), InputError) << text;
  EXPECT_THROW(read_recorded_motion("/nowhere/at/all.csv"), InputError);
}

// Analytic: what the units say; the byte order mark of a spreadsheet is no column.
TEST(RecordedMotionAnalytic, UnitsStandInTheHeader) {
  const RecordedMotion motion =
      parse_recorded_motion("\xEF\xBB\xBFtime [ms],x [mm],y [cm],z,turn_x [deg],turn_y,turn_z\n"
                            "0,17,1,0.25,180,0,0\n500,17,1,0.25,180,0,0\n");
  EXPECT_EQ(motion.duration(), 0.5);
  EXPECT_EQ(motion.at(0).position, Eigen::Vector3d(0.017, 0.01, 0.25));
  EXPECT_NEAR(motion.at(0).rotation(1, 1), -1, 1e-15);
  for (const char* text :
       {"time,x [kPa],y,z\n0,0,0,0\n", "time,x [3 mm],y,z\n0,0,0,0\n", "time,x [mm,y,z\n0,0,0,0\n",
        "time,x,y,z\n0,1e300,0,0\n", "time,x,y,z\n1e15,0,0,0\n"})
    EXPECT_THROW(parse_recorded_motion(text), InputError) << text;
}

/// The fault that reading the file meets before its lines are looked at.
Fault fault_of(const std::filesystem::path& file) {
  return test::only_fault_of([&] { read_recorded_motion(file); });
}

TEST(RecordedMotionContract, AFileWithoutEndIsRefused) {
  const Fault fault = fault_of("/dev/zero");
  EXPECT_EQ(fault.file, "/dev/zero");
  EXPECT_EQ(fault.expected, "a recorded motion of at most 268435456 bytes");
  EXPECT_EQ(fault.found, "more");
}

TEST(RecordedMotionContract, AFileOfAByteTooManyIsRefused) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("hand.csv", "time,x,y,z\n0,1,2,3\n");
  EXPECT_EQ(read_recorded_motion(file).samples().size(), 1u);
  std::filesystem::resize_file(file, 268435457);
  EXPECT_EQ(fault_of(file).found, "more");
}

TEST(RecordedMotionContract, AFolderIsNoMotion) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(fault_of(folder.path()).expected, "a recorded motion that can be read");
}

} // namespace
} // namespace maille::deform
