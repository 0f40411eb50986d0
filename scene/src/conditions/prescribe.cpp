

#include "conditions/prescribe.hpp"

#include "geometry/border_normals.hpp"
#include "geometry/pieces.hpp"
#include "maille/base/vectors.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <ranges>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

std::string nothing_at(const Asked& where, const Specimen& body) {
  return where.text + "; " + reach_in_words(body);
}

using WeightedFaces = std::vector<std::pair<FaceLoad, double>>;

WeightedFaces faces_in(const Region& region, const Asked& where, const Specimen& body, FaultList& faults) {
  auto faces = region.weighted_faces(body);
  if (faces.empty())
    faults.add(where.line, where.key, "a region with at least one whole outer face of a cell in it",
               nothing_at(where, body));
  return faces;
}

/// `load[1].where` without the member, `"x+"` without quotes.
std::int32_t name_condition(Scene& scene, const std::string& key, const std::string& where) {
  const bool is_quoted =
      where.size() > 1 && where.front() == where.back() && (where.front() == '"' || where.front() == '\'');
  scene.conditions.push_back(
      {key.substr(0, key.rfind(".where")), is_quoted ? where.substr(1, where.size() - 2) : where});
  return static_cast<std::int32_t>(scene.conditions.size()) - 1;
}

/// @param traction of a face
template<class Traction>
void pull_at(const WeightedFaces& faces, Traction&& traction, const Asked& where, Scene& scene) {
  const std::int32_t condition = name_condition(scene, where.key, where.text);
  for (auto [face, part] : faces) {
    face.traction = traction(face);
    for (double& component : face.traction)
      component *= part;
    face.condition = condition;
    scene.tractions.push_back(face);
  }
}

} // namespace

void add_traction(const Region& region, const Vec3& traction, const Asked& where, Scene& scene,
                  FaultList& faults) {
  const auto faces = faces_in(region, where, scene.specimen, faults);
  // The net area of a sloped staircase is at least 1 / sqrt(3) of its total; an end with a depth has opposite
  // ones.
  constexpr double least_of_one_side = 0.57;
  double all = 0;
  Vec3 net{};
  for (const auto& [face, part] : faces) {
    const double of_face = part * face_area(scene.specimen.grid, face.axis);
    all += of_face;
    net[face.axis] += face.upper ? of_face : -of_face;
  }
  if (const double one_side = std::hypot(net[0], net[1], net[2]); one_side < least_of_one_side * all)
    scene.left_out.push_back(
        {0,
         fmt::format("{}: the traction acts on all faces there, {:.4g} mm^2, of which {:.4g} mm^2 have none "
                     "opposite; a `force` is shared out by area",
                     where.key.substr(0, where.key.rfind(".where")), 1e6 * all, 1e6 * one_side)});
  pull_at(
      faces, [&](const FaceLoad&) { return traction; }, where, scene);
}

void add_pressure(const Region& region, double pressure, const Asked& where, Scene& scene,
                  FaultList& faults) {
  const auto along_normal = [&](const FaceLoad& face) {
    Vec3 traction{};
    traction[face.axis] = face.upper ? -pressure : pressure;
    return traction;
  };
  const auto before = std::ssize(scene.tractions);
  pull_at(faces_in(region, where, scene.specimen, faults), along_normal, where, scene);
  std::for_each(scene.tractions.begin() + before, scene.tractions.end(),
                [](FaceLoad& face) { face.follows = true; });
}

void add_force(const Region& region, const Vec3& force, const Asked& where, Scene& scene, FaultList& faults) {
  const auto faces = faces_in(region, where, scene.specimen, faults);
  double total = 0;
  for (const auto& [face, part] : faces)
    total += part * face_area(scene.specimen.grid, face.axis);
  const Vec3 traction{force[0] / total, force[1] / total, force[2] / total};
  pull_at(
      faces, [&](const FaceLoad&) { return traction; }, where, scene);
}

void add_foundation(const Region& region, const Foundation& foundation, const Asked& where, Scene& scene,
                    FaultList& faults) {
  const WeightedFaces faces = faces_in(region, where, scene.specimen, faults);
  std::vector<OrientedFace> oriented;
  for (const auto& [face, part] : faces)
    oriented.push_back({face.cell, face.axis, face.upper});
  const BorderNormals normals(scene.specimen.grid, oriented);
  const std::int32_t condition = name_condition(scene, where.key, where.text);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const auto& [face, part] = faces[i];
    const Vec3 normal = normals.at(BorderNormals::middle(scene.specimen.grid, oriented[i]));
    // Weight of a face: its area projected onto the smooth surface.
    const double cosine = std::abs(normal[face.axis]);
    FaceSpring spring{face.cell, face.axis, face.upper, foundation.stiffness * part * cosine, {}, condition};
    if (foundation.is_normal) {
      spring.direction = normal;
      scene.springs.push_back(spring);
    } else if (foundation.axes == all_axes(scene.dimension())) {
      scene.springs.push_back(spring);
    } else {
      for (std::size_t a = 0; a < 3; ++a)
        if (foundation.axes[a]) {
          spring.direction = {};
          spring.direction[a] = 1;
          scene.springs.push_back(spring);
        }
    }
  }
}

void add_contraction(const std::vector<std::int64_t>& cells, double stress, Scene& scene) {
  if (cells.empty())
    return;
  scene.active_stress.resize(scene.specimen.grid.n_cells(), 0);
  for (const std::int64_t cell : cells)
    scene.active_stress[cell] += stress;
}

namespace {

constexpr std::string_view axis_names = "xyz";

/// Centre of the bounding box of nodes at rest.
Vec3 middle(const Specimen& body, const std::vector<std::int64_t>& nodes) {
  Eigen::AlignedBox3d box;
  for (const std::int64_t node : nodes)
    box.extend(Eigen::Map<const Eigen::Vector3d>(body.position(body.grid.node_at(node)).data()));
  const Eigen::Vector3d at = (box.min() + box.max()) / 2;
  return {at[0], at[1], at[2]};
}

/// Sets nodes and centre of the rotation of a condition, if it has one.
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

/// Nodes that keep pieces in the scene: the held ones; without holds, the moved ones.
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

/// Reports a component for which two conditions prescribe different values.
void report_contradiction(const Scene& scene, const Prescribed& first, const Condition& second, int component,
                          std::int64_t count, FaultList& faults) {
  const char axis = axis_names[component];
  const double value = second.value(scene.specimen, first.node, static_cast<std::size_t>(component));
  const bool hold_and_move = first.held != second.held;
  faults.add(second.asked.line, second.asked.key,
             hold_and_move ? "nodes that are held or moved, not both" : "moves that agree where they overlap",
             fmt::format("{} node{} along {}: at {} displaced by {:.6g} m {} and {:.6g} m here", count,
                         count == 1 ? "" : "s", axis, place(scene, first.node), first.value,
                         hold_and_move ? "(a hold)" : "elsewhere", value));
}

} // namespace

double Condition::value(const Specimen& body, std::int64_t node, std::size_t component) const {
  if (held)
    return 0;
  if (drive)
    return drive->displacement(body.position(body.grid.node_at(node)), 1)[component];
  if (!values.empty())
    return values[std::ranges::lower_bound(nodes, node) - nodes.begin()][component];
  return turn ? turn->displacement(body.position(body.grid.node_at(node)))[component] : by[component];
}

std::size_t n_axes(int dimension) {
  return dimension > 0 ? static_cast<std::size_t>(dimension) : 3;
}

std::array<bool, 3> all_axes(int dimension) {
  std::array<bool, 3> axes{};
  std::fill_n(axes.begin(), n_axes(dimension), true);
  return axes;
}

std::array<bool, 3> axes_named(std::string_view text, int dimension, const Asked& asked, FaultList& faults) {
  std::array<bool, 3> axes{};
  for (const char c : text) {
    const auto axis = axis_names.find(c);
    if (axis == std::string_view::npos || axis >= n_axes(dimension) || axes[axis]) {
      faults.add(asked.line, asked.key,
                 fmt::format("letters out of \"{}\", each once", axis_names.substr(0, n_axes(dimension))),
                 asked.text);
      return axes;
    }
    axes[axis] = true;
  }
  if (text.empty())
    faults.add(asked.line, asked.key, "at least one axis", asked.text);
  return axes;
}

std::string wanted_zero(std::size_t axis, int dimension) {
  return fmt::format("0 along {}: the scene has {} dimension{}", axis_names[axis], dimension,
                     dimension == 1 ? "" : "s");
}

void add_condition(Condition condition, const Region& region, const Asked& where, bool turns_about_its_middle,
                   const Specimen& body, std::vector<Condition>& conditions, FaultList& faults) {
  condition.nodes = region.nodes(body);
  condition.asked.text = where.text;
  if (condition.nodes.empty())
    faults.add(where.line, where.key, "a region with at least one node of the body in it",
               nothing_at(where, body));
  else if (!find_values(condition, body, faults))
    return;
  else
    conditions.push_back(with_turn_placed(std::move(condition), body, turns_about_its_middle));
}

bool find_values(Condition& condition, const Specimen& body, FaultList& faults) {
  if (!condition.field)
    return true;
  std::int64_t missing = 0;
  Vec3 first{};
  for (const std::int64_t node : condition.nodes) {
    const Vec3 x = body.position(body.grid.node_at(node));
    const auto value = condition.field(x);
    condition.values.push_back(value.value_or(Vec3{}));
    if (!value && missing++ == 0)
      first = x;
  }
  if (missing > 0)
    faults.add(condition.asked.line, condition.asked.key + ".field",
               "a displacement at every node of `where`",
               fmt::format("none, or no number, at {} of {} nodes, the first at ({:.5g}, {:.5g}, {:.5g}) mm",
                           missing, condition.nodes.size(), 1e3 * first[0], 1e3 * first[1], 1e3 * first[2]));
  return missing == 0;
}

void report_loose_body(FaultList& faults) {
  faults.add(0, "hold", "at least one [[hold]] or [[move]]: nothing keeps the body in place", "neither");
}

void prescribe_components(const std::vector<Condition>& conditions, Scene& scene, FaultList& faults) {
  constexpr int none = -1;
  const std::size_t n = scene.specimen.grid.n_nodes();
  const auto first = static_cast<std::int32_t>(scene.conditions.size());
  for (const Condition& condition : conditions)
    name_condition(scene, condition.asked.key, condition.asked.text);
  for (int component = 0; component < scene.dimension(); ++component) {
    const std::size_t b = component;
    std::map<std::int64_t, Prescribed> of_node;
    for (std::size_t i = 0; i < conditions.size(); ++i) {
      const Condition& condition = conditions[i];
      if (!condition.axes[b])
        continue;
      std::int64_t conflicts = 0, first_conflict = none;
      for (const std::int64_t node : condition.nodes) {
        if (static_cast<std::size_t>(node) >= n || !scene.specimen.is_node(scene.specimen.grid.node_at(node)))
          continue; // on a left-out piece
        const Prescribed wanted{node, component, condition.value(scene.specimen, node, b), condition.held,
                                first + static_cast<std::int32_t>(i)};
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

void prescribe(const std::vector<Condition>& conditions, std::vector<std::int64_t> springs, Scene& scene,
               FaultList& faults) {
  const std::vector<std::int64_t> anchors = anchors_of(conditions);
  springs.insert(springs.end(), anchors.begin(), anchors.end());
  if (leave_out_loose_pieces(scene, springs) == 0)
    faults.add(conditions.front().asked.line, conditions.front().asked.key, "matter joined to a held node",
               "none");
  for (const Condition& condition : conditions)
    if (!condition.held &&
        std::none_of(condition.nodes.begin(), condition.nodes.end(), [&](std::int64_t node) {
          return scene.specimen.is_node(scene.specimen.grid.node_at(node));
        }))
      faults.add(condition.asked.line, condition.asked.key + ".where",
                 "a node of a piece that something holds", "only nodes of pieces that nothing holds");
  prescribe_components(conditions, scene, faults);
  for (const Condition& condition : conditions)
    if (condition.drive) {
      scene.drives.push_back(*condition.drive);
      std::ranges::copy_if(
          condition.nodes, std::back_inserter(scene.drives.back().nodes),
          [&](std::int64_t node) { return scene.specimen.is_node(scene.specimen.grid.node_at(node)); });
    }
  for (const Condition& condition : conditions)
    if (condition.turn) {
      scene.turns.push_back(*condition.turn);
      std::ranges::copy_if(
          condition.nodes, std::back_inserter(scene.turns.back().nodes),
          [&](std::int64_t node) { return scene.specimen.is_node(scene.specimen.grid.node_at(node)); });
    }
}

} // namespace maille::reader
