#include "results/columns.hpp"

#include "maille/base/csv.hpp"
#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace maille::studies {

namespace {

using nlohmann::ordered_json;

bool is_missing(const Value& value) {
  return value.is_null() || value.is_discarded();
}

/// Entry of a key, or of a key in a group; created if missing.
ordered_json& made(ordered_json& object, const std::string& path) {
  const std::size_t dot = path.find('.');
  return dot == std::string::npos ? object[path] : made(object[path.substr(0, dot)], path.substr(dot + 1));
}

/// nullptr if the key is missing.
const ordered_json* found(const ordered_json& object, const std::string& path) {
  if (!object.is_object())
    return nullptr;
  const std::size_t dot = path.find('.');
  const auto place = object.find(path.substr(0, dot));
  if (place == object.end())
    return nullptr;
  return dot == std::string::npos ? &*place : found(*place, path.substr(dot + 1));
}

/// Moves the last one after the first one that satisfies `is_it`.
template<class IsIt>
void move_last_behind(std::vector<std::size_t>& order, const IsIt& is_it) {
  const auto behind = std::ranges::find_if(order, is_it);
  if (behind != order.end())
    std::rotate(behind + 1, order.end() - 1, order.end());
}

using CellOf = std::function<std::string(std::size_t column)>;

/// Cells of a line, padded to the width of their columns; below 0: left-aligned.
std::string side_by_side(const std::vector<std::size_t>& places, const std::vector<int>& widths,
                         const CellOf& cell) {
  std::string line;
  for (std::size_t n = 0; n < places.size(); ++n)
    line += (n == 0 ? "" : " ") + (widths[n] < 0 ? fmt::format("{:<{}}", cell(places[n]), -widths[n])
                                                 : fmt::format("{:>{}}", cell(places[n]), widths[n]));
  return line + "\n";
}

} // namespace

void Columns::append(FigureName name, Shown shown) {
  json_order_.push_back(list_.size());
  text_order_.push_back(list_.size());
  Column& column = list_.emplace_back(Column{std::move(name), std::move(shown)});
  column.digits = column.unit == "s" ? numbers_.digits_of_seconds : numbers_.digits;
  column.is_omitted = column.json.find('.') != std::string::npos;
}

void Columns::move_in_json(const std::string& behind) {
  move_last_behind(json_order_, [&](std::size_t i) { return list_[i].json == behind; });
}

void Columns::move_in_text(const std::string& behind) {
  move_last_behind(text_order_, [&](std::size_t i) { return list_[i].shown.heading == behind; });
}

std::vector<std::string> Columns::csv_names() const {
  std::vector<std::string> names;
  for (const Column& column : list_)
    if (!column.csv.empty())
      names.push_back(column.csv);
  return names;
}

std::string Columns::csv_head() const {
  std::vector<std::string> names;
  for (const Column& column : list_)
    if (column.is_open)
      break;
    else if (!column.csv.empty())
      names.push_back(column.csv);
  return fmt::format("{}", fmt::join(names, ","));
}

ordered_json Columns::json_of(const Values& values) const {
  ordered_json object = ordered_json::object();
  for (const std::size_t i : json_order_) {
    const Value& value = values[i];
    if (!list_[i].json.empty() && !value.is_discarded() && !(value.is_null() && list_[i].is_omitted))
      made(object, list_[i].json) = value.is_number_float() ? json_number(value.get<double>()) : value;
  }
  return object;
}

std::string Columns::csv_header_of(const Values& values) const {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list_.size(); ++i) {
    if (list_[i].is_open)
      for (const auto& [name, value] : values[i].items())
        names.push_back(csv_text(name));
    if (!list_[i].csv.empty())
      names.push_back(list_[i].csv);
  }
  return fmt::format("{}\n", fmt::join(names, ","));
}

std::string Columns::csv_cell(const Value& value, int digits) const {
  if (is_missing(value))
    return "";
  if (value.is_string())
    return csv_text(value.get_ref<const std::string&>());
  if (!value.is_number_float())
    return value.dump();
  const double number = value.get<double>();
  if (numbers_.are_only_finite && !std::isfinite(number))
    return "";
  return digits == 0 ? fmt::format("{}", number) : fmt::format("{:.{}g}", number, digits);
}

std::string Columns::csv_line_of(const Values& values) const {
  std::vector<std::string> cells;
  for (std::size_t i = 0; i < list_.size(); ++i)
    if (list_[i].is_open)
      for (const Value& value : values[i])
        cells.push_back(csv_cell(value, list_[i].digits));
    else if (!list_[i].csv.empty())
      cells.push_back(csv_cell(values[i], list_[i].digits));
  return fmt::format("{}\n", fmt::join(cells, ","));
}

std::vector<std::size_t> Columns::places_shown(const std::vector<Values>& rows) const {
  std::vector<std::size_t> places;
  for (const std::size_t i : text_order_) {
    const auto lacks = [i](const Values& row) { return is_missing(row[i]); };
    if (!list_[i].shown.heading.empty() && !(list_[i].shown.is_left_out && std::ranges::all_of(rows, lacks)))
      places.push_back(i);
  }
  return places;
}

std::string Columns::in_words(std::size_t column, const Values& values, std::string_view absent) const {
  const Value& value = values[column];
  if (is_missing(value))
    return std::string(absent);
  if (value.is_string())
    return value.get<std::string>();
  if (list_[column].shown.words != nullptr)
    return list_[column].shown.words(value.get<double>());
  return value.is_number_float() ? fmt::format("{:.4g}", value.get<double>()) : value.dump();
}

int Columns::width_of(std::size_t column, const std::vector<Values>& rows) const {
  std::size_t width = list_[column].shown.heading.size();
  for (const Values& row : rows)
    width = std::max(width, in_words(column, row, "-").size());
  const bool is_text = std::ranges::any_of(rows, [&](const Values& row) { return row[column].is_string(); });
  return is_text ? -static_cast<int>(width) : static_cast<int>(width);
}

std::string Columns::text_of(const std::vector<Values>& rows) const {
  const auto places = places_shown(rows);
  std::vector<int> widths;
  for (const std::size_t i : places)
    widths.push_back(list_[i].shown.width != 0 ? list_[i].shown.width : width_of(i, rows));
  if (!places.empty() && list_[places.back()].shown.width == 0 && widths.back() < 0)
    widths.back() = 0; // no trailing blanks
  std::string text = side_by_side(places, widths, [&](std::size_t i) { return list_[i].shown.heading; });
  for (const Values& row : rows)
    text += side_by_side(places, widths, [&](std::size_t i) { return in_words(i, row, "-"); });
  return text;
}

Values Columns::values_of(const ordered_json& row) const {
  Values values;
  for (const Column& column : list_) {
    const ordered_json* value = column.json.empty() ? nullptr : found(row, column.json);
    const bool may_lack = column.json.empty() || column.is_omitted;
    if (value == nullptr)
      values.push_back(may_lack ? Value(Value::value_t::discarded) : Value());
    else if (value->is_null() && column.is_real && (column.is_omitted || !column.is_optional))
      values.push_back(std::numeric_limits<double>::infinity()); // JSON has no infinity
    else
      values.push_back(*value);
  }
  return values;
}

std::string found_in_words(const Value& value) {
  if (is_missing(value))
    return "nothing";
  return value.is_string() ? "\"" + value.get<std::string>() + "\""
                           : value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

std::optional<std::int64_t> whole_number(const Value& value, std::int64_t least, std::int64_t most) {
  std::int64_t whole = 0;
  if (value.is_number_float()) {
    constexpr double exact = 9007199254740992.0; // 2^53: beyond, a double represents several integers
    const double number = value.get<double>();
    if (!(std::abs(number) <= exact) || number != std::floor(number))
      return std::nullopt;
    whole = static_cast<std::int64_t>(number);
  } else if (value.is_number_integer() &&
             !(value.is_number_unsigned() && !std::in_range<std::int64_t>(value.get<std::uint64_t>())))
    whole = value.get<std::int64_t>();
  else
    return std::nullopt;
  return whole >= least && whole <= most ? std::optional(whole) : std::nullopt;
}

} // namespace maille::studies
