/// Rows as lines of CSV (RFC 4180), and back.

#include "maille/materials/fault.hpp"
#include "maille/studies/study_table.hpp"
#include "study/statuses.hpp"
#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <type_traits>

namespace maille::studies {

namespace {

std::string shown(double value) {
  return fmt::format("{}", value); // the shortest that reads back
}

double number_from(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0')
    throw std::invalid_argument(fmt::format("\"{}\" is no number", text));
  return value;
}

/// A column with the name of its own: how it is written and read. Those of parameters stand between the two
/// lists.
struct Column {
  const char* name;
  std::function<std::string(const StudyRow&)> write;
  std::function<void(StudyRow&, const std::string&)> read;
};

Column text_column(const char* name, std::string StudyRow::*member) {
  return {name, [member](const StudyRow& row) { return row.*member; },
          [member](StudyRow& row, const std::string& text) { row.*member = text; }};
}

/// Whole numbers within what `Number` holds, and what a double holds exactly.
template<class Number>
Number number_as(const std::string& text) {
  const double value = number_from(text);
  if constexpr (std::is_integral_v<Number>) {
    constexpr double exact = 9007199254740992.0; // 2^53
    const double least = std::max(-exact, static_cast<double>(std::numeric_limits<Number>::min()));
    const double most = std::min(exact, static_cast<double>(std::numeric_limits<Number>::max()));
    if (!(value >= least && value <= most) || value != std::floor(value))
      throw std::invalid_argument(fmt::format("\"{}\" is no whole number from {} to {}", text, least, most));
  }
  return static_cast<Number>(value);
}

template<class Number>
Column number_column(const char* name, Number StudyRow::*member) {
  return {name, [member](const StudyRow& row) { return fmt::format("{}", row.*member); },
          [member](StudyRow& row, const std::string& text) { row.*member = number_as<Number>(text); }};
}

Column seconds_column(const char* name, double Seconds::*member) {
  return {name, [member](const StudyRow& row) { return shown(row.seconds.*member); },
          [member](StudyRow& row, const std::string& text) { row.seconds.*member = number_from(text); }};
}

Column norm_column(const char* name, std::optional<ErrorNorms> StudyRow::*norms, double ErrorNorms::*member) {
  return {name,
          [norms, member](const StudyRow& row) {
            return row.*norms ? shown((*(row.*norms)).*member) : std::string();
          },
          [norms, member](StudyRow& row, const std::string& text) {
            if (text.empty())
              return;
            if (!(row.*norms))
              row.*norms = ErrorNorms{};
            (*(row.*norms)).*member = number_from(text);
          }};
}

const std::vector<Column>& columns_before() {
  static const std::vector<Column> list{
      text_column("study", &StudyRow::study), number_column("case", &StudyRow::number),
      number_column("cases", &StudyRow::n_cases), text_column("scene", &StudyRow::scene)};
  return list;
}

const std::vector<Column>& columns_after() {
  static const std::vector<Column> list{
      text_column("method", &StudyRow::method),
      {"status", [](const StudyRow& row) { return std::string(to_string(row.status)); },
       [](StudyRow& row, const std::string& text) { row.status = named(statuses, text); }},
      norm_column("relative_l2", &StudyRow::error, &ErrorNorms::relative_l2),
      norm_column("relative_max", &StudyRow::error, &ErrorNorms::relative_max),
      norm_column("rms_m", &StudyRow::error, &ErrorNorms::rms),
      seconds_column("setup_s", &Seconds::setup),
      seconds_column("solve_s", &Seconds::solve),
      number_column("total_s", &StudyRow::total_seconds),
      number_column("repetitions", &StudyRow::repetitions),
      {"timing", [](const StudyRow& row) { return std::string(to_string(row.timing)); },
       [](StudyRow& row, const std::string& text) { row.timing = named(timings, text); }},
      number_column("processor_share", &StudyRow::processor_share),
      number_column("load_average", &StudyRow::load_average),
      number_column("bytes", &StudyRow::bytes),
      number_column("iterations", &StudyRow::iterations),
      {"limit_violation",
       [](const StudyRow& row) { return row.limit_violation ? shown(*row.limit_violation) : std::string(); },
       [](StudyRow& row, const std::string& text) {
         if (!text.empty())
           row.limit_violation = number_from(text);
       }},
      text_column("reference", &StudyRow::reference),
      norm_column("reference_relative_l2", &StudyRow::reference_error, &ErrorNorms::relative_l2),
      norm_column("reference_relative_max", &StudyRow::reference_error, &ErrorNorms::relative_max),
      norm_column("reference_rms_m", &StudyRow::reference_error, &ErrorNorms::rms),
      number_column("dimension", &StudyRow::dimension),
      number_column("cells", &StudyRow::cells),
      number_column("nodes", &StudyRow::nodes),
      number_column("threads", &StudyRow::threads),
      text_column("algorithm", &StudyRow::algorithm),
      text_column("maille", &StudyRow::maille),
      text_column("hash", &StudyRow::hash),
      text_column("vtk", &StudyRow::vtk),
      text_column("message", &StudyRow::message)};
  return list;
}

/// The fields of the record that begins at `at`, which is moved behind it. Nothing where it is not whole.
/// What csv_text has made a text of, as it was.
void take_off_apostrophes(std::vector<std::string>& fields) {
  for (std::string& field : fields)
    if (field.starts_with('\'') && is_formula(std::string_view(field).substr(1)))
      field.erase(0, 1);
}

std::optional<std::vector<std::string>> next_record(std::string_view text, std::size_t& at) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (; at < text.size(); ++at) {
    const char c = text[at];
    if (is_quoted && c == '"' && at + 1 < text.size() && text[at + 1] == '"')
      fields.back() += text[++at];
    else if (c == '"')
      is_quoted = !is_quoted;
    else if (!is_quoted && c == ',')
      fields.emplace_back();
    else if (!is_quoted && c == '\n') {
      ++at;
      take_off_apostrophes(fields);
      return fields;
    } else if (is_quoted || c != '\r')
      fields.back() += c;
  }
  return std::nullopt;
}

std::variant<double, std::string> parameter_from(const std::string& text) {
  try {
    if (const double value = number_from(text); std::isfinite(value))
      return value;
  } catch (const std::invalid_argument&) {
  }
  return text; // JSON lines have no infinity
}

StudyRow row_from(const std::vector<std::string>& header, const std::vector<std::string>& fields) {
  if (fields.size() != header.size())
    throw std::invalid_argument(fmt::format("{} fields", fields.size()));
  StudyRow row;
  const std::size_t before = columns_before().size(), after = header.size() - columns_after().size();
  for (std::size_t i = 0; i < header.size(); ++i)
    if (i < before)
      columns_before()[i].read(row, fields[i]);
    else if (i < after)
      row.parameters.emplace_back(header[i], parameter_from(fields[i]));
    else
      columns_after()[i - after].read(row, fields[i]);
  return row;
}

bool is_header(const std::vector<std::string>& header) {
  const std::size_t before = columns_before().size(), after = columns_after().size();
  if (header.size() < before + after)
    return false;
  const auto same = [](const Column& column, const std::string& name) { return name == column.name; };
  return std::equal(columns_before().begin(), columns_before().end(), header.begin(), same) &&
         std::equal(columns_after().begin(), columns_after().end(),
                    header.end() - static_cast<std::ptrdiff_t>(after), same);
}

} // namespace

std::vector<std::string> study_columns() {
  std::vector<std::string> names;
  for (const auto& columns : {columns_before(), columns_after()})
    for (const Column& column : columns)
      names.emplace_back(column.name);
  return names;
}

std::string csv_header(const StudyRow& row) {
  std::vector<std::string> names;
  for (const Column& column : columns_before())
    names.emplace_back(column.name);
  for (const auto& [column, value] : row.parameters)
    names.push_back(csv_text(column));
  for (const Column& column : columns_after())
    names.emplace_back(column.name);
  return fmt::format("{}\n", fmt::join(names, ","));
}

std::string csv_line(const StudyRow& row) {
  std::vector<std::string> fields;
  for (const Column& column : columns_before())
    fields.push_back(csv_text(column.write(row)));
  for (const auto& [column, value] : row.parameters)
    fields.push_back(std::holds_alternative<double>(value) ? shown(std::get<double>(value))
                                                           : csv_text(std::get<std::string>(value)));
  for (const Column& column : columns_after())
    fields.push_back(csv_text(column.write(row)));
  return fmt::format("{}\n", fmt::join(fields, ","));
}

StudyTable parse_study_csv(std::string_view text, const std::filesystem::path& file) {
  StudyTable table;
  std::size_t at = 0;
  const auto header = next_record(text, at);
  if (!header || !is_header(*header))
    throw InputError({{file.string(), 1, "", "the header of a study's table", "another line"}});
  int line = 1;
  for (std::size_t start = at; start < text.size(); start = at) {
    const auto fields = next_record(text, at);
    ++line;
    if (!fields) {
      table.is_torn = true;
      break;
    }
    try {
      table.rows.push_back(row_from(*header, *fields));
    } catch (const std::invalid_argument& error) {
      throw InputError({{file.string(), line, "", "a row of a study's table", error.what()}});
    }
  }
  return table;
}

} // namespace maille::studies
