/// Rows as lines of JSON, and back.

#include "maille/studies/study_table.hpp"

#include "study/statuses.hpp"
#include "text.hpp"

#include <nlohmann/json.hpp>

#include <limits>
#include <stdexcept>
#include <utility>

namespace maille::studies {

namespace {

using nlohmann::ordered_json;

double number_from(const ordered_json& value) {
  return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

/// A whole number that `Number` holds: a conversion of another one would be any number.
template<class Number>
Number whole_from(const ordered_json& value) {
  const bool fits = value.is_number_unsigned()
                        ? std::in_range<Number>(value.get<std::uint64_t>())
                        : value.is_number_integer() && std::in_range<Number>(value.get<std::int64_t>());
  if (!fits)
    throw std::invalid_argument("expected a whole number");
  return static_cast<Number>(value.get<std::int64_t>());
}

ordered_json norms_json(const ErrorNorms& norms) {
  return {{"relative_l2", json_number(norms.relative_l2)},
          {"relative_max", json_number(norms.relative_max)},
          {"rms", json_number(norms.rms)}};
}

std::optional<ErrorNorms> norms_from(const ordered_json& row, const char* key) {
  if (!row.contains(key))
    return std::nullopt;
  const ordered_json& norms = row.at(key);
  return ErrorNorms{number_from(norms.at("relative_l2")), number_from(norms.at("relative_max")),
                    number_from(norms.at("rms"))};
}

void read_figures(const ordered_json& in, StudyRow& row) {
  row.error = norms_from(in, "error");
  row.seconds.setup = number_from(in.at("seconds").at("setup"));
  row.seconds.solve = number_from(in.at("seconds").at("solve"));
  row.total_seconds = number_from(in.at("seconds").at("total"));
  row.repetitions = whole_from<int>(in.at("repetitions"));
  row.timing = named(timings, in.at("timing").get<std::string>());
  row.processor_share = number_from(in.at("processor_share"));
  row.load_average = number_from(in.at("load_average"));
  row.bytes = whole_from<std::int64_t>(in.at("bytes"));
  row.iterations = whole_from<std::int64_t>(in.at("iterations"));
  if (in.contains("limit_violation"))
    row.limit_violation = number_from(in.at("limit_violation"));
  row.reference = in.at("reference").get<std::string>();
  row.reference_error = norms_from(in, "reference_error");
}

} // namespace

ordered_json json(const StudyRow& row) {
  ordered_json parameters = ordered_json::object();
  for (const auto& [column, value] : row.parameters)
    if (const double* number = std::get_if<double>(&value))
      parameters[column] = json_number(*number);
    else
      parameters[column] = std::get<std::string>(value);
  ordered_json out{{"study", row.study},
                   {"case", row.number},
                   {"cases", row.n_cases},
                   {"scene", row.scene},
                   {"parameters", std::move(parameters)},
                   {"method", row.method},
                   {"status", to_string(row.status)},
                   {"message", row.message}};
  if (row.cut_is_allowed)
    out["cut"] = "allowed";
  if (row.error)
    out["error"] = norms_json(*row.error);
  out["seconds"] = {{"setup", json_number(row.seconds.setup)},
                    {"solve", json_number(row.seconds.solve)},
                    {"total", json_number(row.total_seconds)}};
  out["repetitions"] = row.repetitions;
  out["timing"] = to_string(row.timing);
  out["processor_share"] = json_number(row.processor_share);
  out["load_average"] = json_number(row.load_average);
  out["bytes"] = row.bytes;
  out["iterations"] = row.iterations;
  if (row.limit_violation)
    out["limit_violation"] = json_number(*row.limit_violation);
  out["reference"] = row.reference;
  if (row.reference_error)
    out["reference_error"] = norms_json(*row.reference_error);
  out["algorithm"] = row.algorithm;
  out["dimension"] = row.dimension;
  out["cells"] = row.cells;
  out["nodes"] = row.nodes;
  out["threads"] = row.threads;
  out["maille"] = row.maille;
  out["hash"] = row.hash;
  out["vtk"] = row.vtk;
  if (row.is_of_machine)
    out["of_machine"] = true;
  return out;
}

std::string json_line(const StudyRow& row) {
  // Messages may quote what a file holds: what is no UTF-8 there must not cost the row.
  return json(row).dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

StudyRow row_from_json(std::string_view line) {
  const ordered_json in = ordered_json::parse(line);
  StudyRow row;
  row.study = in.at("study").get<std::string>();
  row.number = whole_from<int>(in.at("case"));
  row.n_cases = whole_from<int>(in.at("cases"));
  row.scene = in.at("scene").get<std::string>();
  for (const auto& [column, value] : in.at("parameters").items())
    if (value.is_number() || value.is_null())
      row.parameters.emplace_back(column, number_from(value));
    else
      row.parameters.emplace_back(column, value.get<std::string>());
  row.method = in.at("method").get<std::string>();
  row.status = named(statuses, in.at("status").get<std::string>());
  row.message = in.at("message").get<std::string>();
  row.cut_is_allowed = in.contains("cut");
  read_figures(in, row);
  row.algorithm = in.at("algorithm").get<std::string>();
  row.dimension = whole_from<int>(in.at("dimension"));
  row.cells = whole_from<std::int64_t>(in.at("cells"));
  row.nodes = whole_from<std::int64_t>(in.at("nodes"));
  row.threads = whole_from<int>(in.at("threads"));
  row.maille = in.at("maille").get<std::string>();
  row.hash = in.at("hash").get<std::string>();
  row.vtk = in.at("vtk").get<std::string>();
  row.is_of_machine = in.value("of_machine", false);
  return row;
}

} // namespace maille::studies
