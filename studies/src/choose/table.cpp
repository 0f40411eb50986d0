#include "choose/built_in_table.hpp"
#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/studies/choose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
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

constexpr std::array<const char*, 11> columns{
    "method",          "halvings",    "tolerance",    "status", "relative_l2", "total_s",
    "predicted_error", "predicted_s", "reference_l2", "scene",  "nodes"};
enum Column : std::size_t {
  method,
  halvings,
  tolerance,
  status,
  error,
  seconds,
  raw_error,
  raw_seconds,
  reference_error,
  scene,
  nodes
};
constexpr std::array needed{error, seconds, raw_error, raw_seconds, reference_error};

constexpr std::int64_t largest_table = std::int64_t{1} << 28; // some 500,000 rows
constexpr int most_halvings = 10;                             // what `maille trade --spacings` takes

/// Lattices by which probes were finer than at twice the spacing.
int whole_shift(double probe_halvings) {
  return probe_halvings >= 0 && probe_halvings <= most_halvings ? static_cast<int>(probe_halvings) + 1 : 0;
}

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
    probe_place_ = static_cast<std::size_t>(std::ranges::find(names, "probe_halvings") - names.begin());
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
    const bool is_complete = std::ranges::none_of(needed, [&](Column c) { return cells[place_[c]].empty(); });
    if ((ended != "done" && ended != "clamped") || !is_complete)
      return;
    StoredRow row;
    row.scene = cells[place_[scene]] + " " + cells[place_[nodes]];
    row.way.method = cells[place_[method]];
    const double n_halvings = number(cells, halvings, line);
    const bool is_possible = std::abs(n_halvings) <= most_halvings && n_halvings == std::floor(n_halvings);
    if (!is_possible)
      faults_.push_back({name_, line, columns[halvings],
                         fmt::format("a whole number from -{0} to {0}", most_halvings),
                         cells[place_[halvings]]});
    row.way.halvings = is_possible ? static_cast<int>(n_halvings) : 0;
    if (probe_place_ < cells.size() && !cells[probe_place_].empty())
      row.way.halvings -= whole_shift(number_in(cells[probe_place_], "probe_halvings", line));
    if (!cells[place_[tolerance]].empty())
      row.way.tolerance = number(cells, tolerance, line);
    // What the reference cannot tell apart from itself may be off by as much as the reference is.
    row.error = std::max(number(cells, error, line), number(cells, reference_error, line));
    row.seconds = number(cells, seconds, line);
    row.predicted_error = number(cells, raw_error, line);
    row.predicted_seconds = number(cells, raw_seconds, line);
    const auto counts = [](double value) { return value > 0 && std::isfinite(value); };
    if (counts(row.error) && counts(row.seconds) && counts(row.predicted_error) &&
        counts(row.predicted_seconds))
      rows_.push_back(std::move(row));
  }

  double number(const std::vector<std::string>& cells, Column column, int line) {
    return number_in(cells[place_[column]], columns[column], line);
  }

  double number_in(const std::string& text, const char* column, int line) {
    double value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc() || end != text.data() + text.size())
      faults_.push_back({name_, line, column, "a number", "\"" + text + "\""});
    return value;
  }

  std::string name_;
  std::array<std::size_t, columns.size()> place_{};
  std::size_t n_columns_ = 0, probe_place_ = 0; ///< the second may lie behind all columns: then there is none
  bool has_header_ = false, is_readable_ = false;
  std::vector<StoredRow> rows_;
  std::vector<Fault> faults_;
};

} // namespace

std::vector<StoredRow> parse_trade_table(std::string_view text, const std::string& name) {
  return TableParser(name).parse(text);
}

std::vector<StoredRow> read_trade_table(const std::filesystem::path& file) {
  return parse_trade_table(read_text_file(file, "a table", largest_table), file.string());
}

std::vector<StoredRow> built_in_trade_table() {
  return parse_trade_table(built_in_table_text(), "studies/trade/table.csv");
}

} // namespace maille::studies
