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

/// The mean, sorted by it, and the middle 90 %.
PageData spread_cell(const PageData& spread, std::string (*words)(double)) {
  const PageData mean = at(spread, "mean"), low = at(spread, "p5"), high = at(spread, "p95");
  if (!mean.is_number())
    return number_cell("–", nullptr);
  std::string text = words(mean.get<double>());
  if (low.is_number() && high.is_number())
    text += fmt::format(" ({} to {})", words(low.get<double>()), words(high.get<double>()));
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
      cells.push_back(number_cell(percent(change), change));
      for (const SpreadColumn& spread : spreads)
        cells.push_back(spread_cell(at(one, spread.key), spread.words));
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

/// Components that are rounding beside the largest are 0.
void add_vector(PageData& cells, const PageData& vector) {
  double largest = 0;
  const bool is_one = vector.is_array() && vector.size() == 3 &&
                      std::ranges::all_of(vector, [](const PageData& value) { return value.is_number(); });
  for (std::size_t axis = 0; is_one && axis < 3; ++axis)
    largest = std::max(largest, std::abs(vector[axis].get<double>()));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!is_one) {
      cells.push_back(number_cell("–", nullptr));
      continue;
    }
    const double value = vector[axis].get<double>();
    cells.push_back(
        number_cell(fmt::format("{:.4g}", std::abs(value) < 1e-9 * largest ? 0 : value), vector[axis]));
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
        add_vector(cells, at(all[i], "force"));
        add_vector(cells, at(all[i], "moment"));
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
