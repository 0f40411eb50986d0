#include "identify/identify.hpp"
#include "maille/base/csv.hpp"
#include "maille/materials/quantity.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

namespace maille::studies {

namespace {

/// What a unit of a measure is one of; nothing for those that no text may have.
std::optional<Dimension> dimension_of(std::string_view unit) {
  if (unit == "m")
    return Dimension::length;
  if (unit == "N")
    return Dimension::force;
  if (unit == "Pa")
    return Dimension::pressure;
  if (unit == "rad")
    return Dimension::angle;
  if (unit.empty())
    return Dimension::dimensionless;
  return std::nullopt;
}

std::optional<double> number_in(std::string_view text, std::string_view unit) {
  const auto dimension = dimension_of(unit);
  return parse_quantity(text, dimension.value_or(Dimension::dimensionless));
}

std::string wanted_number(std::string_view unit) {
  const auto dimension = dimension_of(unit);
  return dimension ? describe(*dimension) : fmt::format("a number, in {}", unit);
}

} // namespace

std::vector<Observation> read_observations(std::string_view text, const std::filesystem::path& file,
                                           const std::vector<std::pair<std::string, std::string>>& units) {
  constexpr const char* wanted_head = "a first line of the columns measure, value and, if wanted, sigma";
  FaultList faults(file.string());
  CsvRecords records(text, CsvComments::lines);
  std::vector<std::string> head;
  std::vector<Observation> observations;
  std::set<std::string> seen;
  while (records.next()) {
    std::vector<std::string> cells;
    for (const std::string& cell : records.cells())
      cells.emplace_back(trimmed(cell));
    if (cells.size() == 1 && cells[0].empty())
      continue;
    const int line = records.line();
    if (head.empty()) {
      head = cells;
      const bool is_head = head.size() >= 2 && head[0] == "measure" && head[1] == "value" &&
                           (head.size() == 2 || (head.size() == 3 && head[2] == "sigma"));
      if (!is_head) {
        faults.add(line, "", wanted_head, fmt::format("{}", fmt::join(head, ",")));
        faults.throw_if_any();
      }
      continue;
    }
    if (cells.size() < 2 || cells.size() > head.size()) {
      faults.add(line, "", fmt::format("{} cells", head.size()), fmt::format("{}", cells.size()));
      continue;
    }
    const auto known = std::ranges::find(units, cells[0], &std::pair<std::string, std::string>::first);
    if (known == units.end()) {
      std::vector<std::string> names;
      for (const auto& [name, unit] : units)
        names.push_back(name);
      faults.add(line, "measure", fmt::format("a measure of the scene: {}", fmt::join(names, ", ")),
                 "\"" + cells[0] + "\"");
      continue;
    }
    if (!seen.insert(cells[0]).second)
      faults.add(line, "measure", "every measure once", "\"" + cells[0] + "\" again");
    Observation one{cells[0], 0, std::nullopt, line};
    if (const auto value = number_in(cells[1], known->second))
      one.value = *value;
    else
      faults.add(line, "value", wanted_number(known->second), "\"" + cells[1] + "\"");
    if (cells.size() == 3 && !cells[2].empty()) {
      one.sigma = number_in(cells[2], known->second);
      if (!one.sigma || !(*one.sigma > 0))
        faults.add(line, "sigma", wanted_number(known->second) + ", > 0", "\"" + cells[2] + "\"");
    }
    observations.push_back(std::move(one));
  }
  for (const Observation& one : observations)
    if (one.sigma.has_value() != observations.front().sigma.has_value())
      faults.add(one.line, "sigma", "of every line, or of none",
                 one.sigma ? "one where the first line has none" : "none where the first line has one");
  if (head.empty())
    faults.add(1, "", wanted_head, "an empty file");
  else if (observations.empty() && faults.empty())
    faults.add(0, "", "at least one measured number", "none");
  faults.throw_if_any();
  return observations;
}

} // namespace maille::studies
