#include "conditions/places_in_files.hpp"
#include "maille/base/vectors.hpp"
#include "read/reader.hpp"

#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::reader {

/// A corner of a box, or a centre: one quantity per axis of the scene, or three.
std::optional<Vec3> read_point(const toml::node& node, const std::string& path, int dimension,
                               const char* wanted, FaultList& faults) {
  const auto* list = node.as_array();
  const bool fits =
      list && !list->empty() && list->size() <= 3 &&
      (dimension == 0 || list->size() == static_cast<std::size_t>(dimension) || list->size() == 3);
  if (!fits) {
    faults.add(line_of(node), path, wanted, describe(node));
    return std::nullopt;
  }
  Vec3 point{};
  bool good = true;
  for (std::size_t a = 0; a < list->size(); ++a) {
    const auto value = read_quantity(*list->get(a), path, Dimension::length, faults);
    good = good && value;
    point[a] = value.value_or(0);
  }
  return good ? std::optional(point) : std::nullopt;
}

namespace {

constexpr std::array<const char*, 9> kinds{"box",    "sphere", "label", "image", "surface",
                                           "points", "any",    "all",   "not"};

/// Reads one `where`. Without a body only faults of its own form are found, and the region is empty.
class RegionReader {
public:
  /// @param wanted expected value, for faults of an invalid region
  RegionReader(int dimension, const Specimen* body, CoordinateFrame frame, std::string wanted,
               FaultList& faults)
      : dimension_(dimension), body_(body), frame_(frame), wanted_(std::move(wanted)), faults_(faults) {}

  std::optional<Region> read(const toml::node& node, const std::string& path) {
    if (const auto* text = node.as_string())
      return read_face(text->get(), node, path);
    const auto* values = node.as_table();
    if (!values) {
      faults_.add(line_of(node), path, wanted_, describe(node));
      return std::nullopt;
    }
    TableReader table(*values, path, faults_, "region");
    const auto n_kinds = std::ranges::count_if(kinds, [&](const char* kind) { return table.has(kind); });
    if (n_kinds != 1) {
      faults_.add(line_of(node), path, wanted_, n_kinds == 0 ? in_words(node) : "more than one of them");
      return std::nullopt;
    }
    auto region = read_table(table);
    table.finish();
    return region;
  }

private:
  static Region nothing() { return Region::numbered({}); }

  /// The value; on failure nothing and a fault of `key`.
  template<class T>
  std::optional<T> unless_fault(OrFault<T> result, TableReader& table, std::string_view key) {
    if (const auto* fault = std::get_if<RegionFault>(&result)) {
      table.fault(key, fault->expected, fault->found);
      return std::nullopt;
    }
    return std::move(std::get<T>(result));
  }

  /// What `read` makes of the file that a key names; nothing where that has faults.
  template<class Read>
  std::optional<Region> of_file(TableReader& table, std::string_view key, const Read& read) {
    try {
      return read();
    } catch (const InputError& error) {
      adopt(error, table.path_of(key), table.line_of_key(key), faults_);
      return std::nullopt;
    }
  }

  std::optional<Region> read_face(const std::string& name, const toml::node& node, const std::string& path) {
    const bool is_of_a_patient = is_direction(name) && !Region::face(name, 0);
    if (is_of_a_patient && name != "proximal" && name != "distal") {
      if (!body_)
        return nothing();
      const auto face = face_towards(name, *body_);
      if (const auto* fault = std::get_if<RegionFault>(&face)) {
        faults_.add(line_of(node), path, fault->expected, "\"" + name + "\", for " + fault->found);
        return std::nullopt;
      }
      return Region::face(std::get<std::string>(face), dimension_);
    }
    auto region = Region::face(name, dimension_);
    if (!region)
      faults_.add(line_of(node), path, wanted_, describe(node));
    return region;
  }

  std::optional<Region> read_table(TableReader& table) {
    if (table.has("box"))
      return read_box(table);
    if (table.has("sphere"))
      return read_sphere(table);
    if (table.has("label"))
      return read_label(table);
    if (table.has("image"))
      return read_mask(table);
    if (table.has("surface"))
      return read_surface(table);
    if (table.has("points"))
      return read_points(table);
    return read_joined(table);
  }

  /// Transformation from the object's frame to `frame`; the identity without a body; nothing and a fault if
  /// unknown.
  std::optional<Placement> placement(CoordinateFrame frame, TableReader& table, std::string_view key) {
    if (!body_)
      return Placement{};
    return unless_fault(placement_in(*body_, frame), table, key);
  }

  std::optional<double> read_length(TableReader& table, const char* key) {
    return table.require(key) ? table.number(key) : std::nullopt;
  }

  std::optional<Region> read_box(TableReader& table) {
    constexpr const char* wanted_corner = "the coordinates of two opposite corners";
    const toml::node* box = table.require("box", "two opposite corners");
    const auto* corners = box ? box->as_array() : nullptr;
    const auto frame = read_frame(table, frame_);
    if (!corners || corners->size() != 2) {
      table.fault("box", "two opposite corners");
      return std::nullopt;
    }
    // In a rotated world all three coordinates matter.
    const int n_axes = frame == CoordinateFrame::grid ? dimension_ : 3;
    const auto first = read_point(*corners->get(0), table.path_of("box"), n_axes, wanted_corner, faults_);
    const auto second = read_point(*corners->get(1), table.path_of("box"), n_axes, wanted_corner, faults_);
    if (!first || !second || !frame)
      return std::nullopt;
    if (frame == CoordinateFrame::grid)
      return Region::box(*first, *second);
    const auto placed = placement(*frame, table, "frame");
    return placed ? std::optional(Region::placed_box(*first, *second, *placed)) : std::nullopt;
  }

  std::optional<Region> read_sphere(TableReader& table) {
    auto sphere = table.open("sphere");
    const auto frame = read_frame(table, frame_);
    if (!sphere)
      return std::nullopt;
    const toml::node* at = sphere->require("centre");
    const int n_axes = frame == CoordinateFrame::grid ? dimension_ : 3;
    const auto centre =
        at ? read_point(*at, sphere->path_of("centre"), n_axes, "the coordinates of the middle", faults_)
           : std::nullopt;
    const auto radius = sphere->number("radius");
    sphere->finish();
    const auto placed = frame ? placement(*frame, table, "frame") : std::nullopt;
    if (!centre || !radius || !placed)
      return std::nullopt;
    return Region::sphere(point_in_object(*placed, *centre), *radius);
  }

  std::optional<Region> read_label(TableReader& table) {
    const auto label = table.whole("label");
    const auto touching = table.whole("touching");
    const auto end = table.text("end");
    std::optional<double> depth;
    if (end || table.has("depth"))
      depth = read_length(table, "depth");
    if (!table.has("end"))
      table.refuse("depth", "no such key without `end`");
    if (table.has("touching") && table.has("end"))
      table.fault("end", "either `touching` or `end` (both: all = [ ... ])", "both");
    if (end && !is_direction(*end)) {
      const std::string_view meant = nearest_spelling(
          *end, {"proximal", "distal", "superior", "inferior", "left", "right", "anterior", "posterior"});
      table.fault("end",
                  "proximal, distal, superior, inferior, left, right, anterior, posterior, or x-, x+ ... of "
                  "the grid",
                  fmt::format("\"{}\"{}{}{}", *end, meant.empty() ? "" : " (did you mean \"", meant,
                              meant.empty() ? "" : "\"?)"));
      return std::nullopt;
    }
    if (!label || (end && !depth) || (table.has("touching") && !touching))
      return std::nullopt;
    if (!body_)
      return nothing();
    auto cells = unless_fault(cells_of_label(*label, *body_), table, "label");
    if (!cells)
      return std::nullopt;
    if (end)
      return unless_fault(end_of_label(*cells, *end, *depth, *body_), table, "end");
    Region of_label = Region::of_cells(body_->grid, std::move(*cells));
    if (!touching)
      return of_label;
    auto other = neighbour(*touching, table);
    if (!other)
      return std::nullopt;
    // Nodes belong to both labels, cells and faces to one of them.
    std::vector<std::int64_t> both, mine = of_label.nodes(*body_), theirs = other->nodes(*body_);
    std::ranges::set_intersection(mine, theirs, std::back_inserter(both));
    if (both.empty()) {
      table.fault("touching", "a label with a node in common with " + std::to_string(*label),
                  std::to_string(*touching) + ", which nowhere touches it");
      return std::nullopt;
    }
    return Region::numbered(std::move(both));
  }

  /// A label of the body, or of the rest of its image, such as bone beside muscles.
  std::optional<Region> neighbour(std::int64_t label, TableReader& table) {
    auto cells = cells_of_label(label, *body_);
    if (auto* of_body = std::get_if<std::vector<std::int64_t>>(&cells))
      return Region::of_cells(body_->grid, std::move(*of_body));
    if (body_->image.empty())
      return unless_fault<Region>(std::get<RegionFault>(cells), table, "touching");
    const auto value = static_cast<float>(label);
    return mask_of(body_->image, {{value, value, 0}}, false, table, "touching");
  }

  std::optional<Region> mask_of(const std::filesystem::path& file, const std::vector<LabelRange>& ranges,
                                bool resample, TableReader& table, std::string_view key) {
    return of_file(table, key,
                   [&] { return unless_fault(region_of_mask(file, ranges, resample, *body_), table, key); });
  }

  std::optional<Region> read_mask(TableReader& table) {
    constexpr const char* wanted_value = "a grey value such as 17, or a range such as \"17..19\"";
    const auto file = read_file_name(table, "image");
    std::vector<LabelRange> ranges;
    bool good = true;
    if (const toml::node* value = table.find("value")) {
      std::optional<LabelRange> range;
      if (const auto number = value->value_exact<std::int64_t>(); number && is_label(*number))
        range = LabelRange{static_cast<float>(*number), static_cast<float>(*number), 0};
      else if (!number)
        range = parse_label(value->value_exact<std::string>().value_or(""));
      good = range.has_value();
      if (range)
        ranges.push_back(*range);
      else
        table.fault("value", wanted_value);
    }
    bool resample = false;
    table.read("resample", resample);
    if (!file || !good)
      return std::nullopt;
    return body_ ? mask_of(*file, ranges, resample, table, "image") : nothing();
  }

  /// Frame of a file's places: as the file states, as the scene states, or the world. A fault if they differ.
  std::optional<CoordinateFrame> frame_of_file(const std::optional<CoordinateFrame>& stated,
                                               bool must_be_known, TableReader& table, const char* key) {
    const auto asked = read_frame(table, CoordinateFrame::world);
    if (!asked)
      return std::nullopt;
    if (stated && table.has("frame") && *stated != *asked) {
      table.fault("frame", fmt::format("\"{}\", as the file states, or no such key",
                                       coordinate_frames[static_cast<std::size_t>(*stated)]));
      return std::nullopt;
    }
    if (!stated && must_be_known && !table.has("frame")) {
      table.fault(key, "a file that states its coordinate system, LPS or RAS, or the key `frame`",
                  "one that does not");
      return std::nullopt;
    }
    return stated ? *stated : *asked;
  }

  std::optional<Region> near(std::vector<Triangle> triangles, double within,
                             const std::optional<CoordinateFrame>& frame, TableReader& table,
                             const char* key) {
    const auto placed = frame ? placement(*frame, table, key) : std::nullopt;
    if (!placed)
      return std::nullopt;
    for (Triangle& triangle : triangles)
      for (Vec3& corner : triangle)
        corner = point_in_object(*placed, corner);
    return Region::numbered(nodes_near(triangles, within, *body_));
  }

  std::optional<Region> read_surface(TableReader& table) {
    const auto file = read_file_name(table, "surface");
    const auto within = read_length(table, "within");
    table.find("frame");
    const double metres = read_unit(table);
    if (!file || !within)
      return std::nullopt;
    return of_file(table, "surface", [&]() -> std::optional<Region> {
      SurfaceMesh mesh = read_surface_mesh(*file, metres);
      return body_ ? near(std::move(mesh.triangles), *within,
                          frame_of_file(mesh.frame, false, table, "surface"), table, "surface")
                   : nothing();
    });
  }

  std::optional<Region> read_points(TableReader& table) {
    const auto file = read_file_name(table, "points");
    const auto within = read_length(table, "within");
    table.find("frame");
    const auto name = table.text("name");
    if (!file || !within)
      return std::nullopt;
    return of_file(table, "points", [&]() -> std::optional<Region> {
      const Landmarks landmarks = read_landmarks(*file);
      std::vector<Triangle> points;
      for (std::size_t i = 0; i < landmarks.points.size(); ++i)
        if (!name || landmarks.names[i] == *name)
          points.push_back({landmarks.points[i], landmarks.points[i], landmarks.points[i]});
      if (points.empty()) {
        table.fault("name", fmt::format("a point of the file: {}", fmt::join(landmarks.names, ", ")),
                    "\"" + *name + "\"");
        return std::nullopt;
      }
      return body_ ? near(std::move(points), *within, frame_of_file(landmarks.frame, true, table, "points"),
                          table, "points")
                   : nothing();
    });
  }

  /// `any`, `all`: lists of regions; `not`: one.
  std::optional<Region> read_joined(TableReader& table) {
    if (const toml::node* inner = table.find("not")) {
      auto region = read(*inner, table.path_of("not"));
      return region ? std::optional(Region::outside(std::move(*region))) : std::nullopt;
    }
    const char* const key = table.has("any") ? "any" : "all";
    const toml::node& node = *table.find(key);
    const auto* list = node.as_array();
    if (!list || list->empty()) {
      table.fault(key, "a list of regions");
      return std::nullopt;
    }
    std::vector<Region> parts;
    for (std::size_t i = 0; i < list->size(); ++i)
      if (auto part = read(*list->get(i), fmt::format("{}[{}]", table.path_of(key), i + 1)))
        parts.push_back(std::move(*part));
    if (parts.size() < list->size())
      return std::nullopt;
    for (std::size_t i = 0; i < parts.size() && body_ && std::string_view(key) == "any"; ++i)
      if (parts[i].nodes(*body_).empty())
        faults_.add(table.line_of_key(key), fmt::format("{}[{}]", table.path_of(key), i + 1),
                    "a region with at least one node of the body in it", "none");
    return std::string_view(key) == "any" ? Region::any(std::move(parts)) : Region::all(std::move(parts));
  }

  int dimension_;
  const Specimen* body_;
  CoordinateFrame frame_;
  std::string wanted_;
  FaultList& faults_;
};

} // namespace

std::optional<CoordinateFrame> read_frame(TableReader& table, CoordinateFrame otherwise) {
  if (!table.has("frame"))
    return otherwise;
  const auto frame = table.word("frame");
  return frame ? std::optional(static_cast<CoordinateFrame>(*frame)) : std::nullopt;
}

Vec3 TableFrame::vector_in_object(const Vec3& vector) const {
  Placement turned = placement;
  turned.origin = {};
  return placement.direction == Placement{}.direction ? vector : point_in_object(turned, vector);
}

Turn TableFrame::in_object(Turn turn) const {
  if (frame == CoordinateFrame::grid)
    return turn;
  turn.axis = vector_in_object(turn.axis);
  turn.about = point_in_object(placement, turn.about);
  turn.angle = determinant(placement.direction) < 0 ? -turn.angle : turn.angle;
  return turn;
}

TableFrame read_table_frame(TableReader& table, int dimension, const Specimen* body) {
  TableFrame result;
  result.frame = read_frame(table, CoordinateFrame::grid).value_or(CoordinateFrame::grid);
  if (body)
    result.body_in_world = body->placement;
  if (result.frame == CoordinateFrame::grid)
    return result;
  if (dimension == 1 || dimension == 2) {
    table.fault("frame", "\"grid\", as the scene is not three-dimensional");
    return {};
  }
  if (!body)
    return result;
  const auto placement = placement_in(*body, result.frame);
  if (const auto* fault = std::get_if<RegionFault>(&placement)) {
    table.fault("frame", fault->expected, fault->found);
    return {};
  }
  result.placement = std::get<Placement>(placement);
  return result;
}

std::optional<Region> read_region(TableReader& table, int dimension, const Specimen* body,
                                  CoordinateFrame frame) {
  const toml::node* node = table.require("where");
  if (!node)
    return std::nullopt;
  return RegionReader(dimension, body, frame, table.missing("where"), table.faults())
      .read(*node, table.path_of("where"));
}

} // namespace maille::reader

namespace maille {

std::vector<std::int64_t> nodes_in(const Scene& scene, std::string_view where) {
  const std::string text(where);
  return nodes_in(scene,
                  KeyTable{parse_toml("where = " + (text.starts_with('{') ? text : "\"" + text + "\""), "")});
}

std::vector<std::int64_t> nodes_in(const Scene& scene, const KeyTable& keys) {
  FaultList faults("");
  faults.units = {1.0, 1.0};
  TableReader table(keys.keys, "", faults, "hold");
  const auto region = reader::read_region(table, scene.dimension(), &scene.specimen);
  faults.throw_if_any();
  return region ? region->nodes(scene.specimen) : std::vector<std::int64_t>{};
}

} // namespace maille
