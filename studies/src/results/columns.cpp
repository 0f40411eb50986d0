#include "results/columns.hpp"

#include "maille/base/csv.hpp"
#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

namespace maille::studies {

namespace {

using nlohmann::ordered_json;

bool is_missing(const Value& value) {
  return value.is_null() || value.is_discarded();
}

/// The place of a key, or of a group and a key in it.
ordered_json& made(ordered_json& object, const std::string& path) {
  const std::size_t dot = path.find('.');
  return dot == std::string::npos ? object[path] : made(object[path.substr(0, dot)], path.substr(dot + 1));
}

/// nullptr where there is no such key.
const ordered_json* found(const ordered_json& object, const std::string& path) {
  if (!object.is_object())
    return nullptr;
  const std::size_t dot = path.find('.');
  const auto place = object.find(path.substr(0, dot));
  if (place == object.end())
    return nullptr;
  return dot == std::string::npos ? &*place : found(*place, path.substr(dot + 1));
}

/// The last one goes behind the first of which `is_it` is true.
template<class IsIt>
void move_last_behind(std::vector<std::size_t>& order, const IsIt& is_it) {
  const auto behind = std::ranges::find_if(order, is_it);
  if (behind != order.end())
    std::rotate(behind + 1, order.end() - 1, order.end());
}

using CellOf = std::function<std::string(std::size_t column)>;

/// Cells side by side, each in the width of its column; below 0: to the left.
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
    widths.back() = 0; // no blanks at the ends of lines
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
      values.push_back(std::numeric_limits<double>::infinity()); // JSON has none
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

CsvValues::CsvValues(const Columns& columns, std::string_view text, CsvReading reading)
    : columns_(columns), records_(text), reading_(std::move(reading)) {
  read_header();
  is_readable_ = faults_.empty();
}

void CsvValues::fault(std::string key, std::string expected, std::string found) {
  if (faults_.size() < most_faults)
    faults_.push_back(
        {reading_.file, std::max(records_.line(), 1), std::move(key), std::move(expected), std::move(found)});
}

void CsvValues::refuse(const Column& column, const Value& value) {
  fault(column.csv, column.expected, found_in_words(value));
}

void CsvValues::read_header() {
  if (records_.next())
    std::ranges::transform(records_.cells(), std::back_inserter(names_), without_guard);
  const auto& list = columns_.list();
  auto last_known = list.begin();
  // What is no column belongs to the next open one behind where it stands, else to the first.
  const auto open = [&] {
    const auto behind = std::ranges::find(last_known, list.end(), true, &Column::is_open);
    return behind == list.end() ? std::ranges::find(list, true, &Column::is_open) : behind;
  };
  for (const std::string& name : names_) {
    auto column = name.empty() ? list.end() : std::ranges::find(list, name, &Column::csv);
    if (column == list.end())
      column = open();
    else
      last_known = column;
    column_of_cell_.push_back(static_cast<std::size_t>(column - list.begin()));
    if (&name != &*std::ranges::find(names_, name))
      fault(name, "each column once", "\"" + name + "\" again");
  }
  std::vector<std::string> needed = reading_.needed;
  for (const Column& column : list)
    if (reading_.needed.empty() && column.is_read && !column.csv.empty() && !column.may_lack)
      needed.push_back(column.csv);
  for (const std::string& name : needed)
    if (std::ranges::find(names_, name) == names_.end())
      fault(name, "a column of that name", "none");
}

bool CsvValues::next(Values& values) {
  while (is_readable_ && faults_.size() < most_faults && records_.next()) {
    is_torn_ = reading_.may_be_torn && !records_.has_line_end();
    if (is_torn_)
      return false;
    if (records_.is_open())
      fault("", "a quote at the end of the cell, too", "the end of the file");
    else if (const std::size_t n = records_.cells().size(); n != names_.size())
      fault("", fmt::format("{} cells", names_.size()), fmt::format("{}", n));
    else {
      read_cells(values);
      return true;
    }
  }
  return false;
}

void CsvValues::read_cells(Values& values) const {
  const auto& list = columns_.list();
  values.assign(list.size(), Value(Value::value_t::discarded));
  for (std::size_t i = 0; i < list.size(); ++i)
    if (list[i].is_open)
      values[i] = Value::object();
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const std::size_t column = column_of_cell_[i];
    if (column == list.size() || !list[column].is_read)
      continue;
    const std::string cell = without_guard(records_.cells()[i]);
    const Value number = list[column].is_text ? Value(cell) : number_in_cell(cell);
    if (!list[column].is_open)
      values[column] = number;
    else
      values[column][names_[i]] =
          number.is_number() && std::isfinite(number.get<double>()) ? number : Value(cell);
  }
}

std::optional<std::int64_t> whole_number(const Value& value, std::int64_t least, std::int64_t most) {
  std::int64_t whole = 0;
  if (value.is_number_float()) {
    constexpr double exact = 9007199254740992.0; // 2^53: beyond, a double stands for several
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

Value number_in_cell(const std::string& text) {
  if (text.empty())
    return nullptr;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? Value(number) : Value(text);
}

} // namespace maille::studies
