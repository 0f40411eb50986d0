#include "conditions/region.hpp"
#include "measure/section.hpp"
#include "read/measures.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace maille::reader {

namespace {

constexpr const char* wanted_cells_of =
    "\"body\", or one of { label }, { material }, { where }, { sphere = { centre, radius } }";

std::string in_words_of(const Vec3& x) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", x[0], x[1], x[2]);
}

} // namespace

std::optional<Vec3> MeasurePlaces::place(const toml::node& node, const std::string& path,
                                         FaultList& faults) const {
  const auto* list = node.as_array();
  const std::size_t n = n_axes(scene_.dimension());
  const bool any_length = scene_.dimension() == 0 && list && !list->empty() && list->size() <= 3;
  if (!list || (list->size() != n && list->size() != 3 && !any_length)) {
    faults.add(line_of(node), path, fmt::format("a point: {} lengths", n), describe(node));
    return std::nullopt;
  }
  Vec3 x{};
  bool good = true;
  for (std::size_t a = 0; a < list->size(); ++a) {
    const auto value = read_quantity(*list->get(a), path, Dimension::length, faults);
    good = good && value;
    if (a < n || any_length)
      x[a] = value.value_or(0);
    else if (value && *value != 0) {
      faults.add(line_of(node), path, fmt::format("a point of {} lengths, or 0 beyond them", n),
                 describe(node));
      good = false;
    }
  }
  if (frame_.frame != CoordinateFrame::grid)
    x = point_in_object(frame_.placement, x);
  return good ? std::optional(x) : std::nullopt;
}

std::vector<Vec3> MeasurePlaces::places(const toml::node& node, const std::string& path, std::size_t least,
                                        std::size_t most, FaultList& faults) const {
  const auto* list = node.as_array();
  if (!list || list->size() < least || list->size() > most) {
    faults.add(line_of(node), path,
               least == most ? fmt::format("{} points", least)
                             : fmt::format("a list of {} to {} points", least, most),
               describe(node));
    return {};
  }
  std::vector<Vec3> all;
  for (const toml::node& entry : *list)
    if (const auto x = place(entry, path, faults))
      all.push_back(*x);
  if (all.size() != list->size())
    return {};
  return all;
}

/// Bounding box of the matter, for messages: in the frame of the places.
std::string MeasurePlaces::reach() const {
  const Specimen& body = scene_.specimen;
  if (frame_.frame != CoordinateFrame::grid)
    return "; " + reach_in_words(body);
  const Index3 last{body.grid.nodes()[0] - 1, body.grid.nodes()[1] - 1, body.grid.nodes()[2] - 1};
  return fmt::format(", which is within a box from {} to {}", in_words_of(body.position({0, 0, 0})),
                     in_words_of(body.position(last)));
}

std::vector<MaterialPoint> MeasurePlaces::points(const toml::node& node, const std::string& path,
                                                 std::size_t least, std::size_t most,
                                                 FaultList& faults) const {
  std::vector<MaterialPoint> all;
  for (const Vec3& x : places(node, path, least, most, faults)) {
    if (!has_body_)
      continue;
    all.push_back(located(scene_.specimen, x));
    if (all.back().cells.empty())
      faults.add(line_of(node), path, "points of the matter" + reach(), in_words_of(x));
  }
  return all;
}

void MeasurePlaces::read_line(TableReader& table, Measure& measure) const {
  const auto n = table.whole("points").value_or(2);
  const toml::node& node = *table.find("along");
  const auto ends = places(node, table.path_of("along"), 2, 2, table.faults());
  measure.is_line = true;
  measure.where = "along a line of " + std::to_string(n) + " points";
  if (!has_body_ || ends.empty())
    return;
  for (std::int64_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) / static_cast<double>(n - 1);
    Vec3 x{};
    for (std::size_t a = 0; a < 3; ++a)
      x[a] = (1 - t) * ends[0][a] + t * ends[1][a];
    measure.points.push_back(located(scene_.specimen, x));
  }
  if (std::ranges::all_of(measure.points, [](const MaterialPoint& point) { return point.cells.empty(); }))
    table.fault("along", "a line through the matter" + reach(),
                fmt::format("{} to {}", in_words_of(ends[0]), in_words_of(ends[1])));
}

void MeasurePlaces::read_target(TableReader& table, Measure& measure) const {
  constexpr const char* wanted = "one of at = [..], along = [[..], [..]], mean = ...";
  int n = 0;
  for (const char* key : {"at", "along", "mean"})
    n += table.has(key) ? 1 : 0;
  if (n != 1) {
    for (const char* key : {"at", "along", "mean", "points"})
      table.find(key);
    table.fault("", wanted, n == 0 ? "none of them" : "several");
    return;
  }
  if (table.has("along")) {
    read_line(table, measure);
    return;
  }
  table.refuse("points", "no such key without along");
  if (const toml::node* node = table.find("at")) {
    measure.where = "at a point";
    if (const auto x = place(*node, table.path_of("at"), table.faults()); x && has_body_) {
      measure.where = "at " + in_words_of(*x);
      measure.points.push_back(located(scene_.specimen, *x));
      if (measure.points.back().cells.empty())
        table.fault("at", "a point of the matter" + reach(), in_words_of(*x));
    }
  } else {
    read_cells(*table.find("mean"), table.path_of("mean"), measure.kind == MeasureKind::displacement, measure,
               table.faults());
    measure.where = ", mean" + (measure.where.starts_with("of") ? " " + measure.where : measure.where);
  }
}

template<class Counts>
void MeasurePlaces::take_cells(Measure& measure, Counts&& counts) const {
  if (has_body_)
    measure.cells = reader::cells_in(std::nullopt, scene_.specimen, counts);
}

void MeasurePlaces::read_sphere(TableReader& table, Measure& measure) const {
  const toml::node* centre = table.require("centre");
  const auto radius = table.number("radius");
  const auto middle = centre ? place(*centre, table.path_of("centre"), table.faults()) : std::nullopt;
  table.finish();
  if (!middle || !radius || !has_body_)
    return;
  const Specimen& body = scene_.specimen;
  const double reach = *radius + reader::place_tolerance(body);
  take_cells(measure, [&](std::int64_t cell) {
    const Vec3 x = body.position(body.grid.cell_at(cell));
    double square = 0;
    for (int a = 0; a < scene_.dimension(); ++a)
      square += std::pow(x[a] + body.grid.spacing()[a] / 2 - (*middle)[a], 2);
    return square <= reach * reach;
  });
  if (measure.cells.empty())
    table.fault("", "a sphere with the middle of at least one cell of matter in it",
                fmt::format("none around {}", in_words_of(*middle)));
}

void MeasurePlaces::read_cells(const toml::node& node, const std::string& path, bool takes_nodes,
                               Measure& measure, FaultList& faults) const {
  if (node.value<std::string>() == "body") {
    measure.where = "of the body";
    take_cells(measure, [](std::int64_t) { return true; });
    return;
  }
  const auto* values = node.as_table();
  constexpr std::array<const char*, 4> keys{"label", "material", "where", "sphere"};
  if (!values || std::ranges::count_if(keys, [&](const char* key) { return values->contains(key); }) != 1) {
    faults.add(line_of(node), path, wanted_cells_of, describe(node));
    return;
  }
  const Specimen& body = scene_.specimen;
  TableReader table(*values, path, faults, "part");
  if (const auto label = table.whole("label")) {
    measure.where = fmt::format("of label {}", *label);
    if (has_body_ && body.label.empty())
      table.fault("label", "a body that is read from an image of labels", "one without labels");
    else
      take_cells(measure, [&](std::int64_t cell) { return body.label[cell] == *label; });
    if (has_body_ && !body.label.empty() && measure.cells.empty()) {
      std::set<std::int32_t> there(body.label.begin(), body.label.end());
      there.erase(0);
      table.fault("label", fmt::format("a label with voxels in the body: {}", fmt::join(there, ", ")),
                  fmt::format("{}, which has none", *label));
    }
  } else if (const auto material = table.text("material")) {
    measure.where = "of " + *material;
    take_cells(measure,
               [&](std::int64_t cell) { return scene_.materials[body.material(cell)].name == *material; });
    if (has_body_ && measure.cells.empty()) {
      std::vector<std::string> names;
      for (const Material& one : scene_.materials)
        names.push_back(one.name);
      table.fault("material", fmt::format("a material of the body: {}", fmt::join(names, ", ")),
                  "\"" + *material + "\"");
    }
  } else if (table.has("where")) {
    const auto region = read_region(table, scene_.dimension(), has_body_ ? &body : nullptr, frame_.frame);
    measure.where = "of where = " + asked_where(table).text;
    if (region && has_body_) {
      measure.cells = cells_in(region, body, [](std::int64_t) { return true; });
      if (measure.cells.empty() && takes_nodes)
        measure.nodes = region->nodes(body);
      if (measure.cells.empty() && measure.nodes.empty())
        table.fault("where",
                    takes_nodes ? "a region with at least one node of the body in it"
                                : "a region with at least one whole cell of matter in it",
                    asked_where(table).text);
    }
    std::ranges::sort(measure.nodes);
  } else if (auto sphere = table.open("sphere")) {
    measure.where = "of a sphere";
    read_sphere(*sphere, measure);
  }
  table.finish();
}

std::optional<Vec3> MeasurePlaces::direction(const toml::node& node, const std::string& path,
                                             FaultList& faults) const {
  const std::size_t n = n_axes(scene_.dimension());
  const auto unit = direction_of(node, n);
  if (!unit)
    faults.add(line_of(node), path, fmt::format("a direction: {} numbers, not all 0", n), describe(node));
  return unit;
}

void MeasurePlaces::read_section(TableReader& table, Measure& measure) const {
  const toml::node* point = table.require("point");
  const toml::node* normal = table.require("normal");
  std::optional<Vec3> x;
  if (point)
    x = place(*point, table.path_of("point"), table.faults());
  const auto n = normal ? direction(*normal, table.path_of("normal"), table.faults()) : std::nullopt;
  table.finish();
  const std::size_t axes = n_axes(scene_.dimension());
  if (n && has_body_ &&
      std::any_of(n->begin() + static_cast<std::ptrdiff_t>(axes), n->end(),
                  [](double part) { return part != 0; })) {
    table.fault("normal", fmt::format("a direction within the {} axes of the scene", axes),
                "one out of them");
    return;
  }
  if (!x || !n)
    return;
  const Vec3 at = x.value_or(Vec3{});
  measure.section = SectionPlane{at, frame_.vector_in_object(*n)};
  measure.where = fmt::format("across the plane through {}", in_words_of(at));
  if (!has_body_)
    return;
  const Specimen& body = scene_.specimen;
  const BeyondPlane beyond(body, *measure.section);
  bool is_beyond = false, is_before = false;
  for (std::int64_t node = 0; node < body.grid.n_nodes() && !(is_beyond && is_before); ++node)
    if (body.is_node(body.grid.node_at(node))) {
      const double distance = beyond.distance(node);
      is_beyond = is_beyond || distance > 0;
      is_before = is_before || distance < 0;
    }
  if (!is_beyond || !is_before)
    table.fault("", "a plane with matter on both sides of it",
                fmt::format("all of it {}", is_beyond ? "beyond" : "before it, against the normal"));
}

} // namespace maille::reader
