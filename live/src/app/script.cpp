#include "maille/live/live.hpp"
#include "maille/materials/csv_table.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
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

std::vector<CsvColumn> columns() {
  const auto none = Dimension::dimensionless;
  return {{"time", Dimension::time}, {"event", {}}, {"x", none},    {"y", none},
          {"button", none},          {"name", {}},  {"value", none}};
}

std::optional<double> as_number(const std::string& text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

/// Number in a cell; 0 if it is empty.
double number(CsvTable& row, std::string_view column) {
  return row.text(column).empty() ? 0 : row.number(column).value_or(0);
}

ScriptedEvent read_row(CsvTable& row) {
  ScriptedEvent scripted;
  scripted.at = number(row, "time");
  if (scripted.at < 0)
    row.fault("time", "a time >= 0", fmt::format("\"{}\"", row.text("time")));
  Event& event = scripted.event;
  const auto kind = kinds().find(row.text("event"));
  if (kind == kinds().end()) {
    row.fault("event", "move, down, up, wheel, key, set, resize, shot or close",
              fmt::format("\"{}\"", row.text("event")));
    return scripted;
  }
  event.kind = kind->second;
  event.x = number(row, "x");
  event.y = number(row, "y");
  event.button = static_cast<int>(std::clamp(number(row, "button"), 0.0, 9.0));
  event.name = row.text("name");
  if ((event.kind == EventKind::pointer_down || event.kind == EventKind::pointer_up) && event.button == 0)
    event.button = 1;
  const std::string value(row.text("value"));
  if (event.kind == EventKind::shot) {
    event.text = value.empty() ? event.name : value;
    if (!event.text.empty() && !is_name_of_picture(event.text))
      row.fault("value", "the plain name of a picture, NAME.png", "\"" + event.text + "\"");
  } else if (event.kind == EventKind::key_down) {
    // Modifier keys precede the name: `Ctrl+Z`.
    for (std::size_t plus = event.name.find('+'); plus != std::string::npos && plus + 1 < event.name.size();
         plus = event.name.find('+')) {
      const std::string held = event.name.substr(0, plus);
      event.control |= held == "Ctrl";
      event.shift |= held == "Shift";
      event.alt |= held == "Alt";
      event.name = event.name.substr(plus + 1);
    }
  } else if (as_number(value)) {
    event.value = number(row, "value");
  } else {
    event.text = value;
  }
  return scripted;
}

} // namespace

std::vector<ScriptedEvent> parse_script(std::string_view text, const std::string& file) {
  FaultList faults(file);
  std::vector<ScriptedEvent> script;
  for (CsvTable row(text, CsvComments::lines, columns(), faults); row.next();) {
    script.push_back(read_row(row));
    if (script.size() > 1 && script.back().at < script[script.size() - 2].at)
      row.fault("time", "times that do not fall", fmt::format("\"{}\"", row.text("time")));
  }
  faults.throw_if_any();
  return script;
}

std::vector<ScriptedEvent> read_script(const std::filesystem::path& file) {
  return parse_script(read_text_file(file, "a script of events"), file.string());
}

} // namespace maille::live
