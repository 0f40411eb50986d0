#include "conditions/prescribe.hpp"
#include "image/label_cells.hpp"
#include "read/reader.hpp"

#include <algorithm>

namespace maille::reader {

namespace {

void read_gravity(TableReader& table, Scene& scene) {
  if (const auto g = read_vector(table, "gravity", Dimension::acceleration, scene.dimension()))
    for (std::size_t a = 0; a < 3; ++a)
      scene.gravity[a] += (*g)[a];
}

void read_traction(TableReader& table, Scene& scene, bool has_body) {
  const auto traction = read_vector(table, "traction", Dimension::pressure, scene.dimension());
  const auto region = read_region(table, scene.dimension());
  if (region && traction && has_body)
    add_traction(*region, *traction, asked_where(table), scene, table.faults());
}

/// Number of a material of the scene; nothing and a fault where it has none of that name.
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
    table.fault("material", "a material of the specimen: " + known, "\"" + *name + "\"");
  return std::nullopt;
}

/// `labels = 17`, `"17..19"`, or a list of them.
std::vector<LabelRange> read_label_ranges(TableReader& table, const Scene& scene) {
  constexpr const char* wanted = "a grey value such as 17, a range such as \"17..19\", or a list of them";
  const toml::node& node = *table.find("labels");
  if (!scene.specimen.shape.empty() && scene.specimen.shape != "image") {
    table.fault("labels", "no such key unless the specimen is an image", describe(node));
    return {};
  }
  std::vector<LabelRange> ranges;
  const auto take = [&](const toml::node& entry) {
    if (const auto number = entry.value_exact<std::int64_t>())
      ranges.push_back({static_cast<float>(*number), static_cast<float>(*number), 0});
    else if (const auto range = parse_label(entry.value_exact<std::string>().value_or("")))
      ranges.push_back(*range);
    else
      table.faults().add(line_of(entry), table.path_of("labels"), wanted, describe(entry));
  };
  const auto* list = node.as_array();
  if (!list)
    take(node);
  else if (list->empty())
    table.fault("labels", wanted, "an empty list");
  else
    for (const toml::node& entry : *list)
      take(entry);
  return ranges;
}

/// The cells of matter that the keys `where`, `material` and `labels` all select; each selects all where it
/// is absent.
std::vector<std::int64_t> read_cells(TableReader& table, const Scene& scene, const std::vector<float>& labels,
                                     bool has_body) {
  const std::size_t faults_before = table.faults().size();
  const auto region = table.has("where") ? read_region(table, scene.dimension()) : std::nullopt;
  const auto material = read_material_name(table, scene);
  const bool by_label = table.has("labels");
  const auto ranges = by_label ? read_label_ranges(table, scene) : std::vector<LabelRange>{};
  if (!has_body || table.faults().size() > faults_before)
    return {};
  auto cells = cells_in(region, scene.specimen, [&](std::int64_t cell) {
    return (!material || scene.specimen.material(cell) == *material) &&
           (!by_label || material_of(labels[static_cast<std::size_t>(cell)], ranges) != no_material);
  });
  if (cells.empty())
    table.fault(by_label ? "labels" : "where", wanted_cells,
                by_label             ? "none: " + in_words(*table.find("labels"))
                : table.has("where") ? "none: " + in_words(*table.find("where"))
                                     : "none");
  return cells;
}

void read_contraction(TableReader& table, Scene& scene, const std::vector<float>& labels, bool has_body) {
  const auto stress = table.quantity("contraction", Dimension::pressure);
  const auto cells = read_cells(table, scene, labels, has_body);
  if (!stress)
    return;
  if (*stress < 0) {
    table.fault("contraction", wanted_contraction, describe(*table.find("contraction")));
    return;
  }
  add_contraction(cells, *stress, scene);
}

} // namespace

bool asks_for_labels(const toml::table& root) {
  const auto* list = root["load"].as_array();
  return list && std::any_of(list->begin(), list->end(), [](const toml::node& load) {
           return load.is_table() && load.as_table()->contains("labels");
         });
}

void read_loads(TableReader& root, Scene& scene, const std::vector<float>& labels, bool has_body) {
  for_each_table(root, "load", [&](TableReader& table) {
    const int kinds = int{table.has("gravity")} + int{table.has("traction")} + int{table.has("contraction")};
    if (kinds != 1) {
      for (const char* key : {"gravity", "traction", "contraction", "where", "material", "labels"})
        table.find(key);
      table.faults().add(table.line(), table.path(),
                         "either traction (with where), gravity (without) or contraction",
                         kinds > 1 ? "more than one of them" : "none of them");
    } else if (table.has("gravity")) {
      read_gravity(table, scene);
    } else if (table.has("traction")) {
      read_traction(table, scene, has_body);
    } else {
      read_contraction(table, scene, labels, has_body);
    }
  });
}

} // namespace maille::reader
