#include "maille/scene/warp/displacement_field.hpp"
#include "read/reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

/// `axes = "xz"`; default: all axes of the scene.
std::array<bool, 3> read_axes(TableReader& table, int dimension) {
  const auto text = table.text("axes");
  if (!text)
    return all_axes(dimension);
  return axes_named(*text, dimension, {table.path_of("axes"), table.line_of_key("axes"), "\"" + *text + "\""},
                    table.faults());
}

/// Places are in the body's world; vectors in the axes of the header, or without them in the table's frame.
std::function<std::optional<Vec3>(const Vec3&)> field_of_image(std::shared_ptr<DisplacementImage> image,
                                                               const TableFrame& frame) {
  return [image = std::move(image), frame](const Vec3& x) -> std::optional<Vec3> {
    const auto u = image->at(point_in_world(frame.body_in_world, x));
    return u && !image->is_along_object() ? std::optional(frame.vector_in_object(*u)) : u;
  };
}

/// Displacement of the nearest point, if it is within reach. Places and vectors are in the table's frame.
std::function<std::optional<Vec3>(const Vec3&)> field_of_points(std::vector<DisplacementPoint> points,
                                                                double within, const TableFrame& frame) {
  for (DisplacementPoint& point : points) {
    point.place = point_in_object(frame.placement, point.place);
    point.displacement = frame.vector_in_object(point.displacement);
  }
  return [points = std::move(points), within](const Vec3& x) -> std::optional<Vec3> {
    const DisplacementPoint* nearest = nullptr;
    double least = within * (1 + 1e-9);
    for (const DisplacementPoint& point : points)
      if (const double distance =
              std::hypot(point.place[0] - x[0], point.place[1] - x[1], point.place[2] - x[2]);
          distance <= least) {
        least = distance;
        nearest = &point;
      }
    return nearest ? std::optional(nearest->displacement) : std::nullopt;
  };
}

/// `by`, `turn` or both; `by` is required without `turn`.
void read_motion(TableReader& table, int dimension, const TableFrame& frame, Condition& condition,
                 bool& turns_about_its_middle) {
  if (const auto turn = read_turn(table, dimension, turns_about_its_middle))
    condition.turn = frame.in_object(*turn);
  if (table.has("by") || !table.has("turn"))
    condition.by = frame.vector_in_object(read_vector(table, "by", dimension).value_or(Vec3{}));
}

/// `field = { image, unit }` or `{ points, within }`: displacements from a file, in place of `by` and `turn`.
void read_field(TableReader& table, const TableFrame& frame, int dimension, const Specimen* body,
                Condition& condition) {
  for (const char* key : {"by", "turn"})
    table.refuse(key, "no such key with a `field`");
  auto field = table.open("field");
  if (!field)
    return;
  const bool is_image = field->has("image");
  const char* const key = is_image ? "image" : "points";
  field->require(key, "an image of displacements, or a table of `points`");
  const auto file = read_file_name(*field, key);
  double metres = 1e-3, within = 0;
  if (is_image) {
    const auto unit = field->text("unit");
    const auto factor = parse_quantity("1 " + unit.value_or("mm"), Dimension::length);
    if (!factor)
      field->fault("unit", "a unit of length, such as \"mm\"");
    metres = factor.value_or(metres);
  } else if (field->require("within")) {
    field->read("within", within);
  }
  field->finish();
  if (!file)
    return;
  if (dimension == 1) {
    table.fault("field", "a scene of two or three dimensions", "one dimension");
    return;
  }
  try {
    if (is_image)
      condition.field = field_of_image(std::make_shared<DisplacementImage>(*file, metres, body), frame);
    else
      condition.field =
          field_of_points(read_displacement_points(*file, &table.faults().units), within, frame);
  } catch (const InputError& error) {
    adopt(error, field->path_of(key), field->line_of_key(key), table.faults());
  }
}

/// One condition, if its region contains nodes; without a body, only its faults.
void read_condition(TableReader& table, bool held, const Scene& scene, bool has_body,
                    std::vector<Condition>& conditions) {
  Condition condition;
  condition.held = held;
  condition.asked = {table.path(), table.line(), ""};
  const Specimen* body = has_body ? &scene.specimen : nullptr;
  const TableFrame frame = read_table_frame(table, scene.dimension(), body);
  const auto region = read_region(table, scene.dimension(), body, frame.frame);
  condition.axes = read_axes(table, scene.dimension());
  if (frame.frame != CoordinateFrame::grid && condition.axes != all_axes(scene.dimension()))
    table.fault("axes", "all axes, as single ones are those of the grid, and `frame` is another");
  bool turns_about_its_middle = false;
  if (!held && table.has("field"))
    read_field(table, frame, scene.dimension(), body, condition);
  else if (!held)
    read_motion(table, scene.dimension(), frame, condition, turns_about_its_middle);
  for (std::size_t b = 0; b < n_axes(scene.dimension()); ++b)
    if (!condition.axes[b] && condition.by[b] != 0)
      table.fault("by", fmt::format("0 along {}, which `axes` leaves out", "xyz"[b]));
  if (region && has_body)
    add_condition(std::move(condition), *region, asked_where(table), turns_about_its_middle, scene.specimen,
                  conditions, table.faults());
}

std::vector<Condition> read_holds_and_moves(TableReader& root, const Scene& scene, bool has_body) {
  std::vector<Condition> conditions;
  for (const bool held : {true, false})
    for_each_table(root, held ? "hold" : "move",
                   [&](TableReader& table) { read_condition(table, held, scene, has_body, conditions); });
  return conditions;
}

} // namespace

Asked asked_where(TableReader& table) {
  return {table.path_of("where"), table.line_of_key("where"), in_words(*table.find("where"))};
}

std::string in_words(const toml::node& node) {
  std::ostringstream text;
  text << toml::node_view<const toml::node>(node);
  return text.str();
}

namespace {

/// Example of a vector along the last axis, in scene syntax.
std::string example_of(Dimension unit, std::size_t n) {
  const char* const last = unit == Dimension::length     ? "\"2 mm\""
                           : unit == Dimension::pressure ? "\"1 kPa\""
                           : unit == Dimension::force    ? "\"20 N\""
                                                         : "\"-9.81 m/s^2\"";
  std::string text = "[";
  for (std::size_t a = 1; a < n; ++a)
    text += "0, ";
  return text + last + "]";
}

/// Forces in 2D are per thickness and may have such a unit: "3 N/mm" is "3000 N" per metre.
std::optional<double> force_per_thickness(const toml::node& node) {
  const std::string text = node.value_exact<std::string>().value_or("");
  for (const auto& [ending, per_metre] : {std::pair("/mm", 1e3), std::pair("/m", 1.0)})
    if (text.ends_with(ending))
      if (const auto force = parse_quantity(text.substr(0, text.rfind('/')), Dimension::force))
        return *force * per_metre;
  return std::nullopt;
}

} // namespace

std::optional<Vec3> read_vector(TableReader& table, std::string_view key, int dimension) {
  const Dimension unit = table.dimension(key);
  const toml::node* node = table.require(key);
  if (!node)
    return std::nullopt;
  const auto* list = node->as_array();
  const std::size_t n = n_axes(dimension);
  const bool any_length = dimension == 0 && list && !list->empty() && list->size() <= 3;
  if (list && list->size() != n && list->size() != 3 && !any_length) {
    table.fault(key, fmt::format("{} quantities", n));
    return std::nullopt;
  }
  const auto is_zero = [&] { return node->value<double>() == 0.0; }; // whatever the direction
  if (!list && n > 1 && !is_zero()) {
    table.fault(key,
                fmt::format("a list of {} quantities, one for each axis, such as {}", n, example_of(unit, n)),
                describe(*node) + ", one for all");
    return std::nullopt;
  }
  Vec3 v{};
  bool good = true;
  for (std::size_t a = 0; a < (list ? list->size() : n); ++a) {
    const toml::node& entry = list ? *list->get(a) : *node;
    auto value = unit == Dimension::force && dimension == 2 ? force_per_thickness(entry) : std::nullopt;
    if (!value)
      value = read_quantity(entry, table.path_of(key), unit, table.faults());
    good = good && value;
    v[a] = value.value_or(0);
    if (a >= n && v[a] != 0) {
      table.fault(key, wanted_zero(a, dimension));
      good = false;
    }
  }
  return good ? std::optional(v) : std::nullopt;
}

void read_conditions(TableReader& root, const toml::table& document, Scene& scene,
                     const std::vector<float>& labels, bool has_body) {
  auto conditions = read_holds_and_moves(root, scene, has_body);
  read_drives(root, scene, has_body, conditions);
  std::ranges::move(read_test(root, scene, has_body), std::back_inserter(conditions));
  const std::vector<std::int64_t> springs =
      has_body ? nodes_of_foundations(document, scene, root.faults()) : std::vector<std::int64_t>{};
  if (has_body && !root.has("hold") && !root.has("move") && !root.has("drive") && !root.has("test") &&
      springs.empty())
    report_loose_body(root.faults());
  if (!conditions.empty())
    prescribe(conditions, springs, scene, root.faults());
  read_loads(root, scene, labels, has_body);
  read_sliding(root, scene, has_body);
}

void read_holds(TableReader& table, Scene& scene, bool has_body) {
  std::vector<Condition> conditions;
  for_each_table(table, "hold",
                 [&](TableReader& hold) { read_condition(hold, true, scene, has_body, conditions); });
  prescribe_components(conditions, scene, table.faults());
}

} // namespace maille::reader
