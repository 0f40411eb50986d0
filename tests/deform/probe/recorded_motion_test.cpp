#include "maille/deform/probe/device.hpp"
#include "maille/deform/probe/probe.hpp"
#include "maille/deform/probe/servo_loop.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>
#include <thread>

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
  const auto faults = test::faults_found_by([] {
    parse_recorded_motion("time,x,y,z\n0,1,2,3\n0,1,2\n-1,0,0,0\n1,nan,0,0\n2,0,0,0,5\n3,0,0,0\n",
                          "hand.csv");
  });
  ASSERT_EQ(faults.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(faults[std::size_t(i)].line, 3 + i);
    EXPECT_EQ(faults[std::size_t(i)].file, "hand.csv");
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
  // Columns are found by their names; a turn is given whole or not at all.
  EXPECT_EQ(parse_recorded_motion("z,y [cm],time,x\n3,200,0,1,\n").at(0).position, Eigen::Vector3d(1, 2, 3));
  for (const char* text : {"time,x,y,z,turn_x\n0,0,0,0,0\n", "time,x,y,z,x\n0,0,0,0,0\n"})
    EXPECT_THROW(parse_recorded_motion(text), InputError) << text;
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

TEST(TripleBufferContract, TheReaderGetsTheNewestAndNothingTwice) {
  TripleBuffer<int> buffer(7);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.front(), 7);
  buffer.publish(1);
  buffer.publish(2);
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.front(), 2);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.front(), 2);
  buffer.publish(3);
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.front(), 3);
}

// Contract: what is read is whole, and never older than what was read before, while the other thread writes.
TEST(TripleBufferContract, NothingIsTornBetweenTwoThreads) {
  struct Value {
    std::int64_t numbers[32] = {};
  };
  TripleBuffer<Value> buffer;
  constexpr std::int64_t last = 200'000;
  std::thread writer([&] {
    for (std::int64_t i = 1; i <= last; ++i) {
      for (auto& number : buffer.back().numbers)
        number = i;
      buffer.publish();
    }
  });
  std::int64_t seen = 0, torn = 0, backwards = 0;
  while (seen < last) {
    buffer.update();
    const Value& value = buffer.front();
    for (const std::int64_t number : value.numbers)
      torn += number != value.numbers[0];
    backwards += value.numbers[0] < seen;
    seen = value.numbers[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0);
  EXPECT_EQ(backwards, 0);
}

// Oracle: all durations, sorted.
TEST(LatencyHistogramOracle, QuantilesAreThoseOfTheSortedList) {
  std::mt19937_64 random(3);
  LatencyHistogram histogram;
  std::vector<std::int64_t> all;
  std::lognormal_distribution<double> some(10, 3); // tens of microseconds, with a long tail
  for (int i = 0; i < 20'000; ++i) {
    all.push_back(std::int64_t(some(random)));
    histogram.add(all.back());
  }
  std::ranges::sort(all);
  EXPECT_EQ(histogram.n(), 20'000);
  EXPECT_EQ(histogram.largest(), all.back());
  for (const double share : {0.001, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const std::int64_t exact = all[std::size_t(std::max(share * 20'000 - 1, 0.0))];
    EXPECT_GE(histogram.quantile(share), exact) << share;
    EXPECT_LE(double(histogram.quantile(share)), double(exact) * (1 + 1.0 / 32)) << share;
  }
  std::int64_t sum = 0, end = -1;
  for (const auto& bin : histogram.bins()) {
    EXPECT_GT(bin.from, end); // bins follow one another and do not overlap
    end = bin.to;
    sum += bin.count;
    const auto inside =
        std::ranges::count_if(all, [&](std::int64_t t) { return t >= bin.from && t <= bin.to; });
    EXPECT_EQ(inside, bin.count);
  }
  EXPECT_EQ(sum, 20'000);
}

TEST(LatencyHistogramAnalytic, ShortDurationsAreKeptExactly) {
  LatencyHistogram histogram;
  for (int t = 0; t < 40; ++t)
    histogram.add(t);
  EXPECT_EQ(histogram.n(), 40);
  EXPECT_DOUBLE_EQ(histogram.mean(), 19.5); // analytic: the mean of 0 ... 39
  EXPECT_EQ(histogram.quantile(0.5), 19);
  EXPECT_EQ(histogram.quantile(1), 39);
  EXPECT_EQ(LatencyHistogram().quantile(0.5), 0);
}

} // namespace
} // namespace maille::deform
