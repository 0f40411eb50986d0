/// Forces, and strain, stress and energy of every label, as tables of a page.

#include "page_parts.hpp"
#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// Rows of the results that have something to say.
std::vector<const PageData*> with_mechanics(const std::vector<PageData>& rows) {
  std::vector<const PageData*> some;
  for (const PageData& row : rows)
    if (at(row, "mechanics").is_object())
      some.push_back(&row);
  return some;
}

/// Labels where the body has some, else materials, and the whole body where those are several.
std::vector<PageData> parts_of(const PageData& mechanics) {
  std::vector<PageData> parts;
  for (const char* list : {"labels", "materials"})
    if (parts.empty())
      for (const PageData& part : at(mechanics, list))
        parts.push_back(part);
  if (parts.size() != 1 && at(mechanics, "body").is_object())
    parts.push_back(at(mechanics, "body"));
  return parts;
}

std::string name_of(const PageData& part) {
  const PageData label = at(part, "label"), material = at(part, "material");
  if (label.is_number())
    return fmt::format("{} {}", plain(label), material.is_string() ? plain(material) : "");
  return material.is_string() && !plain(material).empty() ? plain(material) : "whole body";
}

std::string in_cubic_metres(double volume, int dimension) {
  const double scale = std::pow(1e3, dimension); // mm
  return fmt::format("{:.4g} {}", volume * scale, dimension == 3 ? "mm³" : dimension == 2 ? "mm²" : "mm");
}

std::string strain_in_words(double strain) {
  return fmt::format("{:.3g} %", 100 * strain);
}

constexpr double rounding = 1e-6; ///< beside the largest figure of its kind
double without_rounding(double value, double largest) {
  return std::abs(value) < rounding * largest ? 0 : value;
}

/// The largest of a part's strains, or of its stresses.
double largest_of(const PageData& part, std::string_view kind) {
  double largest = 0;
  for (const char* key :
       {"fibre_strain", "largest_strain", "smallest_strain", "fibre_stress", "von_mises", "pressure"})
    if (std::string_view(key).ends_with("strain") == (kind == "strain"))
      for (const char* figure : {"min", "max"})
        if (const PageData value = at(part, key, figure); value.is_number())
          largest = std::max(largest, std::abs(value.get<double>()));
  return largest;
}

/// The mean, sorted by it, and the middle 90 %.
PageData spread_cell(const PageData& spread, std::string (*words)(double), double largest) {
  const PageData mean = at(spread, "mean"), low = at(spread, "p5"), high = at(spread, "p95");
  if (!mean.is_number())
    return number_cell("–", nullptr);
  const auto shown = [&](const PageData& value) {
    return words(without_rounding(value.get<double>(), largest));
  };
  std::string text = shown(mean);
  if (low.is_number() && high.is_number())
    text += fmt::format(" ({} to {})", shown(low), shown(high));
  return number_cell(std::move(text), mean);
}

struct SpreadColumn {
  const char *key, *name, *why;
  std::string (*words)(double);
};
constexpr const char* middle = "mean over the volume, and what 5 % and 95 % of it do not exceed";

std::vector<SpreadColumn> spread_columns(const std::vector<const PageData*>& rows) {
  const SpreadColumn all[] = {{"fibre_strain", "fibre strain", middle, strain_in_words},
                              {"largest_strain", "largest strain", middle, strain_in_words},
                              {"smallest_strain", "smallest strain", middle, strain_in_words},
                              {"fibre_stress", "fibre stress", middle, in_pascals},
                              {"von_mises", "von Mises", middle, in_pascals},
                              {"pressure", "pressure", middle, in_pascals}};
  std::vector<SpreadColumn> some;
  for (const SpreadColumn& one : all)
    if (std::ranges::any_of(rows, [&](const PageData* row) {
          return at(at(at(*row, "mechanics"), "body"), one.key).is_object();
        }))
      some.push_back(one);
  return some;
}

/// How far a part's figure is off the same part's by the reference; nothing of the reference itself.
PageData error_cell(const PageData& value, const PageData& wanted) {
  if (!value.is_number() || !wanted.is_number() || wanted.get<double>() == 0)
    return number_cell("–", nullptr);
  const PageData error = std::abs(value.get<double>() / wanted.get<double>() - 1);
  return number_cell(percent(error), error);
}

/// Those whose means are held against the reference's: along fibres, without fibres the usual ones.
std::vector<const char*> figures_with_errors(const std::vector<SpreadColumn>& spreads) {
  const auto has = [&](std::string_view key) {
    return std::ranges::any_of(spreads, [&](const SpreadColumn& one) { return key == one.key; });
  };
  std::vector<const char*> keys;
  for (const auto& [along, otherwise] :
       {std::pair{"fibre_strain", "largest_strain"}, {"fibre_stress", "von_mises"}})
    if (has(along) || has(otherwise))
      keys.push_back(has(along) ? along : otherwise);
  return keys;
}

std::optional<PageData> parts_table(const std::vector<const PageData*>& rows, const std::string& reference,
                                    int dimension, const std::string& id) {
  std::vector<std::vector<PageData>> parts; // by row
  std::size_t most = 0;
  for (const PageData* row : rows) {
    parts.push_back(parts_of(at(*row, "mechanics")));
    most = std::max(most, parts.back().size());
  }
  if (most == 0)
    return std::nullopt;
  const std::vector<SpreadColumn> spreads = spread_columns(rows);
  PageData table{{"id", id},
                 {"caption", "Every part by every method: mean over its volume (5 % to 95 % of it)"},
                 {"columns",
                  {column("part", false), column("method", false), column("volume", true, "deformed"),
                   column("volume change", true)}},
                 {"rows", PageData::array()}};
  for (const SpreadColumn& spread : spreads)
    table["columns"].push_back(column(spread.name, true, spread.why));
  table["columns"].push_back(column("energy", true, "elastic strain energy"));
  const auto wanted =
      std::ranges::find_if(rows, [&](const PageData* row) { return at(*row, "method") == reference; });
  const std::vector<const char*> with_errors =
      wanted == rows.end() ? std::vector<const char*>{} : figures_with_errors(spreads);
  for (const char* key : with_errors)
    table["columns"].push_back(column(
        fmt::format("{} error", std::ranges::find(spreads, std::string_view(key), &SpreadColumn::key)->name),
        true, "of the mean, relative to the same part's by " + reference));
  if (!with_errors.empty())
    table["columns"].push_back(column("energy error", true, "relative to the same part's by " + reference));
  for (std::size_t part = 0; part < most; ++part)
    for (std::size_t row = 0; row < rows.size(); ++row) {
      if (part >= parts[row].size())
        continue;
      const PageData& one = parts[row][part];
      const PageData volume = at(one, "volume"), change = at(one, "volume_change"),
                     energy = at(one, "strain_energy");
      PageData cells{text_cell(name_of(one)), text_cell(plain(at(*rows[row], "method")))};
      cells.push_back(
          number_cell(volume.is_number() ? in_cubic_metres(volume.get<double>(), dimension) : "–", volume));
      const double strain = largest_of(one, "strain"), stress = largest_of(one, "stress");
      cells.push_back(number_cell(
          change.is_number() ? in_percent(without_rounding(change.get<double>(), strain)) : "–", change));
      for (const SpreadColumn& spread : spreads)
        cells.push_back(spread_cell(at(one, spread.key), spread.words,
                                    spread.words == strain_in_words ? strain : stress));
      cells.push_back(number_cell(
          energy.is_number() ? fmt::format("{:.4g} {}", energy.get<double>(), dimension == 2 ? "J/m" : "J")
                             : "–",
          energy));
      const bool is_reference = at(*rows[row], "method") == reference;
      const auto& references = parts[static_cast<std::size_t>(wanted - rows.begin()) % parts.size()];
      for (const char* key : with_errors)
        cells.push_back(is_reference || part >= references.size()
                            ? number_cell("–", nullptr)
                            : error_cell(at(one, key, "mean"), at(references[part], key, "mean")));
      if (!with_errors.empty())
        cells.push_back(is_reference || part >= references.size()
                            ? number_cell("–", nullptr)
                            : error_cell(energy, at(references[part], "strain_energy")));
      table["rows"].push_back({{"is_reference", is_reference}, {"cells", std::move(cells)}});
    }
  return table;
}

/// The length of a vector; 0 of none.
double size_of(const PageData& vector) {
  double square = 0;
  for (std::size_t axis = 0; vector.is_array() && axis < vector.size(); ++axis)
    square += vector[axis].is_number() ? std::pow(vector[axis].get<double>(), 2) : 0;
  return std::sqrt(square);
}

/// Components that are rounding beside the largest are 0.
void add_vector(PageData& cells, const PageData& vector, double largest) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const PageData value = vector.is_array() && vector.size() == 3 ? vector[axis] : PageData();
    cells.push_back(
        value.is_number()
            ? number_cell(fmt::format("{:.4g}", without_rounding(value.get<double>(), largest)), value)
            : number_cell("–", nullptr));
  }
}

std::optional<PageData> forces_table(const std::vector<const PageData*>& rows, const std::string& reference,
                                     int dimension, const std::string& id) {
  const std::string newton = dimension == 2 ? "N/m" : "N", moment = dimension == 2 ? "N" : "N m";
  PageData table{{"id", id},
                 {"caption", "Forces on the body, and moments about the middle of where they act, in the "
                             "world's axes"},
                 {"columns", {column("on", false), column("where", false), column("method", false)}},
                 {"rows", PageData::array()}};
  for (const char axis : {'x', 'y', 'z'})
    table["columns"].push_back(column(fmt::format("force {} [{}]", axis, newton), true));
  for (const char axis : {'x', 'y', 'z'})
    table["columns"].push_back(column(fmt::format("moment {} [{}]", axis, moment), true));
  for (const char* list : {"holds", "moves", "loads"}) {
    std::size_t most = 0;
    for (const PageData* row : rows)
      most = std::max(most, at(*row, "mechanics", list).size());
    for (std::size_t i = 0; i < most; ++i)
      for (const PageData* row : rows) {
        const PageData all = at(*row, "mechanics", list);
        if (!all.is_array() || i >= all.size())
          continue;
        const PageData where = at(all[i], "where");
        PageData cells{text_cell(plain(at(all[i], "name"))), text_cell(where.is_string() ? plain(where) : ""),
                       text_cell(plain(at(*row, "method")))};
        const double force = size_of(at(all[i], "force"));
        add_vector(cells, at(all[i], "force"), force);
        // Lever arms are at least a part of the place's own distance from the origin: rounding beside
        // that is 0.
        add_vector(cells, at(all[i], "moment"),
                   std::max(size_of(at(all[i], "moment")), force * size_of(at(all[i], "centroid"))));
        table["rows"].push_back(
            {{"is_reference", at(*row, "method") == reference}, {"cells", std::move(cells)}});
      }
  }
  return table["rows"].empty() ? std::nullopt : std::optional(table);
}

} // namespace

PageData mechanics_tables(const std::vector<PageData>& rows, const std::string& reference, int dimension,
                          const std::string& id) {
  PageData tables = PageData::array();
  const std::vector<const PageData*> some = with_mechanics(rows);
  if (const auto parts = parts_table(some, reference, dimension, id + "-parts"))
    tables.push_back(*parts);
  if (const auto forces = forces_table(some, reference, dimension, id + "-forces"))
    tables.push_back(*forces);
  return tables;
}

} // namespace maille::studies
