#include "read/reader.hpp"

#include <algorithm>
#include <iterator>
#include <sstream>

namespace maille::reader {

namespace {

/// `axes = "xz"`; all axes of the scene where it is absent.
std::array<bool, 3> read_axes(TableReader& table, int dimension) {
  const auto text = table.text("axes");
  if (!text)
    return all_axes(dimension);
  return axes_named(*text, dimension, {table.path_of("axes"), table.line_of_key("axes"), "\"" + *text + "\""},
                    table.faults());
}

/// `by`, `turn` or both; `by` is needed where there is no turn.
void read_motion(TableReader& table, int dimension, const TableFrame& frame, Condition& condition,
                 bool& turns_about_its_middle) {
  if (const auto turn = read_turn(table, dimension, turns_about_its_middle))
    condition.turn = frame.in_object(*turn);
  if (table.has("by") || !table.has("turn"))
    condition.by =
        frame.vector_in_object(read_vector(table, "by", Dimension::length, dimension).value_or(Vec3{}));
}

/// One condition, if its region holds nodes; without a body, only its faults.
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
    table.fault("axes", "all axes, as single ones are those of the grid, and `frame` is another",
                describe(*table.find("axes")));
  bool turns_about_its_middle = false;
  if (!held)
    read_motion(table, scene.dimension(), frame, condition, turns_about_its_middle);
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

/// A vector along the last axis, as a scene has it.
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

} // namespace

std::optional<Vec3> read_vector(TableReader& table, std::string_view key, Dimension unit, int dimension) {
  const toml::node* node = table.require(key, "a quantity for each axis");
  if (!node)
    return std::nullopt;
  const auto* list = node->as_array();
  const std::size_t n = n_axes(dimension);
  const bool any_length = dimension == 0 && list && !list->empty() && list->size() <= 3;
  if (list && list->size() != n && list->size() != 3 && !any_length) {
    table.fault(key, fmt::format("{} quantities", n), describe(*node));
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
    const auto value = read_quantity(list ? *list->get(a) : *node, table.path_of(key), unit, table.faults());
    good = good && value;
    v[a] = value.value_or(0);
    if (a >= n && v[a] != 0) {
      table.fault(key, wanted_zero(a, dimension), describe(*node));
      good = false;
    }
  }
  return good ? std::optional(v) : std::nullopt;
}

void read_conditions(TableReader& root, Scene& scene, const std::vector<float>& labels, bool has_body) {
  auto conditions = read_holds_and_moves(root, scene, has_body);
  std::ranges::move(read_test(root, scene, has_body), std::back_inserter(conditions));
  if (has_body && !root.has("hold") && !root.has("move") && !root.has("test"))
    report_loose_body(root.faults());
  if (!conditions.empty())
    prescribe(conditions, scene, root.faults());
  read_loads(root, scene, labels, has_body);
}

void read_holds(TableReader& table, Scene& scene, bool has_body) {
  std::vector<Condition> conditions;
  for_each_table(table, "hold",
                 [&](TableReader& hold) { read_condition(hold, true, scene, has_body, conditions); });
  prescribe_components(conditions, scene, table.faults());
}

} // namespace maille::reader
