#include "maille/deform/probe/device.hpp"

#include "maille/base/csv.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/materials/text_file.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace maille::deform {

namespace {

constexpr std::string_view header = "time,x,y,z", header_with_turns = "time,x,y,z,turn_x,turn_y,turn_z";
constexpr double furthest = 1e6; ///< of a place [m], and of a turn [rad]
constexpr double longest = 1e9;  ///< of a time [s]: what follows it tells whether it is kept
constexpr std::int64_t largest_motion = std::int64_t{1} << 28; // half an hour of places and turns at 1 kHz

/// Without blanks.
std::vector<std::string> bare(std::vector<std::string> cells) {
  for (std::string& cell : cells)
    std::erase_if(cell, [](char c) { return c == ' ' || c == '\t'; });
  if (cells.size() > 1 && cells.back().empty())
    cells.pop_back(); // behind a comma at the end of the line
  return cells;
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn) {
  const double angle = turn.norm();
  if (angle == 0)
    return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

Dimension dimension_of(std::size_t column) {
  return column == 0 ? Dimension::time : column < 4 ? Dimension::length : Dimension::angle;
}

class Reader {
public:
  explicit Reader(std::string file) : file_(std::move(file)) {}

  RecordedMotion read(std::string_view text);

private:
  void fault(std::string expected, std::string found) {
    faults_.push_back({file_, line_, "", std::move(expected), std::move(found)});
  }
  void read_header(const std::vector<std::string>& cells);
  double number(const std::string& cell, std::size_t column) const;
  void read_sample(const std::vector<std::string>& cells);

  std::string file_;
  int line_ = 0;
  std::size_t columns_ = 0;         ///< 0: the header has not come yet
  std::array<std::string, 7> unit_; ///< empty: that of SI
  std::vector<RecordedMotion::Sample> samples_;
  std::vector<Fault> faults_;
};

/// Names, each perhaps with its unit in brackets.
void Reader::read_header(const std::vector<std::string>& cells) {
  std::string names;
  for (std::size_t column = 0; column < cells.size(); ++column) {
    const std::string& cell = cells[column];
    const auto bracket = cell.find('[');
    names += (column > 0 ? "," : "") + cell.substr(0, bracket);
    if (bracket == std::string::npos || column >= unit_.size())
      continue;
    unit_[column] = " " + cell.substr(bracket + 1, cell.size() - bracket - 2);
    if (!cell.ends_with(']') || !parse_quantity("1" + unit_[column], dimension_of(column)))
      fault("a unit of " + describe(dimension_of(column)), fmt::format("\"{}\"", cell));
  }
  columns_ = names == header_with_turns ? unit_.size() : 4;
  if (names != header && names != header_with_turns)
    fault(fmt::format("{} or {}, each with its unit in brackets if it is not that of SI", header,
                      header_with_turns),
          fmt::format("\"{}\"", fmt::join(cells, ",")));
}

/// In SI units; not finite where the cell holds no number.
double Reader::number(const std::string& cell, std::size_t column) const {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size())
    return std::numeric_limits<double>::quiet_NaN();
  if (!unit_[column].empty() && std::isfinite(value)) // bit-identical to the scene's reader
    value = parse_quantity(cell + unit_[column], dimension_of(column)).value_or(0);
  return value;
}

void Reader::read_sample(const std::vector<std::string>& cells) {
  std::array<double, std::tuple_size_v<decltype(unit_)>> values{};
  bool is_finite = cells.size() == columns_;
  for (std::size_t i = 0; is_finite && i < columns_; ++i)
    is_finite = std::isfinite(values[i] = number(cells[i], i));
  if (!is_finite)
    return fault(fmt::format("{} finite numbers with commas between them", columns_),
                 fmt::format("\"{}\"", fmt::join(cells, ",")));
  for (std::size_t i = 0; i < columns_; ++i) {
    const double most = i == 0 ? longest : furthest;
    if (!(std::abs(values[i]) <= most))
      return fault(fmt::format("at most {:g} {}", most,
                               i == 0  ? "s"
                               : i < 4 ? "m"
                                       : "rad"),
                   fmt::format("{:g}", values[i]));
  }
  if (!samples_.empty() && !(values[0] > samples_.back().time))
    return fault(fmt::format("a time after {} s", samples_.back().time), fmt::format("{} s", values[0]));
  if (samples_.empty() && values[0] < 0)
    return fault("a time from 0 s on", fmt::format("{} s", values[0]));
  samples_.push_back(
      {values[0], Pose{rotation_of({values[4], values[5], values[6]}), {values[1], values[2], values[3]}}});
}

RecordedMotion Reader::read(std::string_view text) {
  for (CsvRecords records(text, CsvComments::anywhere); records.next();) {
    line_ = records.line();
    const std::vector<std::string> cells = bare(records.cells());
    if (cells.size() == 1 && cells.front().empty())
      continue;
    columns_ == 0 ? read_header(cells) : read_sample(cells);
  }
  if (samples_.empty() && faults_.empty()) {
    line_ = 0;
    fault("at least one line of numbers under " + std::string(header), "none");
  }
  if (!faults_.empty())
    throw InputError(std::move(faults_));
  return RecordedMotion(std::move(samples_));
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
  return Reader(file).read(text);
}

RecordedMotion read_recorded_motion(const std::filesystem::path& file) {
  return parse_recorded_motion(read_text_file(file, "a recorded motion", largest_motion), file.string());
}

} // namespace maille::deform
