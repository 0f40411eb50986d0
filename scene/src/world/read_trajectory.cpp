#include "maille/scene/world/trajectory.hpp"

#include "maille/materials/text_file.hpp"
#include "read/reader.hpp"
#include "world/trajectory_rows.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace maille {

namespace reader {

std::optional<std::size_t> object_named(const std::string& name, const WorldScene& world) {
  const auto object = std::ranges::find(world.objects, name, &WorldObject::name);
  return object == world.objects.end()
             ? std::nullopt
             : std::optional(static_cast<std::size_t>(object - world.objects.begin()));
}

std::string movable_names(const WorldScene& world) {
  std::string names;
  for (const WorldObject& object : world.objects)
    if (object.kind != ObjectKind::fixed)
      names += (names.empty() ? "\"" : ", \"") + object.name + "\"";
  return names.empty() ? "an object that can move: the scene has none"
                       : "one of the objects that can move: " + names;
}

} // namespace reader

NodeRuns::NodeRuns(const std::vector<std::int64_t>& nodes) {
  std::vector<Run> runs;
  for (const std::int64_t node : nodes)
    if (runs.empty() || runs.back()[1] + 1 != node)
      runs.push_back({node, node});
    else
      runs.back()[1] = node;
  runs.shrink_to_fit();
  if (!runs.empty())
    runs_ = std::make_shared<const std::vector<Run>>(std::move(runs));
}

NodeRuns::operator std::vector<std::int64_t>() const {
  std::vector<std::int64_t> nodes;
  if (runs_)
    for (const auto& [first, last] : *runs_)
      for (std::int64_t node = first; node <= last; ++node)
        nodes.push_back(node);
  return nodes;
}

namespace {

using reader::most_frames;

/// `object` and, for a deformable one, `where`. @return false if there is no such object or region
bool read_driven(TableReader& table, const WorldScene& world, DriveSpan& span) {
  table.require("object", reader::movable_names(world));
  const auto name = table.text("object");
  const auto object = name ? reader::object_named(*name, world) : std::nullopt;
  if (!object || world.objects[*object].kind == ObjectKind::fixed) {
    table.find("where");
    if (name)
      table.fault("object", reader::movable_names(world),
                  object ? "\"" + *name + "\", which is fixed" : "\"" + *name + "\"");
    return false;
  }
  span.object = *object;
  if (world.objects[*object].kind == ObjectKind::rigid) {
    if (table.has("where"))
      table.fault("where", "no such key: a rigid object moves as a whole",
                  reader::in_words(*table.find("where")));
    return true;
  }
  if (table.has("release"))
    return true;
  const Specimen& body = world.objects[*object].scene.specimen;
  const auto region = reader::read_region(table, body.grid.dimension(), &body);
  if (!region)
    return false;
  const std::vector<std::int64_t> nodes = region->nodes(body);
  span.nodes = nodes;
  if (nodes.empty())
    table.fault("where", "a region with at least one node of the object in it",
                reader::in_words(*table.find("where")));
  return true;
}

/// `follow` and the `stiffness` of the spring between hand and object.
void read_follow(TableReader& table, DriveSpan& span) {
  constexpr double usual = 300; // [N/m], as the probe's
  bool follows = false;
  table.read("follow", follows);
  if (follows)
    span.follow = usual;
  if (const auto stiffness = table.number("stiffness")) {
    if (span.follow)
      span.follow = *stiffness;
    else
      table.fault("stiffness", "no such key without `follow = true`");
  }
  if (span.follow && span.slide)
    table.fault("slide", "either `slide` or `follow`", "both");
}

/// `by`, or `to`, and `turn`.
void read_asked(TableReader& table, const WorldScene& world, bool is_rigid, DriveSpan& span) {
  const int dimension = world.dimension;
  for (const char* key : {"to", "turn", "slide", "follow", "stiffness"})
    if (!is_rigid)
      table.refuse(key, "no such key: nodes of a deformable object are shifted `by`");
  if (const toml::node* release = table.find("release")) {
    span.release = release->value_or(false);
    if (!span.release)
      table.fault("release", "true, or nothing");
    for (const char* key : {"by", "to", "turn", "slide", "follow", "stiffness", "where"})
      if (table.has(key))
        table.fault(key, "no such key where an object is released", reader::in_words(*table.find(key)));
    return;
  }
  if (!table.has("by") && !table.has("to") && !table.has("turn"))
    table.fault("", is_rigid ? "`by`, `to` or `turn`" : "`by`", "none");
  if (table.has("by") && table.has("to"))
    table.fault("to", "either `by` or `to`", "both");
  if (table.has("by"))
    span.by = reader::read_vector(table, "by", dimension).value_or(Vec3{});
  if (!is_rigid)
    return;
  if (table.has("to"))
    span.to = reader::read_vector(table, "to", dimension);
  bool turns_about_its_middle = false;
  if (const auto turn = reader::read_turn(table, dimension, turns_about_its_middle)) {
    span.axis = turn->axis;
    span.angle = turn->angle;
    if (!turns_about_its_middle)
      span.about = turn->about;
    if (std::abs(turn->angle) > std::numbers::pi * static_cast<double>(span.n_frames))
      table.fault("turn", "at most half a turn a frame", reader::in_words(*table.find("turn")));
  }
  table.read("slide", span.slide);
  read_follow(table, span);
}

Trajectory read_tables(std::string_view text, const std::filesystem::path& file, const WorldScene& world,
                       FaultList& faults) {
  Trajectory trajectory;
  const toml::table document = parse_toml(text, file.string());
  TableReader root(document, "", faults, "trajectory");
  read_units(root);
  trajectory.frame_seconds = root.number("frame_time").value_or(trajectory.frame_seconds);
  root.read("frames", trajectory.n_frames);
  std::int64_t next = 1, bytes = 0;
  constexpr std::int64_t most_bytes = std::int64_t{64} << 20;
  reader::for_each_table(root, "drive", [&](TableReader& table) {
    DriveSpan span;
    span.first_frame = table.whole("start").value_or(next);
    table.read("frames", span.n_frames);
    next = span.end_frame();
    const bool is_known = read_driven(table, world, span);
    if (is_known || !table.has("object"))
      read_asked(table, world,
                 world.objects.empty() || world.objects[span.object].kind != ObjectKind::deformable, span);
    else
      for (const char* key : {"by", "to", "turn", "slide", "follow", "stiffness", "release"})
        table.find(key);
    if (!trajectory.spans.empty() && trajectory.spans.back().nodes == span.nodes)
      span.nodes = trajectory.spans.back().nodes; // one list for both
    else if ((bytes += span.nodes.bytes()) > most_bytes) {
      table.fault("where", fmt::format("regions of all drives that take at most {} MiB", most_bytes >> 20),
                  "more");
      faults.throw_if_any();
    }
    trajectory.spans.push_back(std::move(span));
  });
  root.finish();
  return trajectory;
}

} // namespace

Trajectory parse_trajectory(std::string_view text, const std::filesystem::path& file,
                            const WorldScene& world) {
  FaultList faults(file.string());
  Trajectory trajectory = file.extension() == ".csv" ? reader::read_trajectory_rows(text, world, faults)
                                                     : read_tables(text, file, world, faults);
  faults.throw_if_any();
  trajectory.name = file.stem().string();
  for (const DriveSpan& span : trajectory.spans) // neither of the two is above most_frames
    trajectory.n_frames = std::max(trajectory.n_frames, span.end_frame() - 1);
  if (trajectory.n_frames > most_frames)
    faults.add(0, "frames", fmt::format("at most {} frames, all drives one after another", most_frames),
               fmt::format("{}", trajectory.n_frames));
  faults.throw_if_any();
  std::ranges::stable_sort(trajectory.spans, {}, &DriveSpan::first_frame);
  return trajectory;
}

Trajectory read_trajectory(const std::filesystem::path& file, const WorldScene& world) {
  return parse_trajectory(read_text_file(file, "a trajectory file"), file, world);
}

} // namespace maille
