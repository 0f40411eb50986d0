#include "maille/materials/quantity.hpp"

#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {
namespace {

/// SI value = value times `times` over `over`. Two exact numbers instead of one factor, so that "0.3 mm" is
/// the double nearest to 0.0003.
struct Unit {
  std::string_view name;
  double times;
  double over;
  bool listed = true; ///< false for alternative spellings, which messages omit
};

struct DimensionEntry {
  std::string_view noun;
  std::string_view example;
  std::vector<Unit> units;
};

/// In the order of the enumeration.
const DimensionEntry& entry_of(Dimension dimension) {
  static const std::array<DimensionEntry, 9> entries{
      {{"a number", "0.3", {{"%", 1, 100}}},
       {"a length",
        "2 mm",
        {{"m", 1, 1},
         {"cm", 1, 1e2},
         {"mm", 1, 1e3},
         {"um", 1, 1e6},
         {"\u00b5m", 1, 1e6, false},
         {"\u03bcm", 1, 1e6, false},
         {"nm", 1, 1e9}}},
       {"a pressure",
        "10 kPa",
        {{"Pa", 1, 1},
         {"kPa", 1e3, 1},
         {"MPa", 1e6, 1},
         {"GPa", 1e9, 1},
         {"N/m^2", 1, 1},
         {"N/cm^2", 1e4, 1},
         {"N/mm^2", 1e6, 1},
         {"mmHg", 133.322387415, 1}}},
       {"a density",
        "1050 kg/m^3",
        {{"kg/m^3", 1, 1},
         {"kg/m3", 1, 1, false},
         {"kg/m\u00b3", 1, 1, false},
         {"g/cm^3", 1e3, 1},
         {"g/cm3", 1e3, 1, false},
         {"g/cm\u00b3", 1e3, 1, false}}},
       {"an angle",
        "20 deg",
        {{"rad", 1, 1}, {"deg", std::numbers::pi, 180}, {"\u00b0", std::numbers::pi, 180, false}}},
       {"an acceleration",
        "9.81 m/s^2",
        {{"m/s^2", 1, 1}, {"m/s2", 1, 1, false}, {"m/s\u00b2", 1, 1, false}, {"mm/s^2", 1, 1e3}}},
       {"a time", "16 ms", {{"s", 1, 1}, {"ms", 1, 1e3}, {"us", 1, 1e6}, {"min", 60, 1}}},
       {"a force", "20 N", {{"N", 1, 1}, {"kN", 1e3, 1}, {"mN", 1, 1e3}}},
       {"a stiffness of springs per area",
        "10 kPa/mm",
        {{"Pa/m", 1, 1},
         {"kPa/m", 1e3, 1},
         {"MPa/m", 1e6, 1},
         {"Pa/mm", 1e3, 1},
         {"kPa/mm", 1e6, 1},
         {"MPa/mm", 1e9, 1},
         {"N/mm^3", 1e9, 1},
         {"N/m^3", 1, 1}}}}};
  return entries[static_cast<std::size_t>(dimension)];
}

std::optional<double> in_si(double value, std::string_view unit_name, Dimension dimension) {
  if (unit_name.empty())
    return value;
  for (const Unit& unit : entry_of(dimension).units) {
    if (unit.name == unit_name)
      return value * unit.times / unit.over;
  }
  return std::nullopt;
}

} // namespace

std::optional<double> parse_quantity(std::string_view text, Dimension dimension) {
  std::string_view number = trimmed(text);
  if (number.starts_with('+')) {
    number.remove_prefix(1); // from_chars does not accept a plus sign
    if (number.starts_with('-'))
      return std::nullopt;
  }
  double value = 0;
  const char* const end = number.data() + number.size();
  const auto [rest, error] = std::from_chars(number.data(), end, value);
  if (error != std::errc())
    return std::nullopt;
  const std::string_view unit = trimmed({rest, static_cast<std::size_t>(end - rest)});
  const std::optional<double> si = in_si(value, unit, dimension);
  return si && std::isfinite(*si) ? si : std::nullopt;
}

std::string describe(Dimension dimension) {
  const DimensionEntry& entry = entry_of(dimension);
  std::string units;
  for (const Unit& unit : entry.units) {
    if (unit.listed) {
      units += units.empty() ? "" : ", ";
      units += unit.name;
    }
  }
  if (dimension == Dimension::dimensionless)
    return fmt::format("{} such as {} (units: none, {})", entry.noun, entry.example, units);
  return fmt::format("{} such as \"{}\" (units: {})", entry.noun, entry.example, units);
}

} // namespace maille
