#include "maille/base/csv.hpp"
#include "maille/live/live.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/materials/toml_reader.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

const std::map<std::string, EventKind, std::less<>>& kinds() {
  static const std::map<std::string, EventKind, std::less<>> kinds{
      {"move", EventKind::pointer_move}, {"down", EventKind::pointer_down}, {"up", EventKind::pointer_up},
      {"wheel", EventKind::wheel},       {"key", EventKind::key_down},      {"set", EventKind::widget},
      {"resize", EventKind::resize},     {"shot", EventKind::shot},         {"close", EventKind::close}};
  return kinds;
}

constexpr std::array<const char*, 7> columns{"time [s]", "event", "x", "y", "button", "name", "value"};

std::string column_names() {
  std::string names;
  for (const char* name : columns)
    names += std::string(names.empty() ? "" : ",") + name;
  return names;
}

std::optional<double> as_number(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// One row's cells, by their columns.
class Row {
public:
  Row(const std::vector<std::string>& cells, int line, FaultList& faults)
      : cells_(cells), line_(line), faults_(faults) {}

  std::string text(std::size_t column) const {
    return std::string(column < cells_.size() ? trimmed(cells_[column]) : std::string_view());
  }
  /// Number in a cell; 0 where it is empty.
  double number(std::size_t column) const {
    const std::string cell = text(column);
    if (cell.empty())
      return 0;
    const std::optional<double> value = as_number(cell);
    if (!value || !std::isfinite(*value)) {
      fault(column, "a number", "\"" + cell + "\"");
      return 0;
    }
    return *value;
  }
  void fault(std::size_t column, std::string expected, std::string found) const {
    faults_.add(line_, columns[column], std::move(expected), std::move(found));
  }

private:
  const std::vector<std::string>& cells_;
  int line_;
  FaultList& faults_;
};

ScriptedEvent read_row(const Row& row) {
  ScriptedEvent scripted;
  scripted.at = row.number(0);
  if (scripted.at < 0)
    row.fault(0, "a time >= 0", "\"" + row.text(0) + "\"");
  Event& event = scripted.event;
  const auto kind = kinds().find(row.text(1));
  if (kind == kinds().end()) {
    row.fault(1, "move, down, up, wheel, key, set, resize, shot or close", "\"" + row.text(1) + "\"");
    return scripted;
  }
  event.kind = kind->second;
  event.x = row.number(2);
  event.y = row.number(3);
  event.button = static_cast<int>(std::clamp(row.number(4), 0.0, 9.0));
  event.name = row.text(5);
  if ((event.kind == EventKind::pointer_down || event.kind == EventKind::pointer_up) && event.button == 0)
    event.button = 1;
  const std::string value = row.text(6);
  if (event.kind == EventKind::shot) {
    event.text = value.empty() ? event.name : value;
    if (!event.text.empty() && !is_name_of_picture(event.text))
      row.fault(6, "the plain name of a picture, NAME.png", "\"" + event.text + "\"");
  } else if (event.kind == EventKind::key_down) {
    // Keys held with it stand before it: `Ctrl+Z`.
    for (std::size_t plus = event.name.find('+'); plus != std::string::npos && plus + 1 < event.name.size();
         plus = event.name.find('+')) {
      const std::string held = event.name.substr(0, plus);
      event.control |= held == "Ctrl";
      event.shift |= held == "Shift";
      event.alt |= held == "Alt";
      event.name = event.name.substr(plus + 1);
    }
  } else if (as_number(value)) {
    event.value = row.number(6);
  } else {
    event.text = value;
  }
  return scripted;
}

} // namespace

std::vector<ScriptedEvent> parse_script(std::string_view text, const std::string& file) {
  FaultList faults(file);
  std::vector<ScriptedEvent> script;
  bool has_header = false;
  for (CsvRecords records(text, CsvComments::lines); records.next();) {
    const std::string_view first = trimmed(records.cells().front());
    if ((first.empty() && records.cells().size() == 1) || first.starts_with('#'))
      continue;
    if (!has_header) {
      has_header = true;
      const bool is_right =
          records.cells().size() == columns.size() &&
          std::ranges::equal(records.cells(), columns,
                             [](const std::string& cell, const char* name) { return trimmed(cell) == name; });
      if (!is_right) {
        faults.add(records.line(), "", "a first row " + column_names(), "another");
        break;
      }
      continue;
    }
    script.push_back(read_row(Row(records.cells(), records.line(), faults)));
    if (script.size() > 1 && script.back().at < script[script.size() - 2].at)
      faults.add(records.line(), "time [s]", "times that do not fall", "\"" + std::string(first) + "\"");
  }
  if (!has_header)
    faults.add(0, "", "a first row " + column_names(), "an empty file");
  faults.throw_if_any();
  return script;
}

std::vector<ScriptedEvent> read_script(const std::filesystem::path& file) {
  return parse_script(read_text_file(file, "a script of events"), file.string());
}

} // namespace maille::live
