#include "choose/built_in_table.hpp"
#include "maille/materials/fault.hpp"
#include "maille/studies/choose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <sstream>

namespace maille::studies {

namespace {

/// The cells of one line of CSV; quoted ones without their quotes.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (is_quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[++i];
    else if (c == '"')
      is_quoted = !is_quoted;
    else if (c == ',' && !is_quoted)
      cells.emplace_back();
    else if (c != '\r')
      cells.back() += c;
  }
  return cells;
}

constexpr std::array<const char*, 8> columns{"method",      "halvings", "tolerance",       "status",
                                             "relative_l2", "total_s",  "predicted_error", "predicted_s"};
enum Column : std::size_t { method, halvings, tolerance, status, error, seconds, raw_error, raw_seconds };

/// Reads one table and collects its faults.
class TableParser {
public:
  explicit TableParser(std::string name) : name_(std::move(name)) {}

  std::vector<StoredRow> parse(std::string_view text) {
    std::istringstream stream{std::string(text)};
    std::string line;
    for (int number = 1; std::getline(stream, line); ++number)
      if (number == 1)
        read_header(cells_of(line));
      else
        read_line(cells_of(line), number);
    if (!has_header_)
      read_header({});
    if (!faults_.empty())
      throw InputError(std::move(faults_));
    return std::move(rows_);
  }

private:
  void read_header(const std::vector<std::string>& names) {
    has_header_ = true;
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const auto found = std::ranges::find(names, columns[c]);
      place_[c] = static_cast<std::size_t>(found - names.begin());
      if (found == names.end())
        faults_.push_back(
            {name_, 1, columns[c], "a column of that name, as `maille trade` writes it", "none"});
    }
    n_columns_ = names.size();
    is_readable_ = faults_.empty();
  }

  void read_line(const std::vector<std::string>& cells, int line) {
    if (!is_readable_)
      return;
    if (cells.size() != n_columns_) {
      faults_.push_back(
          {name_, line, "", fmt::format("{} cells", n_columns_), fmt::format("{}", cells.size())});
      return;
    }
    const std::string& ended = cells[place_[status]];
    const bool is_complete = std::ranges::none_of(std::array{error, seconds, raw_error, raw_seconds},
                                                  [&](Column c) { return cells[place_[c]].empty(); });
    if ((ended != "done" && ended != "clamped") || !is_complete)
      return;
    StoredRow row;
    row.way.method = cells[place_[method]];
    row.way.halvings = static_cast<int>(number(cells, halvings, line));
    if (!cells[place_[tolerance]].empty())
      row.way.tolerance = number(cells, tolerance, line);
    row.error = number(cells, error, line);
    row.seconds = number(cells, seconds, line);
    row.predicted_error = number(cells, raw_error, line);
    row.predicted_seconds = number(cells, raw_seconds, line);
    if (row.error > 0 && row.seconds > 0 && row.predicted_error > 0 && row.predicted_seconds > 0)
      rows_.push_back(std::move(row));
  }

  double number(const std::vector<std::string>& cells, Column column, int line) {
    const std::string& text = cells[place_[column]];
    double value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc() || end != text.data() + text.size())
      faults_.push_back({name_, line, columns[column], "a number", "\"" + text + "\""});
    return value;
  }

  std::string name_;
  std::array<std::size_t, columns.size()> place_{};
  std::size_t n_columns_ = 0;
  bool has_header_ = false, is_readable_ = false;
  std::vector<StoredRow> rows_;
  std::vector<Fault> faults_;
};

} // namespace

std::vector<StoredRow> parse_trade_table(std::string_view text, const std::string& name) {
  return TableParser(name).parse(text);
}

std::vector<StoredRow> read_trade_table(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (stream)
    text << stream.rdbuf();
  std::error_code no_matter;
  if (!stream || std::filesystem::is_directory(file, no_matter))
    throw InputError({{file.string(), 0, "", "a table that can be read", "nothing that can be read there"}});
  return parse_trade_table(text.str(), file.string());
}

std::vector<StoredRow> built_in_trade_table() {
  return parse_trade_table(built_in_table_text(), "studies/trade/table.csv");
}

} // namespace maille::studies
