#include "maille/deform/probe/device.hpp"

#include "maille/materials/csv_table.hpp"
#include "maille/materials/text_file.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

namespace maille::deform {

namespace {

constexpr double furthest = 1e6;                               ///< largest coordinate [m] and rotation [rad]
constexpr double longest = 1e9;                                ///< largest time [s]
constexpr std::int64_t largest_motion = std::int64_t{1} << 28; // bytes: half an hour of poses at 1 kHz

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0)
    return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

const std::vector<CsvColumn> columns{{"time", Dimension::time},
                                     {"x", Dimension::length},
                                     {"y", Dimension::length},
                                     {"z", Dimension::length},
                                     {"turn_x", Dimension::angle, false},
                                     {"turn_y", Dimension::angle, false},
                                     {"turn_z", Dimension::angle, false}};

/// @param before time of the last sample; nothing: this is the first
/// @return nothing, and a fault, where a number is missing or out of range
std::optional<RecordedMotion::Sample> read_sample(CsvTable& row, std::optional<double> before) {
  std::array<double, 7> values{};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::string_view name = columns[i].name;
    const auto value = row.number(name);
    if (!value && row.has(name))
      return std::nullopt;
    values[i] = value.value_or(0);
    if (const double most = i == 0 ? longest : furthest; !(std::abs(values[i]) <= most)) {
      row.fault(name,
                fmt::format("at most {:g} {}", most,
                            i == 0  ? "s"
                            : i < 4 ? "m"
                                    : "rad"),
                fmt::format("{:g}", values[i]));
      return std::nullopt;
    }
  }
  if (before ? !(values[0] > *before) : values[0] < 0) {
    row.fault("time", before ? fmt::format("a time after {} s", *before) : "a time from 0 s on",
              fmt::format("{} s", values[0]));
    return std::nullopt;
  }
  return RecordedMotion::Sample{
      values[0], Pose{rotation_of({values[4], values[5], values[6]}), {values[1], values[2], values[3]}}};
}

} // namespace

RecordedMotion::RecordedMotion(std::vector<Sample> samples) : samples_(std::move(samples)) {
  if (samples_.empty())
    throw std::invalid_argument("RecordedMotion: at least one sample");
  for (std::size_t i = 1; i < samples_.size(); ++i)
    if (!(samples_[i].time > samples_[i - 1].time))
      throw std::invalid_argument("RecordedMotion: times that rise");
}

Pose RecordedMotion::at(double time) const {
  const auto after =
      std::ranges::upper_bound(samples_, time, {}, [](const Sample& sample) { return sample.time; });
  if (after == samples_.begin())
    return samples_.front().pose;
  if (after == samples_.end())
    return samples_.back().pose;
  const Sample &from = *(after - 1), &to = *after;
  const double t = (time - from.time) / (to.time - from.time);
  Pose pose = from.pose;
  pose.position += t * (to.pose.position - from.pose.position);
  if (from.pose.rotation != to.pose.rotation)
    pose.rotation = Eigen::Quaterniond(from.pose.rotation)
                        .slerp(t, Eigen::Quaterniond(to.pose.rotation))
                        .normalized()
                        .toRotationMatrix();
  return pose;
}

RecordedMotion parse_recorded_motion(std::string_view text, const std::string& file) {
  FaultList faults(file);
  CsvTable row(text, CsvComments::anywhere, columns, faults);
  if (row.has("turn_x") != row.has("turn_y") || row.has("turn_x") != row.has("turn_z"))
    faults.add(row.line_of_header(), "turn_x", "turn_x, turn_y and turn_z, or none of them", "some of them");
  std::vector<RecordedMotion::Sample> samples;
  while (row.next())
    if (const auto sample =
            read_sample(row, samples.empty() ? std::nullopt : std::optional(samples.back().time)))
      samples.push_back(*sample);
  if (samples.empty() && faults.empty())
    faults.add(0, "", "at least one line of numbers under the names of the columns", "none");
  faults.throw_if_any();
  return RecordedMotion(std::move(samples));
}

RecordedMotion read_recorded_motion(const std::filesystem::path& file) {
  return parse_recorded_motion(read_text_file(file, "a recorded motion", largest_motion), file.string());
}

} // namespace maille::deform
