#include "units_of_file.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille {

namespace {

/// True for texts such as "2" or "1e-3": a number and no unit.
bool has_no_unit(const toml::node& node) {
  const auto* const string = node.as_string();
  if (!string) {
    return true;
  }
  const std::string& text = string->get();
  const std::size_t last = text.find_last_not_of(" \t");
  return last != std::string::npos && (text[last] == '.' || (text[last] >= '0' && text[last] <= '9')) &&
         parse_quantity(text, Dimension::dimensionless).has_value();
}

} // namespace

std::optional<double> in_units_of_the_file(const toml::node& node, double value, const std::string& path,
                                           Dimension dimension, FaultList& faults) {
  const bool is_length = dimension == Dimension::length;
  if ((!is_length && dimension != Dimension::angle) || value == 0 || !has_no_unit(node)) {
    return value;
  }
  const std::optional<double>& factor = is_length ? faults.units.length : faults.units.angle;
  if (factor) {
    return value * *factor;
  }
  const char* const unit = is_length ? "mm" : "deg";
  const char* const si = is_length ? "m" : "rad";
  faults.add(line_of(node), path,
             fmt::format("{0} with its unit, such as \"{1:g} {2}\" or \"{1:g} {3}\" (or, for all numbers of "
                         "the file, a first "
                         "line units = \"{2}\" or \"{3}\")",
                         is_length ? "a length" : "an angle", value, si, unit),
             describe(node) + ", which has none");
  return std::nullopt;
}

void read_units(TableReader& root) {
  constexpr const char* wanted =
      "a unit of length, of angle, or both: \"mm\", \"mm, deg\" (m, cm, mm, um, nm; rad, deg)";
  const auto text = root.text("units");
  if (!text) {
    return;
  }
  FileUnits units;
  for (std::size_t begin = 0; begin <= text->size();) {
    const std::size_t end = std::min(text->find(',', begin), text->size());
    const std::string unit = text->substr(begin, end - begin);
    const bool is_none = parse_quantity("1" + unit, Dimension::dimensionless).has_value(); // "", "0", "%"
    const auto length = is_none ? std::nullopt : parse_quantity("1" + unit, Dimension::length),
               angle = is_none ? std::nullopt : parse_quantity("1" + unit, Dimension::angle);
    std::optional<double>& into = length ? units.length : units.angle;
    if ((!length && !angle) || into) {
      root.fault("units", wanted, describe(*root.find("units")));
      return;
    }
    into = length ? length : angle;
    begin = end + 1;
  }
  root.faults().units = units;
}

} // namespace maille
