#include "study/table_files.hpp"

#include "maille/studies/version.hpp"
#include "results/figures.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::studies {

namespace {

using Table = ResultTable<StudyRow>;

Value parameters_of(const StudyRow& row) {
  Value parameters = Value::object();
  for (const auto& parameter : row.parameters)
    std::visit([&](const auto& of_case) { parameters[parameter.first] = of_case; }, parameter.second);
  return parameters;
}

bool read_parameters(StudyRow& row, const Value& parameters) {
  if (!parameters.is_object())
    return false;
  for (const auto& [column, value] : parameters.items())
    if (value.is_string())
      row.parameters.emplace_back(column, value.get<std::string>());
    else if (value.is_number() || value.is_null()) // JSON has no infinity
      row.parameters.emplace_back(column, value.is_null() ? std::numeric_limits<double>::infinity()
                                                          : value.get<double>());
    else
      return false;
  return true;
}

/// Measures of a row; null if the scenes have none.
Value measures_of(const StudyRow& row) {
  Value measures;
  for (const StudyMeasure& measure : row.measures)
    measures[measure.name] = measure.value ? Value(*measure.value) : Value();
  return measures;
}

Value measure_units_of(const StudyRow& row) {
  Value units;
  for (const StudyMeasure& measure : row.measures)
    if (!measure.unit.empty())
      units[measure.name] = measure.unit;
  return units;
}

/// The entry of that name, created if missing.
StudyMeasure& measure_named(StudyRow& row, const std::string& name) {
  const auto found = std::ranges::find(row.measures, name, &StudyMeasure::name);
  return found == row.measures.end() ? row.measures.emplace_back(StudyMeasure{name, {}, {}}) : *found;
}

bool read_measures(StudyRow& row, const Value& measures) {
  if (!measures.is_object())
    return measures.is_null();
  for (const auto& [name, value] : measures.items()) {
    const bool is_none =
        value.is_null() || (value.is_string() && value.get_ref<const std::string&>().empty());
    if (!is_none && !value.is_number())
      return false;
    measure_named(row, name).value = is_none ? std::nullopt : std::optional(value.get<double>());
  }
  return true;
}

bool read_measure_units(StudyRow& row, const Value& units) {
  if (!units.is_object())
    return false;
  for (const auto& [name, unit] : units.items())
    if (!unit.is_string())
      return false;
    else
      measure_named(row, name).unit = unit.get<std::string>();
  return true;
}

/// True for numeric result columns.
bool is_response(const Column& column) {
  return !column.csv.empty() && (column.is_real || column.csv == "bytes" || column.csv == "iterations") &&
         column.csv != "processor_share" && column.csv != "load_average";
}

void add_measures(Table& columns) {
  columns
      .add({"", "measures", "", "NAME of each [[measure]], of vectors NAME_x, _y, _z; NAME_error"},
           measures_of)
      .omitted()
      .open()
      .read_by("an object of numbers", read_measures);
  columns.add({"", "measure_units", "", "of each of those that has one"}, measure_units_of)
      .omitted()
      .read_by("an object of texts", read_measure_units);
}

void add_case(Table& columns) {
  columns.add({"study", "study", "", "its name"}, &StudyRow::study);
  columns.add({"case", "case", "", "its number, from 1"}, &StudyRow::number);
  columns.add({"cases", "cases", "", "of the whole study"}, &StudyRow::n_cases);
  columns.add({"scene", "scene", "", "its name"}, &StudyRow::scene);
  columns.add({"", "parameters", "", "the value of each"}, parameters_of)
      .open()
      .read_by("an object of numbers and texts", read_parameters);
  add_method(columns, &StudyRow::method);
  add_status(columns, &StudyRow::status);
  columns
      .add({"", "cut", "", "allowed: by the scene's limits"},
           [](const StudyRow& row) { return row.cut_is_allowed ? Value("allowed") : Value(); })
      .omitted()
      .read_by("\"allowed\"", [](StudyRow& row, const Value&) { return row.cut_is_allowed = true; });
}

void add_cost(Table& columns) {
  add_seconds(columns, &StudyRow::seconds);
  add_total(columns, &StudyRow::total_seconds);
  columns.add({"repetitions", "repetitions", "", "that seconds are the medians of"}, &StudyRow::repetitions);
  columns.add({"timing", "timing", "", "whether seconds may be believed"}, &StudyRow::timing);
  columns.add({"processor_share", "processor_share", "", "processor seconds over wall seconds"},
              &StudyRow::processor_share);
  columns.add({"load_average", "load_average", "", "of one minute, as the case began"},
              &StudyRow::load_average);
  add_bytes(columns, &StudyRow::bytes);
  add_iterations(columns, &StudyRow::iterations);
  add_limit_violation(columns, &StudyRow::limit_violation).omitted();
}

void add_mechanics(Table& columns) {
  columns.add({"force", "force", "N", "on all moves together, its size"}, &StudyRow::force).omitted();
  columns.add({"strain_energy", "strain_energy", "J", "elastic"}, &StudyRow::strain_energy).omitted();
  add_test(columns, &StudyRow::test);
}

void add_origin(Table& columns) {
  columns.add({"dimension", "dimension", "", "0 where the scene is faulty"}, &StudyRow::dimension);
  columns.add({"cells", "cells", "", "of matter"}, &StudyRow::cells);
  columns.add({"nodes", "nodes", "", "of matter"}, &StudyRow::nodes);
  columns.add({"threads", "threads", "", "of the method"}, &StudyRow::threads);
  columns.add({"algorithm", "algorithm", "", "that the method took"}, &StudyRow::algorithm)
      .json_behind("reference_error.rms");
  columns.add({"maille", "maille", "", "its version"}, &StudyRow::maille);
  columns.add({"hash", "hash", "", "SHA-256 of what the case asks"}, &StudyRow::hash);
  columns.add({"vtk", "vtk", "", "file for ParaView beside the table"}, &StudyRow::vtk);
  columns.add({"message", "message", "", "why the method ended"}, &StudyRow::message).json_behind("status");
  columns
      .add({"", "of_machine", "", "whether it failed through the machine"},
           [](const StudyRow& row) { return row.is_of_machine ? Value(true) : Value(); })
      .omitted()
      .read_by("true or false",
               [](StudyRow& row, const Value& value) { return read_value(value, row.is_of_machine); });
}

} // namespace

const Table& columns_of_study() {
  static const Table table([](Table& columns) {
    add_case(columns);
    add_norms(columns, "", "error", &StudyRow::error);
    add_cost(columns);
    add_mechanics(columns);
    add_measures(columns);
    columns.add({"reference", "reference", "", "that errors are measured against"}, &StudyRow::reference);
    add_norms(columns, "reference_", "reference_error", &StudyRow::reference_error);
    add_origin(columns);
  });
  return table;
}

std::string_view to_string(Timing timing) {
  switch (timing) {
  case Timing::alone:
    return "alone";
  case Timing::busy:
    return "busy";
  case Timing::side_by_side:
    break;
  }
  return "side_by_side";
}

nlohmann::ordered_json json(const StudyRow& row) {
  return columns_of_study().json(row);
}

std::string json_line(const StudyRow& row) {
  // Messages may quote a file's contents: invalid UTF-8 in them must not lose the row.
  return json(row).dump(-1, ' ', false, Value::error_handler_t::replace);
}

std::vector<std::string> study_columns() {
  return columns_of_study().csv_names();
}

std::vector<std::string> study_responses() {
  std::vector<std::string> names;
  for (const Column& column : columns_of_study().list())
    if (is_response(column))
      names.push_back(column.csv);
  return names;
}

std::string StudyParameter::column() const {
  return unit.empty() ? label : fmt::format("{} [{}]", label, unit);
}

void name_case(StudyRow& row, const StudyFile& study, const StudyCase& one) {
  row.study = study.name();
  row.scene = study.scenes[one.scene].name();
  row.number = one.number;
  row.parameters.clear();
  for (std::size_t p = 0; p < study.n_varied(); ++p)
    row.parameters.emplace_back(study.varied(p).column(), one.values[p].shown);
  std::vector<StudyMeasure> measures; // all rows of a table have the same columns
  for (const MeasureColumn& column : study.measures) {
    const auto known = std::ranges::find(row.measures, column.name, &StudyMeasure::name);
    measures.push_back({column.name, column.unit, known == row.measures.end() ? std::nullopt : known->value});
  }
  row.measures = std::move(measures);
}

StudyRow blank_row(const StudyFile& study, const StudyCase& one, const std::string& method,
                   const std::string& hash, const StudyOptions& options) {
  StudyRow row;
  name_case(row, study, one);
  row.method = method;
  row.reference = study.reference;
  row.repetitions = method == study.reference ? 1 : study.repetitions;
  row.threads = options.threads;
  row.maille = version;
  row.hash = hash;
  return row;
}

} // namespace maille::studies
