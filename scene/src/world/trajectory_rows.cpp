#include "world/trajectory_rows.hpp"

#include "maille/materials/csv_table.hpp"
#include "read/reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

std::vector<CsvColumn> columns() {
  const auto length = Dimension::length;
  const auto none = Dimension::dimensionless;
  return {{"frame", {}},           {"nodes", {}, false},    {"release", {}, false},
          {"set", {}, false},      {"value", {}, false},    {"object", {}},
          {"where", {}, false},    {"slide", {}, false},    {"dx", length, false},
          {"dy", length, false},   {"dz", length, false},   {"x", length, false},
          {"y", length, false},    {"z", length, false},    {"angle", Dimension::angle, false},
          {"axis_x", none, false}, {"axis_y", none, false}, {"axis_z", none, false}};
}

/// Text of a cell written by csv_text.
std::string plain(const CsvTable& row, std::string_view column) {
  return without_guard(std::string(row.text(column)));
}

/// 0 where there is no such column, or nothing in it.
double quantity(CsvTable& row, std::string_view column) {
  return row.text(column).empty() ? 0 : row.number(column).value_or(0);
}

/// True for a frame without a drive.
bool is_frame_alone(const CsvTable& row) {
  return !row.text("frame").empty() && std::ranges::all_of(columns(), [&](const CsvColumn& column) {
    return column.name == "frame" || row.text(column.name).empty();
  });
}

/// Nodes of a face, "x-" and so on.
std::vector<std::int64_t> nodes_of_face(std::string_view face, const Specimen& body, CsvTable& row) {
  const auto region = Region::face(face, body.grid.dimension());
  if (!region)
    row.fault("where", "a face of the deformable object: x-, x+, ...", "\"" + std::string(face) + "\"");
  return region ? region->nodes(body) : std::vector<std::int64_t>{};
}

/// Numbers of nodes, and `first-last` for several, with blanks between.
std::vector<std::int64_t> listed_nodes(std::string_view text, const Specimen& body, CsvTable& row) {
  std::vector<std::int64_t> nodes;
  const auto wrong = [&] {
    row.fault("nodes", "numbers of nodes of the body, each once, and ranges of them: `12 17-19`",
              "\"" + std::string(text) + "\"");
    return std::vector<std::int64_t>{};
  };
  for (const char *at = text.data(), *const end = at + text.size(); at != end;) {
    if (*at == ' ') {
      ++at;
      continue;
    }
    std::int64_t first = 0;
    auto read = std::from_chars(at, end, first);
    std::int64_t last = first;
    if (read.ec == std::errc() && read.ptr != end && *read.ptr == '-')
      read = std::from_chars(read.ptr + 1, end, last);
    if (read.ec != std::errc() || (read.ptr != end && *read.ptr != ' ') || first < 0 || last < first ||
        last >= body.grid.n_nodes())
      return wrong();
    for (; first <= last; ++first) {
      if (!body.is_node(body.grid.node_at(first)))
        return wrong();
      nodes.push_back(first);
    }
    at = read.ptr;
  }
  std::vector<std::int64_t> sorted = nodes;
  std::ranges::sort(sorted);
  return std::ranges::adjacent_find(sorted) == sorted.end() ? nodes : wrong();
}

/// By object and text: rows with the same region share it.
using Regions = std::map<std::pair<std::size_t, std::string>, NodeRuns, std::less<>>;

NodeRuns read_nodes(CsvTable& row, std::size_t object, const Specimen& body, Regions& regions) {
  const std::string_view list = row.text("nodes"), face = row.text("where");
  if (!list.empty() && !face.empty())
    row.fault("nodes", "either `where` or `nodes`", "both");
  const std::pair key(object, std::string(list.empty() ? face : list));
  const auto known = regions.find(key);
  if (known != regions.end())
    return known->second;
  NodeRuns nodes = list.empty() ? nodes_of_face(face, body, row) : listed_nodes(list, body, row);
  return nodes.empty() ? nodes : regions.emplace(key, std::move(nodes)).first->second;
}

void read_release(CsvTable& row, DriveSpan& span) {
  const std::string_view release = row.text("release");
  span.release = release == "true" || release == "1";
  if (!release.empty() && !span.release && release != "false" && release != "0")
    row.fault("release", "true or false", "\"" + std::string(release) + "\"");
  if (span.release && row.has_any({"where", "nodes", "slide", "dx", "dy", "dz", "x", "y", "z", "angle"}))
    row.fault("release", "nothing else of an object that is released", "a movement");
}

/// Reads a row that changes a constant.
std::optional<WorldSetting> read_setting(CsvTable& row, const WorldScene& world) {
  WorldSetting setting{std::nullopt, std::string(row.text("set")), plain(row, "value")};
  if (row.text("frame") != "0")
    row.fault("frame", "0: constants are those of all frames", "\"" + std::string(row.text("frame")) + "\"");
  const auto checked = [&](WorldSetting& read) -> std::optional<WorldSetting> {
    const auto expected = expected_of(read, world);
    if (expected)
      row.fault("value", *expected, "\"" + read.name + "\": \"" + read.value + "\"");
    return expected ? std::nullopt : std::optional(read);
  };
  if (row.text("object").empty())
    return checked(setting);
  setting.object = object_named(plain(row, "object"), world);
  if (!setting.object) {
    row.fault("object", "an object of the world", "\"" + plain(row, "object") + "\"");
    return std::nullopt;
  }
  return checked(setting);
}

void read_turn(CsvTable& row, int dimension, DriveSpan& span) {
  span.angle = quantity(row, "angle");
  if (std::abs(span.angle) > std::numbers::pi)
    row.fault("angle", "at most half a turn a frame", "\"" + std::string(row.text("angle")) + "\"");
  if (!row.has_any({"axis_x", "axis_y", "axis_z"}))
    return;
  const Vec3 axis{quantity(row, "axis_x"), quantity(row, "axis_y"), quantity(row, "axis_z")};
  const double length = std::hypot(axis[0], axis[1], axis[2]);
  if (!(length > 0) || (dimension < 3 && (axis[0] != 0 || axis[1] != 0)))
    row.fault("axis_x", dimension < 3 ? "an axis along z" : "an axis that is not zero", "another");
  else
    span.axis = {axis[0] / length, axis[1] / length, axis[2] / length};
}

void read_movement(CsvTable& row, int dimension, bool is_rigid, DriveSpan& span) {
  span.by = {quantity(row, "dx"), quantity(row, "dy"), quantity(row, "dz")};
  if (!is_rigid && row.has_any({"x", "y", "z", "angle", "axis_x", "axis_y", "axis_z", "slide"}))
    row.fault("where", "nodes of a deformable object shifted by dx, dy, dz", "a position, a turn or `slide`");
  if (row.has_any({"x", "y", "z"})) {
    span.to = Vec3{quantity(row, "x"), quantity(row, "y"), quantity(row, "z")};
    if (row.has_any({"dx", "dy", "dz"}))
      row.fault("x", "either dx, dy, dz or x, y, z", "both");
  }
  read_turn(row, dimension, span);
  for (int a = dimension; a < 3; ++a)
    if (span.by[a] != 0 || (span.to && (*span.to)[a] != 0))
      row.fault(std::string(1, "xyz"[a]), fmt::format("0: the world has {} dimensions", dimension),
                "another");
  const std::string_view slide = row.text("slide");
  span.slide = slide == "true" || slide == "1";
  if (!slide.empty() && !span.slide && slide != "false" && slide != "0")
    row.fault("slide", "true or false", "\"" + std::string(slide) + "\"");
}

std::optional<std::int64_t> read_frame(CsvTable& row) {
  const std::string_view text = row.text("frame");
  std::int64_t frame = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), frame);
  if (error == std::errc() && end == text.data() + text.size() && frame >= 1 && frame <= most_frames)
    return frame;
  row.fault("frame", fmt::format("a whole number from 1 to {}", most_frames),
            "\"" + std::string(text) + "\"");
  return std::nullopt;
}

std::optional<DriveSpan> read_row(CsvTable& row, const WorldScene& world, Regions& regions) {
  DriveSpan span;
  const auto frame = read_frame(row);
  if (!frame)
    return std::nullopt;
  span.first_frame = *frame;
  const std::string name = plain(row, "object");
  const auto object = object_named(name, world);
  if (!object || world.objects[*object].kind == ObjectKind::fixed) {
    row.fault("object", movable_names(world), "\"" + name + "\"");
    return std::nullopt;
  }
  span.object = *object;
  const bool is_rigid = world.objects[*object].kind == ObjectKind::rigid;
  read_release(row, span);
  if (span.release)
    return span;
  if (!is_rigid)
    span.nodes = read_nodes(row, *object, world.objects[*object].scene.specimen, regions);
  else if (row.has_any({"where", "nodes"}))
    row.fault(row.text("where").empty() ? "nodes" : "where", "nothing: a rigid object moves as a whole",
              "\"" + std::string(row.text("where")) + std::string(row.text("nodes")) + "\"");
  read_movement(row, world.dimension, is_rigid, span);
  return span;
}

} // namespace

Trajectory read_trajectory_rows(std::string_view text, const WorldScene& world, FaultList& faults) {
  Trajectory trajectory;
  std::optional<WorldScene> with_tool; ///< rows may drive an object that a row has added
  const WorldScene* whole = &world;
  Regions regions;
  CsvTable row(text, CsvComments::lines, columns(), faults);
  while (row.next()) {
    if (!row.text("set").empty()) {
      if (auto setting = read_setting(row, *whole)) {
        if (setting->name == "tool")
          apply(*setting, with_tool.emplace(*whole));
        whole = with_tool ? &*with_tool : whole;
        trajectory.settings.push_back(std::move(*setting));
      }
    } else if (is_frame_alone(row)) {
      if (const auto frame = read_frame(row))
        trajectory.n_frames = std::max(trajectory.n_frames, *frame);
    } else if (auto span = read_row(row, *whole, regions))
      trajectory.spans.push_back(std::move(*span));
  }
  return trajectory;
}

} // namespace maille::reader
