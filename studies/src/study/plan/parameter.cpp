/// Values of parameters, as TOML for the scene and as numbers for tables.

#include "study/plan/parameter.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <sstream>

namespace maille::studies {

namespace {

/// Twelve digits: what is drawn from a range ought to be legible, and nothing is known better.
StudyValue drawn(double value, const std::string& unit) {
  const std::string number = fmt::format("{:.12g}", value);
  return {unit.empty() ? number : fmt::format("\"{} {}\"", number, unit),
          std::strtod(number.c_str(), nullptr)};
}

} // namespace

std::optional<NumberWithUnit> number_with_unit(const toml::node& node) {
  if (const auto number = node.is_number() ? node.value<double>() : std::nullopt)
    return std::isfinite(*number) ? std::optional(NumberWithUnit{*number, ""}) : std::nullopt;
  const auto text = node.value<std::string>();
  if (!text)
    return std::nullopt;
  char* end = nullptr;
  const double number = std::strtod(text->c_str(), &end);
  if (end == text->c_str() || !std::isfinite(number))
    return std::nullopt;
  const std::string_view rest(end);
  const std::size_t first = rest.find_first_not_of(" \t"), last = rest.find_last_not_of(" \t");
  return NumberWithUnit{number, first == rest.npos ? std::string()
                                                   : std::string(rest.substr(first, last - first + 1))};
}

std::string toml_text(const toml::node& node) {
  // In an array tables stand in line too; it may take several lines.
  toml::array around;
  node.visit([&](const auto& concrete) { around.push_back(concrete); });
  std::ostringstream text;
  text << toml::toml_formatter(around);
  std::string line;
  for (const char c : text.str())
    if (c != '\n' && !(c == ' ' && line.ends_with(' ')))
      line += c;
  const std::size_t first = line.find_first_not_of(" ", 1),
                    last = line.find_last_not_of(" ", line.size() - 2);
  return line.substr(first, last - first + 1);
}

StudyValue value_of(const toml::node& node) {
  const auto number = number_with_unit(node);
  return {toml_text(node),
          number ? std::variant<double, std::string>(number->number) : node.value_or(toml_text(node))};
}

std::vector<StudyValue> values_of_range(const StudyParameter& parameter, int count) {
  std::vector<StudyValue> values;
  const StudyRange& range = *parameter.range;
  for (int i = 0; i < count; ++i)
    values.push_back(i == count - 1 && count > 1 ? drawn(range.to, parameter.unit)
                                                 : parameter.at(count > 1 ? i / (count - 1.0) : 0));
  return values;
}

std::string StudyParameter::column() const {
  return unit.empty() ? label : fmt::format("{} [{}]", label, unit);
}

StudyValue StudyParameter::at(double u) const {
  if (!range)
    return values[std::min(values.size() - 1,
                           static_cast<std::size_t>(u * static_cast<double>(values.size())))];
  return drawn(range->is_logarithmic ? range->from * std::pow(range->to / range->from, u)
                                     : range->from + u * (range->to - range->from),
               unit);
}

} // namespace maille::studies
