#pragma once
/// Formatting of numbers and texts for tables, CSV and JSON of results.

#include <nlohmann/json.hpp>

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

namespace maille::studies {

/// Number for JSON; null for non-finite values, which JSON does not support.
inline nlohmann::ordered_json json_number(std::optional<double> value) {
  return value && std::isfinite(*value) ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}
/// Inverse of json_number: nothing if there is no number.
inline std::optional<double> number_in(const nlohmann::ordered_json& json) {
  return json.is_number() ? std::optional(json.get<double>()) : std::nullopt;
}

inline std::string in_percent(double ratio) {
  return std::isfinite(ratio) ? fmt::format("{:.3g} %", 100 * ratio) : "-";
}
inline std::string in_percent(std::optional<double> ratio) {
  return ratio ? in_percent(*ratio) : "-";
}

/// A time in the unit that gives a number from 1 to 1000.
inline std::string in_seconds(double seconds) {
  if (!std::isfinite(seconds))
    return "-";
  if (seconds < 1e-3)
    return fmt::format("{:.3g} us", 1e6 * seconds);
  return seconds < 1 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

/// A stress or modulus with three digits in a suitable unit.
inline std::string in_pascals(double pascals) {
  const double size = std::abs(pascals);
  if (size >= 1e9)
    return fmt::format("{:.3g} GPa", pascals / 1e9);
  if (size >= 1e6)
    return fmt::format("{:.3g} MPa", pascals / 1e6);
  return size >= 1e3 ? fmt::format("{:.3g} kPa", pascals / 1e3) : fmt::format("{:.3g} Pa", pascals);
}

/// A number; empty without a value.
inline std::string csv_number(std::optional<double> value, int digits = 6) {
  return value && std::isfinite(*value) ? fmt::format("{:.{}g}", *value, digits) : std::string();
}

} // namespace maille::studies
