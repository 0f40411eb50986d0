#include "read/condition_tables.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace maille::reader {

namespace {

constexpr std::string_view axis_names = "xyz";

/// One `[[hold]]` or `[[move]]` as read.
struct Condition {
  std::vector<std::int64_t> nodes;
  std::array<bool, 3> axes{};
  Vec3 by{};
  std::optional<Turn> turn; ///< its shift is `by`
  bool held = false;
  std::string path;
  int line = 0;

  double value(const Specimen& body, std::int64_t node, std::size_t component) const {
    if (held)
      return 0;
    return turn ? turn->displacement(body.position(body.grid.node_at(node)))[component] : by[component];
  }
};

/// The middle of the box that holds nodes at rest.
Vec3 middle(const Specimen& body, const std::vector<std::int64_t>& nodes) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Vec3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
  for (const std::int64_t node : nodes) {
    const Vec3 x = body.position(body.grid.node_at(node));
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], x[a]);
      high[a] = std::max(high[a], x[a]);
    }
  }
  return {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
}

/// Axes that may be named: those of the scene, or all where its dimension is not known.
std::size_t n_axes(int dimension) {
  return dimension > 0 ? static_cast<std::size_t>(dimension) : 3;
}

/// `axes = "xz"`; all axes of the scene where it is absent.
std::array<bool, 3> read_axes(TableReader& table, int dimension) {
  std::array<bool, 3> axes{};
  const auto text = table.text("axes");
  if (!text) {
    std::fill_n(axes.begin(), n_axes(dimension), true);
    return axes;
  }
  for (const char c : *text) {
    const auto axis = axis_names.find(c);
    if (axis == std::string_view::npos || axis >= n_axes(dimension) || axes[axis]) {
      table.fault("axes",
                  fmt::format("letters out of \"{}\", each once", axis_names.substr(0, n_axes(dimension))),
                  "\"" + *text + "\"");
      return axes;
    }
    axes[axis] = true;
  }
  if (text->empty())
    table.fault("axes", "at least one axis", "\"\"");
  return axes;
}

/// `by`, `turn` or both; `by` is needed where there is no turn.
void read_motion(TableReader& table, int dimension, Condition& condition, bool& turns_about_its_middle) {
  condition.turn = read_turn(table, dimension, turns_about_its_middle);
  if (table.has("by") || !table.has("turn"))
    condition.by = read_vector(table, "by", Dimension::length, dimension).value_or(Vec3{});
}

/// A condition whose turn, if it has one, knows where and what it turns.
Condition with_turn_placed(Condition condition, const Specimen& body, bool turns_about_its_middle) {
  if (!condition.turn)
    return condition;
  Turn& turn = *condition.turn;
  turn.by = condition.by;
  turn.axes = condition.axes;
  if (turns_about_its_middle)
    turn.about = middle(body, condition.nodes);
  return condition;
}

/// One condition, if its region holds nodes; without a body, only its faults.
void read_condition(TableReader& table, bool held, const Scene& scene, bool has_body,
                    std::vector<Condition>& conditions) {
  Condition condition;
  condition.held = held;
  condition.path = table.path();
  condition.line = table.line();
  const auto region = Region::read(table, scene.dimension());
  condition.axes = read_axes(table, scene.dimension());
  bool turns_about_its_middle = false;
  if (!held)
    read_motion(table, scene.dimension(), condition, turns_about_its_middle);
  if (!region || !has_body)
    return;
  condition.nodes = region->nodes(scene.specimen);
  if (condition.nodes.empty())
    table.fault("where", "a region with at least one node of the body in it", in_words(*table.find("where")));
  else
    conditions.push_back(with_turn_placed(std::move(condition), scene.specimen, turns_about_its_middle));
}

std::vector<Condition> read_holds_and_moves(TableReader& root, const Scene& scene, bool has_body) {
  std::vector<Condition> conditions;
  for (const bool held : {true, false})
    for_each_table(root, held ? "hold" : "move",
                   [&](TableReader& table) { read_condition(table, held, scene, has_body, conditions); });
  return conditions;
}

/// Nodes that keep matter in the scene: the held ones, or the moved ones where nothing is held.
std::vector<std::int64_t> anchors_of(const std::vector<Condition>& conditions) {
  const bool any_held =
      std::any_of(conditions.begin(), conditions.end(), [](const Condition& c) { return c.held; });
  std::vector<std::int64_t> anchors;
  for (const Condition& condition : conditions)
    if (condition.held == any_held)
      anchors.insert(anchors.end(), condition.nodes.begin(), condition.nodes.end());
  return anchors;
}

std::string place(const Scene& scene, std::int64_t node) {
  const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(node));
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", x[0], x[1], x[2]);
}

/// A component that two conditions want to have different values.
void report_contradiction(const Scene& scene, const Prescribed& first, const Condition& second, int component,
                          std::int64_t count, FaultList& faults) {
  const char axis = axis_names[static_cast<std::size_t>(component)];
  const double value = second.value(scene.specimen, first.node, static_cast<std::size_t>(component));
  const bool hold_and_move = first.held != second.held;
  faults.add(second.line, second.path,
             hold_and_move ? "nodes that are held or moved, not both" : "moves that agree where they overlap",
             fmt::format("{} node{} along {}: at {} displaced by {:.6g} m {} and {:.6g} m here", count,
                         count == 1 ? "" : "s", axis, place(scene, first.node), first.value,
                         hold_and_move ? "(a hold)" : "elsewhere", value));
}

/// Turns conditions into prescribed components; where two differ, one fault a pair of conditions and
/// component.
void resolve(const std::vector<Condition>& conditions, Scene& scene, FaultList& faults) {
  constexpr int none = -1;
  const auto n = static_cast<std::size_t>(scene.specimen.grid.n_nodes());
  for (int component = 0; component < scene.dimension(); ++component) {
    const auto b = static_cast<std::size_t>(component);
    std::map<std::int64_t, Prescribed> of_node;
    for (const Condition& condition : conditions) {
      if (!condition.axes[b])
        continue;
      std::int64_t conflicts = 0, first_conflict = none;
      for (const std::int64_t node : condition.nodes) {
        if (static_cast<std::size_t>(node) >= n || !scene.specimen.is_node(scene.specimen.grid.node_at(node)))
          continue; // on a piece that was left out
        const Prescribed wanted{node, component, condition.value(scene.specimen, node, b), condition.held};
        const auto [entry, is_new] = of_node.emplace(node, wanted);
        if (is_new || entry->second.value == wanted.value)
          continue;
        if (conflicts++ == 0)
          first_conflict = node;
      }
      if (conflicts > 0)
        report_contradiction(scene, of_node.at(first_conflict), condition, component, conflicts, faults);
    }
    for (const auto& [node, prescribed] : of_node)
      scene.prescribed.push_back(prescribed);
  }
}

/// Leaves out what nothing holds, then prescribes the components of what stays.
void place(const std::vector<Condition>& conditions, Scene& scene, FaultList& faults) {
  if (leave_out_loose_pieces(scene, anchors_of(conditions)) == 0)
    faults.add(conditions.front().line, conditions.front().path, "matter joined to a held node", "none");
  for (const Condition& condition : conditions)
    if (!condition.held &&
        std::none_of(condition.nodes.begin(), condition.nodes.end(), [&](std::int64_t node) {
          return scene.specimen.is_node(scene.specimen.grid.node_at(node));
        }))
      faults.add(condition.line, condition.path + ".where", "a node of a piece that something holds",
                 "only nodes of pieces that nothing holds");
  resolve(conditions, scene, faults);
  for (const Condition& condition : conditions)
    if (condition.turn) {
      scene.turns.push_back(*condition.turn);
      std::ranges::copy_if(
          condition.nodes, std::back_inserter(scene.turns.back().nodes),
          [&](std::int64_t node) { return scene.specimen.is_node(scene.specimen.grid.node_at(node)); });
    }
}

} // namespace

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
      table.fault(key,
                  fmt::format("0 along {}: the scene has {} dimension{}", axis_names[a], dimension,
                              dimension == 1 ? "" : "s"),
                  describe(*node));
      good = false;
    }
  }
  return good ? std::optional(v) : std::nullopt;
}

void read_conditions(TableReader& root, Scene& scene, const std::vector<float>& labels, bool has_body) {
  const auto conditions = read_holds_and_moves(root, scene, has_body);
  if (has_body && !root.has("hold") && !root.has("move"))
    root.faults().add(0, "hold", "at least one [[hold]] or [[move]]: nothing keeps the body in place",
                      "neither");
  if (!conditions.empty())
    place(conditions, scene, root.faults());
  read_loads(root, scene, labels, has_body);
}

void read_holds(TableReader& table, Scene& scene, bool has_body) {
  std::vector<Condition> conditions;
  for_each_table(table, "hold",
                 [&](TableReader& hold) { read_condition(hold, true, scene, has_body, conditions); });
  resolve(conditions, scene, table.faults());
}

} // namespace maille::reader
