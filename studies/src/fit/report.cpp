#include "maille/studies/fit_report.hpp"

#include "maille/studies/methods.hpp"
#include "maille/studies/version.hpp"

#include "maille/scene/compare.hpp"
#include "text.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

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

std::string rows_as_text(const std::vector<FitRow>& rows) {
  std::string text;
  for (const FitRow& row : rows)
    text += fmt::format("  {:<24} {:<10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", row.scene,
                        to_string(row.error.status), in_percent(row.before), in_percent(row.taut),
                        in_percent(row.error.relative_l2), in_percent(row.error.component[0]),
                        in_percent(row.error.component[1]), in_percent(row.error.component[2]),
                        in_percent(row.alone), in_percent(row.least()));
  return text + fmt::format("  {:<24} {:<10} {:>9} {:>9} {:>9} {:>39} {:>9}\n", "root mean square", "", "",
                            in_percent(mean_taut(rows)), in_percent(mean_error(rows)), "",
                            in_percent(mean_least(rows)));
}

nlohmann::ordered_json rows_as_json(const std::vector<FitRow>& rows) {
  nlohmann::ordered_json out{{"relative_l2", json_number(mean_error(rows))},
                             {"taut", json_number(mean_taut(rows))},
                             {"at_least", json_number(mean_least(rows))},
                             {"scenes", nlohmann::ordered_json::array()}};
  for (const FitRow& row : rows)
    out["scenes"].push_back({{"scene", row.scene},
                             {"status", to_string(row.error.status)},
                             {"before", json_number(row.before)},
                             {"taut", json_number(row.taut)},
                             {"relative_l2", json_number(row.error.relative_l2)},
                             {"components", row.error.component},
                             {"alone", json_number(row.alone)},
                             {"at_least", json_number(row.least())},
                             {"at_least_by_component", row.floor}});
  return out;
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
  text += fmt::format("\n{:<26} {:<10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "L2 error",
                      "status", "before", "taut", "now", "of x", "of y", "of z", "alone", "at least");
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
  nlohmann::ordered_json out{{"maille", version},
                             {"method", report.method},
                             {"reference", report.reference},
                             {"status", to_string(report.fit.status)},
                             {"trials", report.fit.evaluations},
                             {"materials", nlohmann::ordered_json::array()},
                             {"numbers", nlohmann::ordered_json::array()}};
  for (const Material& material : report.fit.materials)
    out["materials"].push_back({{"name", material.name},
                                {"limits",
                                 {{"stretch", material.limits->stretch},
                                  {"compress", material.limits->compress},
                                  {"shear", material.limits->shear}}},
                                {"relaxed_weights", material.relaxed_weights}});
  for (const FittedNumber& n : report.fit.numbers)
    out["numbers"].push_back({{"material", n.material},
                              {"name", n.name},
                              {"value", n.value},
                              {"determined", n.is_determined},
                              {"at_end_of_range", n.is_at_end}});
  out["fitted"] = rows_as_json(report.fitted);
  out["held_out"] = rows_as_json(report.held_out);
  out["reasons"] = report.reasons;
  return out;
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
