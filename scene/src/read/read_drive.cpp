// Reads rigid labels that rotate about an axis or follow recorded poses, and time courses.
#include "conditions/number_table.hpp"
#include "read/reader.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

constexpr const char* wanted_course =
    "points [time, value], times from 0 to 1 ascending, such as [[0, 0], [0.5, 1], [1, 0]]";

/// Converts a rotation in a possibly mirrored frame to the object's frame.
RigidPose pose_of(const Turn& turn, double time) {
  const Eigen::Quaterniond q(
      Eigen::AngleAxisd(turn.angle, Eigen::Vector3d(turn.axis[0], turn.axis[1], turn.axis[2])));
  return {time, {q.w(), q.x(), q.y(), q.z()}, turn.by};
}

/// Largest rotation between poses, because interpolation takes the shorter way:
constexpr double largest_step = 1.5; // rad

/// Poses of one rotation and shift, scaled by a course.
std::vector<RigidPose> poses_of_course(const Turn& whole, const TimeCourse& course) {
  std::vector<std::array<double, 2>> points = course.points;
  if (points.empty())
    points = {{0, 0}, {1, 1}};
  if (points.front()[0] > 0)
    points.insert(points.begin(), {0, points.front()[1]});
  if (points.back()[0] < 1)
    points.push_back({1, points.back()[1]});
  std::vector<RigidPose> poses;
  const auto add = [&](double time, double value) {
    Turn part = whole;
    part.angle *= value;
    for (double& component : part.by)
      component *= value;
    poses.push_back(pose_of(part, time));
  };
  add(points[0][0], points[0][1]);
  for (std::size_t i = 1; i < points.size(); ++i) {
    const auto [t0, v0] = points[i - 1];
    const auto [t1, v1] = points[i];
    const int steps =
        std::max(1, static_cast<int>(std::ceil(std::abs((v1 - v0) * whole.angle) / largest_step)));
    for (int k = 1; k <= steps; ++k)
      add(t0 + (t1 - t0) * k / steps, v0 + (v1 - v0) * k / steps);
  }
  return poses;
}

/// The rows of a table of poses, relative to rest.
std::vector<RigidPose> read_poses(TableReader& table, const TableFrame& frame, const Vec3& about) {
  const int line = table.line_of_key("poses");
  const std::string path = table.path_of("poses");
  const auto file = read_file_name(table, "poses");
  if (!file)
    return {};
  try {
    const auto length = Dimension::length;
    const auto none = Dimension::dimensionless;
    const NumberTable rows = read_number_table(*file,
                                               {{"time", Dimension::time},
                                                {"dx", length, false},
                                                {"dy", length, false},
                                                {"dz", length, false},
                                                {"angle", Dimension::angle, false},
                                                {"axis_x", none, false},
                                                {"axis_y", none, false},
                                                {"axis_z", none, false}},
                                               table.faults().units);
    FaultList faults(file->string());
    std::vector<RigidPose> poses;
    const double first = rows.rows.front().values[0], last = rows.rows.back().values[0];
    for (const NumberRow& row : rows.rows) {
      const auto& v = row.values;
      Turn turn;
      turn.about = about;
      turn.angle = v[4];
      turn.by = frame.vector_in_object({v[1], v[2], v[3]});
      const double axis = std::hypot(v[5], v[6], v[7]);
      if (v[4] != 0 && !(axis > 0))
        faults.add(row.line, "axis_x", "an axis that is not zero for an angle that is not", "0, 0, 0");
      else if (axis > 0)
        turn.axis = {v[5] / axis, v[6] / axis, v[7] / axis};
      if (!poses.empty() && !(v[0] > first + poses.back().time * (last - first)))
        faults.add(row.line, "time", "times that ascend", fmt::format("{} s", v[0]));
      Turn in_object = frame.in_object(turn);
      in_object.by = turn.by;
      poses.push_back(pose_of(in_object, last > first ? (v[0] - first) / (last - first) : 1));
    }
    const RigidPose& rest = poses.front();
    if (poses.size() < 2)
      faults.add(0, "", "two poses or more", "one");
    else if (rest.shift != Vec3{} || std::abs(rest.rotation[0]) < 1 - 1e-12)
      faults.add(rows.rows.front().line, "", "the body at rest in the first row: poses are relative to it",
                 "another pose");
    faults.throw_if_any();
    return poses;
  } catch (const InputError& error) {
    adopt(error, path, line, table.faults());
    return {};
  }
}

/// `label = 30`, or a general `where`.
std::optional<Region> read_driven(TableReader& table, int dimension, const Specimen* body,
                                  const TableFrame& frame, Asked& where) {
  if (!table.has("label")) {
    auto region = read_region(table, dimension, body, frame.frame);
    if (table.has("where"))
      where = asked_where(table);
    return region;
  }
  if (table.has("where"))
    table.fault("where", "either `label` or `where`", "both");
  table.find("where");
  const auto label = table.whole("label");
  where = {table.path_of("label"), table.line_of_key("label"), label ? fmt::format("label {}", *label) : ""};
  if (!label || !body)
    return std::nullopt;
  const auto cells = cells_of_label(*label, *body);
  if (const auto* fault = std::get_if<RegionFault>(&cells)) {
    table.fault("label", fault->expected, fault->found);
    return std::nullopt;
  }
  return Region::of_cells(body->grid, std::get<std::vector<std::int64_t>>(cells));
}

Vec3 middle_of(const std::vector<std::int64_t>& nodes, const Specimen& body) {
  Vec3 sum{};
  for (const std::int64_t node : nodes) {
    const Vec3 x = body.position(body.grid.node_at(node));
    for (std::size_t a = 0; a < 3; ++a)
      sum[a] += x[a] / static_cast<double>(nodes.size());
  }
  return sum;
}

void read_drive(TableReader& table, const Scene& scene, bool has_body, std::vector<Condition>& conditions) {
  const std::size_t before = table.faults().size();
  const Specimen* body = has_body ? &scene.specimen : nullptr;
  const int dimension = scene.dimension();
  Condition condition;
  condition.asked = {table.path(), table.line(), ""};
  condition.axes = all_axes(dimension);
  const TableFrame frame = read_table_frame(table, dimension, body);
  Asked where;
  const auto region = read_driven(table, dimension, body, frame, where);
  Drive drive;
  bool about_its_middle = false;
  if (table.has("poses")) {
    for (const char* key : {"turn", "by", "course"})
      table.refuse(key, "no such key with `poses`");
    Vec3 about{};
    about_its_middle = !table.has("about");
    if (!about_its_middle)
      about = table.three("about").value_or(Vec3{});
    Turn place;
    place.about = about;
    drive.about = frame.in_object(place).about;
    drive.poses = read_poses(table, frame, about);
  } else {
    Turn whole;
    if (const auto turn = read_turn(table, dimension, about_its_middle))
      whole = frame.in_object(*turn);
    else if (!table.has("turn") && !table.has("by"))
      table.faults().add(table.line(), table.path(), "`turn`, `by` or both, or `poses`", "none of them");
    if (table.has("by"))
      whole.by = frame.vector_in_object(read_vector(table, "by", dimension).value_or(Vec3{}));
    drive.about = whole.about;
    drive.poses = poses_of_course(whole, read_course(table).value_or(TimeCourse{}));
  }
  if (table.faults().size() > before || !region || !has_body)
    return;
  if (about_its_middle)
    drive.about = middle_of(region->nodes(scene.specimen), scene.specimen);
  condition.drive = std::move(drive);
  add_condition(std::move(condition), *region, where, false, scene.specimen, conditions, table.faults());
}

} // namespace

std::optional<TimeCourse> read_course(TableReader& table) {
  const toml::node* node = table.find("course");
  if (!node)
    return std::nullopt;
  TimeCourse course;
  const auto* list = node->as_array();
  bool good = list && list->size() >= 1;
  for (std::size_t i = 0; good && i < list->size(); ++i) {
    const auto* point = list->get(i)->as_array();
    const auto time = point && point->size() == 2 ? point->get(0)->value<double>() : std::nullopt;
    const auto value = point && point->size() == 2 ? point->get(1)->value<double>() : std::nullopt;
    good = time && value && std::isfinite(*value) && *time >= 0 && *time <= 1 &&
           (course.points.empty() || *time > course.points.back()[0]);
    if (good)
      course.points.push_back({*time, *value});
  }
  if (good)
    return course;
  table.fault("course", wanted_course);
  return std::nullopt;
}

void read_drives(TableReader& root, const Scene& scene, bool has_body, std::vector<Condition>& conditions) {
  for_each_table(root, "drive", [&](TableReader& table) { read_drive(table, scene, has_body, conditions); });
}

} // namespace maille::reader
