/// Values of parameters, as TOML for the scene and as numbers for tables.

#include "study/plan/read_parameter.hpp"

#include "study/plan/formula.hpp"
#include "study/plan/study_table.hpp"

#include <boost/math/distributions/normal.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <regex>
#include <sstream>

namespace maille::studies {

namespace {

/// Replaces every `[i]`, counted from 1, by the older `.i`, counted from 0: `move[1].by` becomes `move.0.by`.
std::string with_dots(std::string_view key) {
  std::string dotted;
  for (std::size_t at = 0; at < key.size();) {
    std::size_t number = 0;
    const char* const first = key.data() + at + 1;
    const auto [end, error] = std::from_chars(first, key.data() + key.size(), number);
    const bool is_index =
        key[at] == '[' && error == std::errc{} && number > 0 && end != key.data() + key.size() && *end == ']';
    dotted += is_index ? fmt::format(".{}", number - 1) : std::string(1, key[at]);
    at = is_index ? static_cast<std::size_t>(end - key.data()) + 1 : at + 1;
  }
  return dotted;
}

/// The child of a table by name or of an array by index; nullptr if missing.
toml::node* child(toml::node& parent, std::string_view name) {
  if (toml::table* table = parent.as_table())
    return table->get(name);
  toml::array* array = parent.as_array();
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  if (!array || error != std::errc{} || end != name.data() + name.size())
    return nullptr;
  return array->get(index);
}

void put(toml::node& parent, std::string_view name, const toml::node& value) {
  value.visit([&](const auto& concrete) {
    if (toml::table* table = parent.as_table()) {
      table->insert_or_assign(name, concrete);
      return;
    }
    std::size_t index = 0;
    std::from_chars(name.data(), name.data() + name.size(), index);
    toml::array& array = *parent.as_array();
    array.replace(array.cbegin() + static_cast<std::ptrdiff_t>(index), concrete);
  });
}

} // namespace

StudyValue drawn(double value, const std::string& unit) {
  const std::string number = fmt::format("{:.12g}", value);
  return {unit.empty() ? number : fmt::format("\"{} {}\"", number, unit),
          std::strtod(number.c_str(), nullptr)};
}

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
  // Inside an array tables are written inline, too; the array may take several lines.
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

namespace {

/// Quantile of the standard normal distribution at u. Sobol's points start at 0, so u is clipped to 2^-14
/// from the ends, 3.8 deviations from the centre.
double normal_quantile(double u) {
  constexpr double least = 0x1p-14;
  return boost::math::quantile(boost::math::normal(), std::clamp(u, least, 1 - least));
}

} // namespace

std::vector<StudyValue> values_of_range(const StudyParameter& parameter, int count) {
  std::vector<StudyValue> values;
  const StudyRange& range = *parameter.range;
  for (int i = 0; i < count; ++i)
    values.push_back(i == count - 1 && count > 1 ? drawn(range.to, parameter.unit)
                                                 : parameter.at(count > 1 ? i / (count - 1.0) : 0));
  return values;
}

StudyValue StudyParameter::at(double u) const {
  if (!range)
    return values[std::min(values.size() - 1,
                           static_cast<std::size_t>(u * static_cast<double>(values.size())))];
  if (range->is_normal) {
    const double z = normal_quantile(u);
    return drawn(range->is_logarithmic ? range->from * std::pow(range->to, z) : range->from + range->to * z,
                 unit);
  }
  return drawn(range->is_logarithmic ? range->from * std::pow(range->to / range->from, u)
                                     : range->from + u * (range->to - range->from),
               unit);
}

namespace {

constexpr std::int64_t most_values = 1'000'000;

/// Remaining number of values of all parameters: a short file must not request gigabytes.
std::int64_t values_left(const StudyFile& study) {
  std::int64_t left = most_values;
  for (const StudyParameter& parameter : study.parameters)
    left -= static_cast<std::int64_t>(parameter.values.size());
  return std::max<std::int64_t>(left, 1);
}

/// Reports keys that are missing in a scene.
void check_keys(TableReader& table, const StudyParameter& parameter, const StudyFile& study) {
  for (const StudyScene& scene : study.scenes) {
    toml::table document = parse_toml(scene.text, scene.file.string());
    for (const std::string& key : parameter.keys)
      if (const DottedNode found = find_dotted(document, key); !found.node)
        table.fault(
            "key",
            fmt::format("a key that {} has, lists counted from 1, as in move[1].by",
                        scene.file.filename().string()),
            fmt::format("\"{}\", of which {}", key,
                        found.last.empty() ? "it has nothing" : fmt::format("it has only {}", found.last)));
  }
}

/// Reports keys that equal, contain or are inside a key of an earlier parameter.
void check_overlap(TableReader& table, const StudyParameter& parameter, const StudyFile& study) {
  const auto is_within = [](const std::string& inner, const std::string& outer) {
    return (with_dots(inner) + ".").starts_with(with_dots(outer) + ".");
  };
  std::vector<std::string> earlier;
  for (std::size_t i = 0; i < study.n_varied(); ++i)
    earlier.insert(earlier.end(), study.varied(i).keys.begin(), study.varied(i).keys.end());
  for (const std::string& key : parameter.keys) {
    for (const std::string& other : earlier)
      if (is_within(key, other) || is_within(other, key))
        table.fault("key", "every key of the scene once", fmt::format("\"{}\" beside \"{}\"", key, other));
    earlier.push_back(key);
  }
  for (std::size_t i = 0; i < study.n_varied(); ++i)
    if (study.varied(i).label == parameter.label)
      table.fault("label", "a label for each parameter", fmt::format("\"{}\" twice", parameter.label));
  const auto is_control = [](unsigned char c) { return std::iscntrl(c) != 0; };
  if (!parameter.keys.empty() &&
      (parameter.label.empty() || std::ranges::any_of(parameter.label, is_control)))
    table.fault("label", "a text of printable characters", parameter.label.empty() ? "\"\"" : "others");
  if (const auto columns = study_columns(); std::ranges::find(columns, parameter.label) != columns.end())
    table.fault("label", "a label that is no other column's of the table",
                fmt::format("\"{}\"", parameter.label));
}

bool is_of_numbers(const StudyParameter& parameter) {
  return std::ranges::all_of(
      parameter.values, [](const StudyValue& value) { return std::holds_alternative<double>(value.shown); });
}

/// `normal(20 kPa, 4 kPa)`, `lognormal(20 kPa, 1.3)`.
bool read_law(TableReader& table, bool is_drawn, StudyParameter& parameter) {
  static const std::regex form(R"((normal|lognormal)\(([^,()]+),\s*([^,()]+)\)\s*)");
  const std::string text = table.text("values").value_or("");
  std::smatch parts;
  std::optional<NumberWithUnit> middle, spread;
  if (text.size() < 200 && std::regex_match(text, parts, form)) {
    middle = number_with_unit(toml::value(parts[2].str()));
    spread = number_with_unit(toml::value(parts[3].str()));
  }
  const bool is_logarithmic = text.starts_with("log");
  const bool is_right = is_drawn && middle && spread &&
                        (is_logarithmic ? middle->number > 0 && spread->number > 1 && spread->unit.empty()
                                        : spread->number > 0 && spread->unit == middle->unit);
  if (!is_right) {
    table.fault("values",
                is_drawn ? "normal(mean, deviation) in one unit, or lognormal(median, factor > 1)"
                         : "a list of values: latin_hypercube, sobol and saltelli alone draw distributions");
    return false;
  }
  parameter.range = StudyRange{middle->number, spread->number, is_logarithmic, true};
  parameter.unit = middle->unit;
  return true;
}

/// Reads a formula, a text in place of a list. Its unit is that of its first parameter with a unit.
bool read_formula(TableReader& table, const StudyFile& study, StudyParameter& parameter) {
  parameter.formula = table.text("values").value_or("");
  try {
    for (const std::string& name : names_in_formula(parameter.formula)) {
      std::size_t i = 0;
      while (i < study.n_varied() && (study.varied(i).label != name || !is_of_numbers(study.varied(i))))
        ++i;
      if (i == study.n_varied())
        throw std::invalid_argument(fmt::format("\"{}\", which is none", name));
      if (parameter.unit.empty())
        parameter.unit = study.varied(i).unit;
    }
  } catch (const std::invalid_argument& error) {
    table.fault("values", "a list of values, or a formula of labels of earlier parameters of numbers",
                error.what());
    return false;
  }
  return true;
}

bool read_list(TableReader& table, StudyParameter& parameter) {
  const toml::node& node = *table.find("values");
  const toml::array* list = node.as_array();
  if (!list || list->empty()) {
    table.fault("values", "a list of values");
    return false;
  }
  std::optional<std::string> unit;
  bool numbers_only = true;
  for (const toml::node& entry : *list) {
    parameter.values.push_back(value_of(entry));
    const auto number = number_with_unit(entry);
    numbers_only = numbers_only && number;
    if (number && unit && number->unit != *unit) {
      table.fault("values", fmt::format("one unit in all values, \"{}\" as in the first", *unit),
                  describe(entry));
      return false;
    }
    if (number && !unit)
      unit = number->unit;
  }
  if (numbers_only)
    parameter.unit = unit.value_or("");
  else // mixed numbers and texts, such as 0 and "taut": all texts
    for (std::size_t i = 0; i < list->size(); ++i)
      parameter.values[i].shown = (*list)[i].value_or(parameter.values[i].toml);
  return true;
}

bool read_range(TableReader& table, const char* key, StudyParameter& parameter) {
  const toml::node& node = *table.find(key);
  const toml::array* ends = node.as_array();
  const bool is_logarithmic = std::string_view(key) == "log_range";
  const auto from = ends && ends->size() == 2 ? number_with_unit((*ends)[0]) : std::nullopt;
  const auto to = ends && ends->size() == 2 ? number_with_unit((*ends)[1]) : std::nullopt;
  if (!from || !to || from->unit != to->unit) {
    table.fault(key, "two quantities of one unit, such as [\"3 kPa\", \"500 kPa\"]");
    return false;
  }
  if (is_logarithmic && !(from->number > 0 && to->number > 0)) {
    table.fault(key, "two quantities > 0");
    return false;
  }
  const double span = is_logarithmic ? to->number / from->number : to->number - from->number;
  if (!std::isfinite(span) || (is_logarithmic && span == 0)) {
    table.fault(key, is_logarithmic ? "two quantities whose ratio is a number"
                                    : "two quantities whose difference is a number");
    return false;
  }
  parameter.range = StudyRange{from->number, to->number, is_logarithmic};
  parameter.unit = from->unit;
  return true;
}

bool read_text_or_list(TableReader& table, const StudyFile& study, StudyParameter& parameter) {
  const std::string text = table.find("values")->value_or(std::string());
  if (text.starts_with("normal(") || text.starts_with("lognormal("))
    return read_law(table, is_drawn_plan(study.combination), parameter);
  return table.find("values")->is_string() ? read_formula(table, study, parameter)
                                           : read_list(table, parameter);
}

/// Reads the values, given in exactly one of three forms.
bool read_values(TableReader& table, const StudyFile& study, StudyParameter& parameter) {
  const bool is_drawn = is_drawn_plan(study.combination);
  std::vector<const char*> given;
  for (const char* key : {"values", "range", "log_range"})
    if (table.find(key))
      given.push_back(key);
  const toml::node* count = table.find("count");
  if (given.size() != 1) {
    table.fault(given.empty() ? "" : given.back(), "one of values, range and log_range",
                given.empty() ? "none" : fmt::format("{}", fmt::join(given, " and ")));
    return false;
  }
  const bool is_list = std::string_view(given.front()) == "values";
  if (count && (is_list || is_drawn))
    table.fault("count", is_list ? "no count beside a list of values" : "no count: samples says how many",
                describe(*count));
  if (is_list)
    return read_text_or_list(table, study, parameter);
  const bool is_whole = read_range(table, given.front(), parameter);
  if (is_drawn || !is_whole)
    return is_whole;
  if (!count)
    table.fault("count", "the number of values, both ends among them", "nothing");
  const auto n = count ? table.integer("count", 1, values_left(study)) : std::nullopt;
  if (n)
    parameter.values = values_of_range(parameter, static_cast<int>(*n));
  return n.has_value();
}

} // namespace

std::vector<std::string> texts_of(const toml::node& node, const std::string& path,
                                  const std::string& expected, FaultList& faults) {
  std::vector<std::string> texts;
  if (const auto one = node.value<std::string>())
    return {*one};
  if (const toml::array* list = node.as_array())
    for (const toml::node& entry : *list)
      if (const auto text = entry.value<std::string>())
        texts.push_back(*text);
      else
        faults.add(line_of(entry), path, expected, describe(entry));
  else
    faults.add(line_of(node), path, expected, describe(node));
  if (node.is_array() && node.as_array()->empty())
    faults.add(line_of(node), path, expected, "an empty list");
  return texts;
}

std::optional<StudyParameter> read_parameter(TableReader& table, const StudyFile& study) {
  StudyParameter parameter;
  constexpr const char* expected = "a dotted key of the scene such as \"move[1].by\", or a list of them";
  const bool is_for_formulas = !table.find("key") && table.find("label");
  if (const toml::node* node = is_for_formulas ? nullptr : table.require("key", expected))
    parameter.keys = texts_of(*node, table.path_of("key"), expected, table.faults());
  parameter.label = table.text("label").value_or(parameter.keys.empty() ? "" : parameter.keys.front());
  const bool has_values = read_values(table, study, parameter);
  check_keys(table, parameter, study);
  check_overlap(table, parameter, study);
  table.finish();
  return has_values && (is_for_formulas || !parameter.keys.empty()) ? std::optional(parameter) : std::nullopt;
}

DottedNode find_dotted(toml::table& root, std::string_view asked) {
  const std::string dotted = with_dots(asked);
  const std::string_view key = dotted;
  DottedNode found{&root, ""};
  for (std::size_t start = 0; start <= key.size();) {
    const std::size_t dot = std::min(key.find('.', start), key.size());
    const std::string step(key.substr(start, dot - start));
    toml::node* next = child(*found.node, step);
    if (!next)
      return {nullptr, found.last};
    found = {next, found.node->is_array() ? fmt::format("{}[{}]", found.last, std::stoll(step) + 1)
                   : found.last.empty()   ? step
                                          : found.last + "." + step};
    start = dot + 1;
  }
  return found;
}

void replace_dotted(toml::table& root, std::string_view asked, const std::string& value) {
  const std::string dotted = with_dots(asked);
  const std::string_view key = dotted;
  const toml::table document = toml::parse("value = " + value);
  const std::size_t dot = key.rfind('.');
  toml::node& parent = dot == std::string_view::npos ? root : *find_dotted(root, key.substr(0, dot)).node;
  put(parent, dot == std::string_view::npos ? key : key.substr(dot + 1), *document.get("value"));
}

} // namespace maille::studies
