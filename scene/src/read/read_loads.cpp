#include "conditions/prescribe.hpp"
#include "read/reader.hpp"
#include "voxels/label_cells.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maille::reader {

namespace {

void read_gravity(TableReader& table, const TableFrame& frame, Scene& scene) {
  if (const auto given = read_vector(table, "gravity", scene.dimension())) {
    const Vec3 g = frame.vector_in_object(*given);
    for (std::size_t a = 0; a < 3; ++a)
      scene.gravity[a] += g[a];
  }
}

/// `foundation = "10 kPa/mm"` with `along = "normal"` or `axes`; nothing if absent or faulty.
std::optional<Foundation> read_foundation(TableReader& table, const TableFrame& frame, int dimension) {
  if (!table.has("foundation"))
    return std::nullopt;
  Foundation foundation;
  foundation.axes = all_axes(dimension);
  const auto stiffness = table.number("foundation");
  foundation.is_normal = table.choice("along") == "normal";
  if (const auto axes = table.text("axes")) {
    foundation.axes =
        axes_named(*axes, dimension, {table.path_of("axes"), table.line_of_key("axes"), "\"" + *axes + "\""},
                   table.faults());
    if (table.has("along") || frame.frame != CoordinateFrame::grid)
      table.fault("axes", "no `along` and no `frame` with it: single axes are those of the grid", *axes);
  }
  if (!stiffness)
    return std::nullopt;
  foundation.stiffness = *stiffness;
  return foundation;
}

/// `traction`, `force`, `pressure` or `foundation` on the outer faces in `where`.
void read_surface_load(TableReader& table, const TableFrame& frame, Scene& scene, bool has_body) {
  const int dimension = scene.dimension();
  const auto traction = table.has("traction") ? read_vector(table, "traction", dimension) : std::nullopt;
  const auto force = table.has("force") ? read_vector(table, "force", dimension) : std::nullopt;
  const auto pressure = table.number("pressure");
  const auto foundation = read_foundation(table, frame, dimension);
  const auto region = read_region(table, dimension, has_body ? &scene.specimen : nullptr, frame.frame);
  if (!region || !has_body)
    return;
  if (traction)
    add_traction(*region, frame.vector_in_object(*traction), asked_where(table), scene, table.faults());
  if (force)
    add_force(*region, frame.vector_in_object(*force), asked_where(table), scene, table.faults());
  if (foundation)
    add_foundation(*region, *foundation, asked_where(table), scene, table.faults());
  if (pressure)
    add_pressure(*region, *pressure, asked_where(table), scene, table.faults());
}

/// Number of a material of the scene; nothing and a fault if it has no such material.
std::optional<std::uint8_t> read_material_name(TableReader& table, const Scene& scene) {
  const auto name = table.text("material");
  if (!name)
    return std::nullopt;
  std::string known;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    if (scene.materials[i].name == *name)
      return static_cast<std::uint8_t>(i);
    known += (i > 0 ? ", \"" : "\"") + scene.materials[i].name + "\"";
  }
  if (!scene.materials.empty())
    table.fault("material", "a material of the specimen: " + known);
  return std::nullopt;
}

/// The intersection of the cells of matter selected by `where`, `material` and `labels`; absent keys select
/// all.
std::vector<std::int64_t> read_cells(TableReader& table, const TableFrame& frame, const Scene& scene,
                                     const std::vector<float>& labels, bool has_body) {
  const std::size_t faults_before = table.faults().size();
  const auto region = table.has("where") ? read_region(table, scene.dimension(),
                                                       has_body ? &scene.specimen : nullptr, frame.frame)
                                         : std::nullopt;
  const auto material = read_material_name(table, scene);
  const bool by_label = table.has("labels");
  if (by_label && !scene.specimen.shape.empty() && scene.specimen.shape != "image")
    table.fault("labels", "no such key unless the specimen is an image");
  const auto ranges = read_label_ranges(table);
  if (!has_body || table.faults().size() > faults_before)
    return {};
  auto cells = cells_in(region, scene.specimen, [&](std::int64_t cell) {
    return (!material || scene.specimen.material(cell) == *material) &&
           (!by_label || material_of(labels[cell], ranges) != no_material);
  });
  if (by_label)
    check_labels_exist(
        ranges, scene.specimen, [&](std::int64_t cell) { return labels[cell]; }, table.line_of_key("labels"),
        table.path_of("labels"), table.faults());
  if (cells.empty() && table.faults().size() == faults_before)
    table.fault(by_label ? "labels" : "where", wanted_cells,
                by_label             ? "none: " + in_words(*table.find("labels"))
                : table.has("where") ? "none: " + in_words(*table.find("where"))
                                     : "none");
  return cells;
}

void read_contraction(TableReader& table, const TableFrame& frame, Scene& scene,
                      const std::vector<float>& labels, bool has_body) {
  const auto stress = table.number("contraction");
  const auto cells = read_cells(table, frame, scene, labels, has_body);
  if (!stress)
    return;
  const auto course = read_course(table);
  if (course && std::ranges::any_of(course->points, [](const auto& point) { return point[1] < 0; }))
    table.fault("course", "values >= 0: fibres pull");
  add_contraction(cells, *stress * (course ? course->at(1) : 1), scene);
  if (course && !cells.empty())
    scene.timed.push_back({cells, *stress, *course});
}

} // namespace

std::vector<LabelRange> read_label_ranges(TableReader& table) {
  std::vector<LabelRange> ranges;
  const auto take = [&](const toml::node& entry) {
    if (const auto number = entry.value_exact<std::int64_t>())
      ranges.push_back({static_cast<float>(*number), static_cast<float>(*number), 0});
    else if (const auto range = parse_label(entry.value_exact<std::string>().value_or("")))
      ranges.push_back(*range);
    else
      table.faults().add(line_of(entry), table.path_of("labels"),
                         "a grey value such as 17, a range such as \"17..19\", or a list of them",
                         entry.is_array() && entry.as_array()->empty() ? "an empty list" : describe(entry));
  };
  const toml::node* node = table.find("labels");
  const auto* list = node ? node->as_array() : nullptr;
  if (list && !list->empty())
    for (const toml::node& entry : *list)
      take(entry);
  else if (node)
    take(*node);
  return ranges;
}

bool asks_for_labels(const toml::table& root) {
  const auto* list = root["load"].as_array();
  return list && std::any_of(list->begin(), list->end(), [](const toml::node& load) {
           return load.is_table() && load.as_table()->contains("labels");
         });
}

std::vector<std::int64_t> nodes_of_foundations(const toml::table& root, const Scene& scene,
                                               const FaultList& faults) {
  std::vector<std::int64_t> nodes;
  const auto* list = root["load"].as_array();
  if (!list || !list->is_array_of_tables())
    return nodes;
  FaultList told_later(faults.file()); // reported by read_loads
  told_later.units = faults.units;
  for (const toml::node& load : *list) {
    if (!load.as_table()->contains("foundation") || !load.as_table()->contains("where"))
      continue;
    TableReader table(*load.as_table(), "load", told_later, "load");
    const TableFrame frame = read_table_frame(table, scene.dimension(), &scene.specimen);
    if (const auto region = read_region(table, scene.dimension(), &scene.specimen, frame.frame))
      for (const FaceLoad& face : region->faces(scene.specimen))
        for (int corner = 0; corner < scene.specimen.grid.corners_per_cell(); ++corner)
          nodes.push_back(scene.specimen.grid.corner(scene.specimen.grid.cell_at(face.cell), corner));
  }
  return nodes;
}

void read_loads(TableReader& root, Scene& scene, const std::vector<float>& labels, bool has_body) {
  constexpr std::array<const char*, 6> kinds{"traction",   "force",   "pressure",
                                             "foundation", "gravity", "contraction"};
  for_each_table(root, "load", [&](TableReader& table) {
    const auto n_kinds = std::ranges::count_if(kinds, [&](const char* kind) { return table.has(kind); });
    if (n_kinds != 1) {
      for (const char* key : {"gravity", "traction", "force", "pressure", "contraction", "where", "material",
                              "labels", "frame", "foundation", "along", "axes", "course"})
        table.find(key);
      table.faults().add(table.line(), table.path(),
                         "either traction, force, pressure or foundation (with where), gravity (without) or "
                         "contraction",
                         n_kinds > 1 ? "more than one of them" : "none of them");
      return;
    }
    const TableFrame frame = read_table_frame(table, scene.dimension(), has_body ? &scene.specimen : nullptr);
    if (table.has("gravity"))
      read_gravity(table, frame, scene);
    else if (table.has("contraction"))
      read_contraction(table, frame, scene, labels, has_body);
    else
      read_surface_load(table, frame, scene, has_body);
    const toml::table* specimen = root.has("specimen") ? root.find("specimen")->as_table() : nullptr;
    if (specimen && table.has("contraction") && lacks_fibre(*specimen))
      add_lack_of_fibre(table.line(), table.path() + ", a contraction", table.faults());
    if (specimen && table.has("gravity") && specimen->at_path("stiffness.law"))
      scene.left_out.push_back({0, table.path() +
                                       ": gravity takes the materials' `density`, not the densities "
                                       "of the image that `stiffness` reads"});
    if (table.has("gravity") && scene.gravity == Vec3{0, 0, 0})
      scene.left_out.push_back({0, table.path() + " is zero: it weighs nothing"});
  });
}

} // namespace maille::reader
