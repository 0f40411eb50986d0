#include "fit/fit.hpp"

#include "compare/methods.hpp"
#include "maille/studies/version.hpp"

#include "maille/scene/answer.hpp"
#include "results/scene_tables.hpp"
#include "text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <map>

namespace maille::studies {

namespace {

/// sqrt of the mean of squares of `value(row)`; nothing where a row has none.
template<class Value>
std::optional<double> mean_of(const std::vector<FitRow>& rows, const Value& value) {
  double sum = 0;
  for (const FitRow& row : rows) {
    const std::optional<double> of_row = value(row);
    if (!of_row)
      return std::nullopt;
    sum += *of_row * *of_row;
  }
  return rows.empty() ? 0 : std::sqrt(sum / static_cast<double>(rows.size()));
}

std::optional<double> mean_least(const std::vector<FitRow>& rows) {
  return mean_of(rows, [](const FitRow& row) { return std::optional(row.least()); });
}
std::optional<double> mean_taut(const std::vector<FitRow>& rows) {
  return mean_of(rows, [](const FitRow& row) { return row.taut; });
}

/// Within taut limits, in which every scene finds its own scale.
std::optional<double> error_within_taut(const FitCase& one, const std::string& method,
                                        const Control& control) {
  Scene scene = one.scene;
  scene.limits = {};
  scene.limits.from = LimitSource::taut;
  const Answer answer = answer_by(scene, method, control);
  if (!has_displacement(answer.status))
    return std::nullopt;
  return compare(scene, answer.displacement, one.reference).relative_l2;
}

/// Under the name of their material where there are several.
std::string numbers_as_text(const Fit& fit) {
  std::string text, material;
  for (const FittedNumber& n : fit.numbers) {
    if (fit.materials.size() > 1 && n.material != material)
      text += (material.empty() ? "" : "\n") + n.material + "\n";
    material = n.material;
    text += fmt::format("  {:<18} {:.6g}{}\n", n.name, n.value,
                        !n.is_determined ? "   (not determined: no answer of the family depends on it here)"
                        : n.is_at_end    ? "   (at the end of the range that was searched)"
                                         : "");
  }
  return text;
}

const ResultTable<FitRow>& columns_of_fit() {
  static const ResultTable<FitRow> table([](ResultTable<FitRow>& columns) {
    constexpr auto error = &FitRow::error;
    columns.add({"", "scene", "", "its name"}, {"L2 error", -26}, &FitRow::scene);
    columns.add({"", "status", "", "how the method ended"}, {"status", -10}, error, &FitError::status);
    columns.add({"", "before", "", "as the scene itself has it"}, {"before", 9, in_percent}, &FitRow::before);
    columns.add({"", "taut", "", "within taut limits"}, {"taut", 9, in_percent}, &FitRow::taut);
    columns.add({"", "relative_l2", "", "|u - r| / |r|"}, {"now", 9, in_percent}, error,
                &FitError::relative_l2);
    columns.add({"", "components", "", "its share along every axis"}, error, &FitError::component);
    for (std::size_t axis = 0; axis < 3; ++axis)
      columns.add({"", "", "", "its share along that axis"},
                  {fmt::format("of {}", "xyz"[axis]), 9, in_percent},
                  [axis](const FitRow& row) { return row.error.component[axis]; });
    columns.add({"", "alone", "", "fitted to this scene alone"}, {"alone", 9, in_percent}, &FitRow::alone);
    columns.add({"", "at_least", "", "that nothing can reach"}, {"at least", 9, in_percent}, &FitRow::least);
    columns.add({"", "at_least_by_component", "", "its share along every axis"}, &FitRow::floor);
  });
  return table;
}

std::string rows_as_text(const std::vector<FitRow>& rows) {
  const ResultTable<FitRow>& columns = columns_of_fit();
  std::string text;
  for (FitRow row : rows) {
    row.scene.insert(0, "  ");
    text += columns.text_line_of(columns.values(row));
  }
  const auto known = [](std::optional<double> mean) { return Value(mean.value_or(std::nan(""))); };
  const std::map<std::string, Value> means{{"scene", "  root mean square"},
                                           {"taut", known(mean_taut(rows))},
                                           {"relative_l2", mean_error(rows)},
                                           {"at_least", known(mean_least(rows))}};
  Values last;
  for (const Column& column : columns.list())
    last.push_back(means.contains(column.json) ? means.at(column.json) : Value());
  return text + columns.text_line_of(last, "");
}

const ResultTable<std::vector<FitRow>>& columns_of_family() {
  using Rows = std::vector<FitRow>;
  static const ResultTable<Rows> table([](ResultTable<Rows>& columns) {
    columns.add({"", "relative_l2", "", "root mean square over the scenes"},
                [](const Rows& rows) { return mean_error(rows); });
    columns.add({"", "taut", "", "the same within taut limits"}, mean_taut);
    columns.add({"", "at_least", "", "the same of what nothing can reach"}, mean_least);
    columns.add_rows({"", "scenes", "", "a row each"}, columns_of_fit(),
                     [](const Rows& rows) { return rows; });
  });
  return table;
}

const ResultTable<Material>& columns_of_materials() {
  static const ResultTable<Material> table([](ResultTable<Material>& columns) {
    columns.add({"", "name", "", "of the material"}, &Material::name);
    columns.add_row({"", "limits", "", "of links, along its axes"}, columns_of_limits(), &Material::limits);
    columns.add({"", "relaxed_weights", "", "along axes 1, 2, 3"}, &Material::relaxed_weights);
  });
  return table;
}

const ResultTable<FittedNumber>& columns_of_numbers() {
  static const ResultTable<FittedNumber> table([](ResultTable<FittedNumber>& columns) {
    columns.add({"", "material", "", "its name"}, &FittedNumber::material);
    columns.add({"", "name", "", "as in the material's file"}, &FittedNumber::name);
    columns.add({"", "value", "", "that fits best"}, &FittedNumber::value);
    columns.add({"", "determined", "", "whether an answer depends on it"}, &FittedNumber::is_determined);
    columns.add({"", "at_end_of_range", "", "that was searched"}, &FittedNumber::is_at_end);
  });
  return table;
}

const ResultTable<FitReport>& columns_of_report() {
  static const ResultTable<FitReport> table([](ResultTable<FitReport>& columns) {
    constexpr auto fit = &FitReport::fit;
    columns.add({"", "maille", "", "version"}, [](const FitReport&) { return version; });
    columns.add({"", "method", "", "whose numbers are fitted"}, &FitReport::method);
    columns.add({"", "reference", "", "that it is to come near to"}, &FitReport::reference);
    columns.add({"", "status", "", "how the search ended"}, fit, &Fit::status);
    columns.add({"", "trials", "", "of the family"}, fit, &Fit::evaluations);
    columns.add_rows({"", "materials", "", "a row each"}, columns_of_materials(), fit, &Fit::materials);
    columns.add_rows({"", "numbers", "", "a row each"}, columns_of_numbers(), fit, &Fit::numbers);
    columns.add_row({"", "fitted", "", "scenes fitted to"}, columns_of_family(), &FitReport::fitted);
    columns.add_row({"", "held_out", "", "scenes kept from the fit"}, columns_of_family(),
                    &FitReport::held_out);
    columns.add({"", "reasons", "", "what to know about it, in words"}, &FitReport::reasons);
  });
  return table;
}

} // namespace

double FitRow::least() const {
  return std::hypot(floor[0], floor[1], floor[2]);
}

FitRow fit_row(const FitCase& one, const FitError& error, std::optional<double> alone,
               const std::string& method, const Control& control) {
  FitRow row{one.scene.name, error, std::nullopt, alone, unreachable(one), std::nullopt};
  Control quiet;
  quiet.threads = control.threads;
  if (const Answer own = answer_by(one.scene, method, quiet); has_displacement(own.status))
    row.before = compare(one.scene, own.displacement, one.reference).relative_l2;
  row.taut = error_within_taut(one, method, quiet);
  return row;
}

double mean_error(std::span<const FitRow> rows) {
  std::vector<FitError> errors;
  for (const FitRow& row : rows)
    errors.push_back(row.error);
  return mean_error(errors);
}

std::string table(const FitReport& report) {
  std::string text = fmt::format("{} fitted to {}: {}, {} trials\n\n", report.method, report.reference,
                                 to_string(report.fit.status), report.fit.evaluations);
  text += numbers_as_text(report.fit);
  text += "\n" + columns_of_fit().text(std::vector<FitRow>{});
  text += "fitted to\n" + rows_as_text(report.fitted);
  if (!report.held_out.empty())
    text += "not fitted to\n" + rows_as_text(report.held_out);
  if (!report.reasons.empty())
    text += "\nwhat to know about it\n";
  for (const std::string& reason : report.reasons)
    text += "  " + reason + "\n";
  return text;
}

nlohmann::ordered_json json(const FitReport& report) {
  return columns_of_report().json(report);
}

std::vector<std::string> notes(const FitReport& report) {
  const auto names = [](const std::vector<FitRow>& rows) {
    std::string list;
    for (const FitRow& row : rows)
      list += (list.empty() ? "" : ", ") + row.scene;
    return list;
  };
  return {fmt::format("Made by maille fit {}: {} against {}, {}.", version, report.method, report.reference,
                      to_string(report.fit.status)),
          fmt::format("Fitted to {}: {} off.", names(report.fitted), in_percent(mean_error(report.fitted))),
          report.held_out.empty() ? "No scene was kept from the fit."
                                  : fmt::format("Not fitted to {}: {} off.", names(report.held_out),
                                                in_percent(mean_error(report.held_out))),
          report.method == "limits"
              ? "Limits are along the materials' axes; axis 1 is the fibre."
              : "Only the weights are fitted: the limits stand where no small strain comes."};
}

} // namespace maille::studies
