#include "read/measures.hpp"

#include <algorithm>
#include <cctype>
#include <map>

namespace maille::reader {

namespace {

constexpr std::array<MeasureKind, 8> every_kind{
    MeasureKind::force,  MeasureKind::displacement, MeasureKind::strain, MeasureKind::stress,
    MeasureKind::length, MeasureKind::angle,        MeasureKind::volume, MeasureKind::energy};
constexpr const char* wanted_kind =
    "one of force, displacement, strain, stress, length, angle, volume, energy";

/// Words of `kind` in the order of figures: first for lengths, angles and volumes, then for tensors.
constexpr std::ptrdiff_t n_of_lengths = 3, n_of_strain = 12, n_of_stress = 12, first_of_stress = 6;

bool is_identifier(const std::string& name) {
  const auto is_letter = [](unsigned char c) { return std::isalpha(c) != 0 || c == '_'; };
  return !name.empty() && is_letter(static_cast<unsigned char>(name[0])) && name.size() <= 64 &&
         std::ranges::all_of(
             name, [&](unsigned char c) { return c < 128 && (is_letter(c) || std::isdigit(c) != 0); });
}

/// Reads one table.
class MeasureReader {
public:
  MeasureReader(TableReader& root, TableReader& table, const Scene& scene, bool has_body)
      : root_(root), table_(table), scene_(scene), has_body_(has_body),
        frame_(read_table_frame(table, scene.dimension(), has_body ? &scene.specimen : nullptr)),
        places_(scene, has_body, frame_) {}

  /// The measure; nothing if the table has no quantity.
  std::optional<Measure> read() {
    measure_.name = read_name();
    const auto kind = read_kind();
    if (!kind) {
      for (const char* key : {"component", "kind"})
        table_.find(key);
      return std::nullopt;
    }
    measure_.kind = *kind;
    const std::string key(to_string(*kind));
    const toml::node& node = *table_.find(key);
    const std::string path = table_.path_of(key);
    switch (*kind) {
    case MeasureKind::force:
      read_force(node, path);
      read_component();
      break;
    case MeasureKind::displacement:
    case MeasureKind::strain:
    case MeasureKind::stress:
      if (auto target = table_.open(key)) {
        places_.read_target(*target, measure_);
        target->finish();
      }
      if (*kind == MeasureKind::displacement)
        read_component();
      else
        read_figure(*kind == MeasureKind::stress ? first_of_stress : n_of_lengths,
                    *kind == MeasureKind::stress ? n_of_stress : n_of_strain, default_of_tensor());
      break;
    case MeasureKind::length:
      measure_.points = places_.points(node, path, 2, 1000, table_.faults());
      measure_.where = fmt::format("of a line through {} points", measure_.points.size());
      read_figure(0, n_of_lengths, MeasureFigure::value);
      if (has_body_ && !measure_.points.empty() &&
          std::ranges::all_of(measure_.points, [&](const MaterialPoint& point) {
            return point.place == measure_.points.front().place;
          }))
        table_.fault(key, "points that differ", "one point");
      break;
    case MeasureKind::angle:
      read_angle(node, path);
      break;
    case MeasureKind::volume:
    case MeasureKind::energy:
      places_.read_cells(node, path, false, measure_, table_.faults());
      read_figure(0, *kind == MeasureKind::volume ? n_of_lengths : 1, MeasureFigure::value);
      break;
    }
    refuse_other_keys();
    return measure_;
  }

private:
  std::string read_name() {
    table_.require("name");
    const auto name = table_.text("name");
    if (name && !is_identifier(*name))
      table_.fault("name", table_.missing("name"));
    return name.value_or("");
  }

  std::optional<MeasureKind> read_kind() {
    std::optional<MeasureKind> found;
    for (const MeasureKind kind : every_kind) {
      const std::string key(to_string(kind));
      if (!table_.has(key))
        continue;
      table_.find(key);
      if (found)
        table_.fault(key, "one quantity a [[measure]]", fmt::format("{} beside {}", key, to_string(*found)));
      else
        found = kind;
    }
    if (!found)
      table_.fault("", wanted_kind, "none of them");
    return found;
  }

  void read_force(const toml::node& node, const std::string& path) {
    constexpr const char* wanted =
        "\"hold[N]\" or \"move[N]\" with N from 1, { where = ... } or { section = { point, normal } }";
    if (const auto* text = node.as_string()) {
      read_condition(text->get(), path);
      return;
    }
    const auto* values = node.as_table();
    if (!values || values->contains("where") == values->contains("section")) {
      table_.faults().add(line_of(node), path, wanted, describe(node));
      return;
    }
    TableReader reader(*values, path, table_.faults(), "force");
    if (reader.has("where"))
      read_region_of_force(reader);
    else if (auto plane = reader.open("section"))
      places_.read_section(*plane, measure_);
    reader.finish();
  }

  /// `hold[2]`: the second [[hold]].
  void read_condition(const std::string& name, const std::string& path) {
    const auto count = [&](const char* key) {
      const toml::node* list = root_.has(key) ? root_.find(key) : nullptr;
      return list && list->as_array() ? list->as_array()->size() : std::size_t{0};
    };
    measure_.where = "on " + name;
    bool is_one = false;
    for (const char* key : {"hold", "move"})
      for (std::size_t i = 1; i <= count(key) && !is_one; ++i)
        is_one = name == fmt::format("{}[{}]", key, i);
    if (!is_one) {
      table_.faults().add(table_.line_of_key("force"), path,
                          fmt::format("\"hold[N]\" or \"move[N]\" of {} holds and {} moves, or a region",
                                      count("hold"), count("move")),
                          "\"" + name + "\"");
      return;
    }
    measure_.condition = -1; // a condition with a faulty region
    for (std::size_t i = 0; i < scene_.conditions.size(); ++i)
      if (scene_.conditions[i].name == name)
        measure_.condition = static_cast<std::int32_t>(i);
    if (*measure_.condition >= 0 && std::ranges::find(scene_.prescribed, *measure_.condition,
                                                      &Prescribed::condition) == scene_.prescribed.end())
      table_.faults().add(table_.line_of_key("force"), path, "a hold or a move with nodes of its own",
                          "\"" + name + "\", all of whose nodes others ask for before it");
  }

  void read_region_of_force(TableReader& reader) {
    const auto region =
        read_region(reader, scene_.dimension(), has_body_ ? &scene_.specimen : nullptr, frame_.frame);
    measure_.where = "on where = " + asked_where(reader).text;
    if (!region || !has_body_)
      return;
    measure_.nodes = region->nodes(scene_.specimen);
    std::vector<std::int64_t> bearing;
    for (const Prescribed& p : scene_.prescribed)
      bearing.push_back(p.node);
    region->share_nodes(scene_.specimen, bearing, measure_.nodes, measure_.cells);
    std::ranges::sort(measure_.nodes);
    if (!scene_.prescribed.empty() && std::ranges::none_of(scene_.prescribed, [&](const Prescribed& p) {
          return std::ranges::binary_search(measure_.nodes, p.node);
        }))
      reader.fault("where", "a region with held or moved nodes, on which forces act (or a section)",
                   asked_where(reader).text);
  }

  void read_angle(const toml::node& node, const std::string& path) {
    measure_.points = places_.points(node, path, 3, 4, table_.faults());
    const auto& p = measure_.points;
    measure_.where = p.size() == 4 ? "between two lines" : "at the middle one of three points";
    read_figure(0, n_of_lengths - 1, MeasureFigure::value);
    if (p.size() >= 3 && (p[0].place == p[1].place || p[p.size() - 2].place == p.back().place))
      table_.faults().add(line_of(node), path, "points that differ", "two that are one");
  }

  MeasureFigure default_of_tensor() const {
    if (scene_.has_fibres())
      return MeasureFigure::fibre;
    return measure_.kind == MeasureKind::stress ? MeasureFigure::von_mises : MeasureFigure::largest;
  }

  /// Reads one of `n` words of `kind`, starting at `first`.
  void read_figure(std::ptrdiff_t first, std::ptrdiff_t n, MeasureFigure otherwise) {
    const std::vector<std::string_view> words = table_.words("kind");
    const auto name = table_.choice("kind", {words.begin() + first, words.begin() + first + n});
    const auto place = std::ranges::find(words, name.value_or("")) - words.begin();
    const auto beyond = static_cast<std::ptrdiff_t>(MeasureFigure::stretch) - n_of_lengths;
    measure_.figure = name ? static_cast<MeasureFigure>(first > 0 ? beyond + place : place) : otherwise;
    if (measure_.figure == MeasureFigure::nominal ||
        (measure_.figure >= MeasureFigure::stretch && measure_.figure < MeasureFigure::fibre))
      if (scene_.strain != Strain::finite)
        table_.fault("kind", "strain = \"finite\" at the top of the scene", fmt::format("\"{}\"", *name));
    if (measure_.figure == MeasureFigure::fibre && has_body_ && table_.has("kind") && !scene_.has_fibres())
      table_.fault("kind", "a figure without fibres: all matter is isotropic", "\"fibre\"");
  }

  /// Reads `component`; default: the vector and its length.
  void read_component() {
    const toml::node* node = table_.find("component");
    if (!node)
      return;
    constexpr std::string_view letters = "xyz";
    const auto text = node->value<std::string>();
    if (text == "magnitude") {
      measure_.figure = MeasureFigure::magnitude;
    } else if (text && text->size() == 1 && letters.find(*text) != std::string_view::npos) {
      measure_.figure = MeasureFigure::along;
      measure_.direction[letters.find(*text)] = 1;
      measure_.direction = in_world(measure_.direction);
    } else if (text == "normal" && table_.has("force")) {
      measure_.figure = MeasureFigure::along;
      if (measure_.section)
        measure_.direction = to_world(scene_.specimen.placement, measure_.section->normal);
      else
        table_.fault("component", "\"normal\" of a section alone");
    } else if (node->is_array()) {
      measure_.figure = MeasureFigure::along;
      if (const auto unit = places_.direction(*node, table_.path_of("component"), table_.faults()))
        measure_.direction = in_world(*unit);
    } else {
      table_.fault("component",
                   "\"x\", \"y\", \"z\", \"magnitude\", \"normal\" of a section, or a direction");
    }
  }

  /// Transforms a direction from the table's frame to world axes, the axes of result vectors; frame = "grid"
  /// is the world's.
  Vec3 in_world(const Vec3& direction) const {
    return frame_.frame == CoordinateFrame::grid || !has_body_
               ? direction
               : to_world(scene_.specimen.placement, frame_.vector_in_object(direction));
  }

  void refuse_other_keys() {
    const bool has_component =
        measure_.kind == MeasureKind::force || measure_.kind == MeasureKind::displacement;
    const char* const other = has_component ? "kind" : "component";
    table_.refuse(other, fmt::format("no such key of a {}", to_string(measure_.kind)));
  }

  TableReader &root_, &table_;
  const Scene& scene_;
  bool has_body_;
  TableFrame frame_;
  MeasurePlaces places_;
  Measure measure_;
};

/// Checks that column names of results are unique. @param owner  measure of each column so far
void check_columns(const Measure& measure, TableReader& table, std::map<std::string, std::string>& owner) {
  if (!is_identifier(measure.name))
    return;
  std::vector<std::string> columns = measure.columns();
  if (columns.empty())
    columns.push_back(measure.name); // of its file
  columns.push_back(measure.name + "_error");
  for (const std::string& column : columns) {
    const auto [entry, is_new] = owner.emplace(column, measure.name);
    if (is_reserved_name(column))
      table.fault("name", "a name that no column of results has", "\"" + column + "\"");
    else if (!is_new)
      table.fault("name", "names whose columns differ, each once",
                  entry->second == measure.name
                      ? "\"" + measure.name + "\" again"
                      : fmt::format("`{}`, which is a column of \"{}\" too", column, entry->second));
    if (is_reserved_name(column) || !is_new)
      return;
  }
}

} // namespace

std::vector<Measure> read_measures(TableReader& root, const Scene& scene, bool has_body) {
  std::vector<Measure> measures;
  std::map<std::string, std::string> owner;
  // Memory limit for all places [bytes]: 32 million plus about sixty measures of the whole body.
  constexpr std::int64_t bytes_of_point = 100, always = 32'000'000, a_cell = 512;
  const std::int64_t most = always + (has_body ? a_cell * scene.specimen.grid.n_cells() : 0);
  std::int64_t bytes = 0;
  for_each_table(root, "measure", [&](TableReader& table) {
    if (auto measure = MeasureReader(root, table, scene, has_body).read()) {
      check_columns(*measure, table, owner);
      bytes += bytes_of_point * std::ssize(measure->points) +
               std::int64_t{8} * (std::ssize(measure->cells) + std::ssize(measure->nodes));
      if (bytes > most) {
        table.fault("", fmt::format("measures whose places take at most {} MB together", most / 1'000'000),
                    "more");
        table.faults().throw_if_any();
      }
      measures.push_back(std::move(*measure));
    }
  });
  return measures;
}

} // namespace maille::reader
