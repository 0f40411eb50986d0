#include "builder/build_scene.hpp"

#include "maille/materials/material.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace maille {

using reader::Asked;
using reader::Region;

namespace {

bool is_finite(const Vec3& v) {
  return std::ranges::all_of(v, [](double c) { return std::isfinite(c); });
}

std::string words(const Where& where) {
  if (const auto* face = std::get_if<std::string>(&where))
    return "\"" + *face + "\"";
  if (const auto* box = std::get_if<BoxRegion>(&where))
    return "a box from " + in_words(box->first) + " to " + in_words(box->second) + " m";
  return fmt::format("a list of {} nodes", std::get<NodeList>(where).nodes.size());
}

} // namespace

/// By the reader of scene files; faults lose file and line.
SceneAndMeasures SceneBuilder::Assembly::of_keys() {
  const auto* labels = std::get_if<LabelBody>(&asked_.body_);
  if (!labels && !asked_.table_)
    add_fault("specimen", "an array of labels, whose scene the keys are of", "none");
  else if (labels)
    take(labels->faults);
  const std::filesystem::path file = asked_.folder_ / (asked_.name_ + ".toml");
  try {
    if (faults_.empty()) {
      const toml::table parsed = asked_.table_ ? toml::table{} : parse_toml(*asked_.keys_, file.string());
      SceneAndMeasures read = reader::scene_of(asked_.table_ ? asked_.table_->keys : parsed, file,
                                               labels ? &labels->image : nullptr);
      read.scene.name = asked_.name_;
      return read;
    }
  } catch (const InputError& error) {
    take(error.faults());
  }
  faults_.throw_if_any();
  return {};
}

SceneAndMeasures SceneBuilder::Assembly::scene_and_measures() {
  if (asked_.keys_ || asked_.table_)
    return of_keys();
  scene_.name = asked_.name_;
  scene_.title = asked_.title_.value_or(asked_.name_);
  has_body_ = make_body();
  scene_.materials = materials_.take();
  read_limits();
  read_relaxation();
  add_conditions();
  std::vector<Measure> asked_of_answers = measures();
  faults_.throw_if_any();
  return {std::move(scene_), std::move(asked_of_answers)};
}

// ---- settings ---------------------------------------------------------------------------------------------

void SceneBuilder::Assembly::read_limits() {
  scene_.limits = asked_.limits_;
  const LimitSettings& limits = scene_.limits;
  if (limits.from == LimitSource::given)
    for (const BrokenRule& rule : broken_rules(limits.given))
      add_fault("limits." + rule.key, rule.expected, rule.found);
  else if (limits.given != NeighbourLimits{})
    add_fault("limits.given", "no limits unless from = given", "some");
  if (limits.taut_scale && !(std::isfinite(*limits.taut_scale) && *limits.taut_scale > 0))
    add_fault("limits.taut_scale", "a stress > 0", fmt::format("{}", *limits.taut_scale));
  reader::check_limit_source(scene_, "limits.from", 0, faults_);
}

void SceneBuilder::Assembly::read_relaxation() {
  scene_.strain = asked_.strain_;
  scene_.relaxation = asked_.relaxation_;
  const RelaxationSettings& asked = scene_.relaxation;
  add_if_out_of_range("relaxation", "tolerance", asked.tolerance);
  add_if_out_of_range("relaxation", "sweeps", static_cast<double>(asked.sweeps));
  if (asked.increments != 0) // as many as needed
    add_if_out_of_range("relaxation", "increments", asked.increments);
}

// ---- holds, moves and loads -------------------------------------------------------------------------------

/// Converts node numbers from the given grid to the body's. Unlike a box, a list must contain body nodes
/// only.
std::optional<Region> SceneBuilder::Assembly::region_of(const NodeList& list, const Asked& asked) {
  if (!has_body_)
    return std::nullopt;
  const Specimen& body = scene_.specimen;
  std::vector<std::int64_t> nodes, beyond, bare;
  for (const std::int64_t number : list.nodes) {
    if (number < 0 || number >= whole_.n_nodes()) {
      beyond.push_back(number);
      continue;
    }
    Index3 at = whole_.node_at(number);
    for (std::size_t a = 0; a < 3; ++a)
      at[a] -= first_[a];
    if (body.grid.has_node(at) && body.is_node(at))
      nodes.push_back(body.grid.node(at));
    else
      bare.push_back(number);
  }
  const auto report = [&](const std::vector<std::int64_t>& wrong, const std::string& expected) {
    if (!wrong.empty())
      add_fault(
          asked.key, expected,
          fmt::format("{} other{}, the first {}", wrong.size(), wrong.size() == 1 ? "" : "s", wrong[0]));
  };
  report(beyond, fmt::format("node numbers from 0 to {}", whole_.n_nodes() - 1));
  report(bare, "nodes of the body, each at a corner of a cell of matter");
  return beyond.empty() && bare.empty() ? std::optional(Region::numbered(std::move(nodes))) : std::nullopt;
}

std::optional<Region> SceneBuilder::Assembly::region_of(const Where& where, const Asked& asked) {
  if (const auto* list = std::get_if<NodeList>(&where))
    return region_of(*list, asked);
  if (const auto* box = std::get_if<BoxRegion>(&where)) {
    if (is_finite(box->first) && is_finite(box->second))
      return Region::box(box->first, box->second);
    add_fault(asked.key, "finite coordinates [m]", asked.text);
    return std::nullopt;
  }
  const std::string& text = std::get<std::string>(where);
  if (text.starts_with('{') || (reader::is_direction(text) && !Region::face(text, 0)))
    return region_in_words(text, asked);
  const auto region = Region::face(text, has_body_ ? scene_.dimension() : 0);
  if (!region)
    add_fault(asked.key, "a face (\"x-\", \"x+\", ...) or a region of scene files in TOML", asked.text);
  return region;
}

/// By the reader of scene files; faults lose their lines.
std::optional<Region> SceneBuilder::Assembly::region_in_words(const std::string& text, const Asked& asked) {
  FaultList faults("");
  faults.units = {1.0, 1.0};
  std::optional<Region> region;
  try {
    const toml::table document = parse_toml("where = " + (text[0] == '{' ? text : "\"" + text + "\""), "");
    TableReader table(document, asked.key.substr(0, asked.key.rfind('.')), faults, "hold");
    region = reader::read_region(table, has_body_ ? scene_.dimension() : 0,
                                 has_body_ ? &scene_.specimen : nullptr);
    faults.throw_if_any();
  } catch (const InputError& error) {
    for (const Fault& fault : error.faults())
      add_fault(fault.key.empty() ? asked.key : fault.key, fault.expected, fault.found);
    region.reset();
  }
  return region;
}

bool SceneBuilder::Assembly::is_vector(const Vec3& v, const char* what, const Asked& asked) {
  if (!is_finite(v)) {
    add_fault(asked.key, fmt::format("three finite numbers, {}", what), in_words(v));
    return false;
  }
  const std::size_t n = reader::n_axes(has_body_ ? scene_.dimension() : 0);
  bool is_good = true;
  for (std::size_t a = n; a < 3; ++a)
    if (v[a] != 0) {
      add_fault(asked.key, reader::wanted_zero(a, scene_.dimension()), in_words(v));
      is_good = false;
    }
  return is_good;
}

void SceneBuilder::Assembly::read_condition(const Condition& condition, bool held, int number,
                                            std::vector<reader::Condition>& conditions) {
  const Asked asked{fmt::format("{}[{}]", held ? "hold" : "move", number), 0, ""};
  const Asked where{asked.key + ".where", 0, words(condition.where)};
  const int dimension = has_body_ ? scene_.dimension() : 0;
  const auto region = region_of(condition.where, where);
  reader::Condition read;
  read.held = held;
  read.asked = asked;
  read.by = condition.by;
  read.axes = condition.axes
                  ? reader::axes_named(*condition.axes, dimension,
                                       {asked.key + ".axes", 0, "\"" + *condition.axes + "\""}, faults_)
                  : reader::all_axes(dimension);
  const bool is_good = held || is_vector(condition.by, "a displacement [m]", {asked.key + ".by", 0, ""});
  if (region && is_good && has_body_)
    add_condition(std::move(read), *region, where, false, scene_.specimen, conditions, faults_);
}

void SceneBuilder::Assembly::add_conditions() {
  std::vector<reader::Condition> conditions;
  int number = 0;
  for (const Condition& hold : asked_.holds_)
    read_condition(hold, true, ++number, conditions);
  number = 0;
  for (const Condition& move : asked_.moves_)
    read_condition(move, false, ++number, conditions);
  if (has_body_ && asked_.holds_.empty() && asked_.moves_.empty())
    reader::report_loose_body(faults_);
  // Lists refer to the given body: nodes of a left-out piece are no error.
  std::vector<std::optional<Region>> regions;
  for (const Load& load : asked_.loads_)
    regions.push_back(load.where ? region_of(*load.where, {fmt::format("load[{}].where", regions.size() + 1),
                                                           0, words(*load.where)})
                                 : std::nullopt);
  if (!conditions.empty())
    reader::prescribe(conditions, {}, scene_, faults_);
  for (std::size_t i = 0; i < regions.size(); ++i)
    add_load(asked_.loads_[i], static_cast<int>(i) + 1, regions[i]);
}

void SceneBuilder::Assembly::add_load(const Load& load, int number, const std::optional<Region>& region) {
  const Asked asked{fmt::format("load[{}]", number), 0, ""};
  const Asked where{asked.key + ".where", 0, load.where ? words(*load.where) : ""};
  const bool has_place = has_body_ && (region || !load.where);
  switch (load.kind) {
  case LoadKind::traction:
    if (is_vector(load.vector, "a traction [Pa]", asked.at("traction")) && has_place)
      reader::add_traction(*region, load.vector, where, scene_, faults_);
    return;
  case LoadKind::force:
    if (is_vector(load.vector, "a force [N]", asked.at("force")) && has_place)
      reader::add_force(*region, load.vector, where, scene_, faults_);
    return;
  case LoadKind::gravity:
    if (is_vector(load.vector, "an acceleration [m/s^2]", asked.at("gravity")))
      for (std::size_t a = 0; a < 3; ++a)
        scene_.gravity[a] += load.vector[a];
    return;
  case LoadKind::contraction:
    const double stress = load.vector[0];
    if (const auto wanted = wanted_in_range("load", "contraction", stress))
      add_fault(asked.key + ".contraction", *wanted, fmt::format("{}", stress));
    else if (has_place) {
      const auto cells = reader::cells_in(region, scene_.specimen, [](std::int64_t) { return true; });
      if (cells.empty())
        add_fault(where.key, reader::wanted_cells, "none: " + where.text);
      reader::add_contraction(cells, stress, scene_);
    }
  }
}

Scene SceneBuilder::build() const {
  return Assembly(*this).scene_and_measures().scene;
}

} // namespace maille
