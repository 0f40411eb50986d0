#include "study/study_sensitivity.hpp"

#include "results/result_table.hpp"
#include "study/plan/read_parameter.hpp"
#include "study/response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// Positions of a parameter's values in [-1, 1].
class Positions {
public:
  explicit Positions(const StudyParameter& parameter) : parameter_(parameter) {
    if (parameter.values.empty() && parameter.range) {
      from_ = parameter.range->from;
      to_ = parameter.range->to;
      is_logarithmic_ = parameter.range->is_logarithmic;
      return;
    }
    is_of_numbers_ = std::ranges::all_of(parameter.values, [](const StudyValue& value) {
      return std::holds_alternative<double>(value.shown) && std::isfinite(std::get<double>(value.shown));
    });
    from_ = 0;
    to_ = static_cast<double>(parameter.values.size()) - 1;
    if (is_of_numbers_) {
      from_ = INFINITY, to_ = -INFINITY;
      for (const StudyValue& value : parameter.values) {
        from_ = std::min(from_, std::get<double>(value.shown));
        to_ = std::max(to_, std::get<double>(value.shown));
      }
      is_logarithmic_ = from_ > 0 && to_ >= 30 * from_;
    }
    for (const StudyValue& value : parameter.values)
      axis_.levels.push_back(of(value));
  }

  double of(const StudyValue& value) const {
    double at = 0;
    if (is_of_numbers_)
      at = std::get<double>(value.shown);
    else // texts have no distances: their places in the list
      at = static_cast<double>(std::ranges::find(parameter_.values, value.shown, &StudyValue::shown) -
                               parameter_.values.begin());
    const double ratio =
        is_logarithmic_ ? std::log(at / from_) / std::log(to_ / from_) : (at - from_) / (to_ - from_);
    return std::isfinite(ratio) ? 2 * ratio - 1 : 0;
  }
  const SampledAxis& axis() const { return axis_; }

private:
  const StudyParameter& parameter_;
  double from_ = 0, to_ = 1;
  bool is_of_numbers_ = true, is_logarithmic_ = false;
  SampledAxis axis_;
};

/// The cases of a study's first scene, which are those of every scene.
class Plan {
public:
  explicit Plan(const StudyFile& study) : study_(study) {
    n_points_ = n_cases(study) / static_cast<std::int64_t>(study.scenes.size());
    std::vector<Positions> positions;
    for (const StudyParameter& parameter : study.parameters) {
      positions.emplace_back(parameter);
      samples_.axes.push_back(positions.back().axis());
    }
    const std::vector<StudyCase> all = cases(study);
    for (std::int64_t i = 0; i < n_points_; ++i) {
      std::vector<double>& point = samples_.points.emplace_back();
      for (std::size_t p = 0; p < positions.size(); ++p)
        point.push_back(positions[p].of(all[i].values[p]));
    }
  }

  /// By point; nothing where no row has a value.
  std::vector<std::optional<double>> values(const std::vector<StudyRow>& rows, const std::string& scene,
                                            const std::string& method, const Response& response) const {
    std::vector<std::optional<double>> values(static_cast<std::size_t>(n_points_));
    for (const StudyRow& row : rows)
      if (row.scene == scene && row.method == method && row.number > 0)
        values[(row.number - 1) % n_points_] = response.value(row);
    return values;
  }

  Sensitivity of(const std::vector<std::optional<double>>& values) const {
    if (study_.combination == Combination::zip) {
      Sensitivity none;
      none.first.resize(study_.parameters.size());
      none.total.resize(study_.parameters.size());
      none.undetermined = "the parameters are zipped: what one does cannot be told from what the others do";
      return none;
    }
    if (study_.combination == Combination::saltelli)
      return sobol_by_pairs(static_cast<int>(study_.parameters.size()), values);
    if (study_.combination == Combination::grid &&
        std::ranges::all_of(values, [](const auto& value) { return value.has_value(); })) {
      std::vector<int> counts;
      for (const StudyParameter& parameter : study_.parameters)
        counts.push_back(static_cast<int>(parameter.values.size()));
      return sobol_by_grid(counts, values);
    }
    SampledValues samples = samples_;
    samples.values = values;
    return sobol_by_chaos(samples);
  }

private:
  const StudyFile& study_;
  std::int64_t n_points_ = 0;
  SampledValues samples_; ///< without values
};

/// One line of the table for people.
struct SensitivityLine {
  std::string scene, method, parameter;
  SobolIndex first, total;
};

std::string in_words(const SobolIndex& index) {
  if (!index.value)
    return "-";
  return *index.low == *index.high
             ? fmt::format("{:.3f}", *index.value)
             : fmt::format("{:.3f} ({:.2f} to {:.2f})", *index.value, *index.low, *index.high);
}

void add_index(ResultTable<SensitivityLine>& columns, const std::string& key, const std::string& meaning,
               const std::string& heading, SobolIndex SensitivityLine::*index) {
  columns.add({"", key, "", meaning}, index, &SobolIndex::value);
  columns.add({"", key + "_low", "", "of the interval of 95 %"}, index, &SobolIndex::low);
  columns.add({"", key + "_high", "", "of the interval of 95 %"}, index, &SobolIndex::high);
  columns.add({"", "", "", meaning}, {heading, 24},
              [index](const SensitivityLine& line) { return in_words(line.*index); });
}

const ResultTable<SensitivityLine>& columns_of_sensitivity() {
  static const ResultTable<SensitivityLine> table = [] {
    ResultTable<SensitivityLine> columns;
    columns.add({"", "", "", ""}, {"scene", -14}, &SensitivityLine::scene);
    columns.add({"", "", "", ""}, {"method", -9}, &SensitivityLine::method);
    columns.add({"", "parameter", "", "its column"}, {"parameter", -30}, &SensitivityLine::parameter);
    add_index(columns, "first", "share of the variance that it makes alone", "alone",
              &SensitivityLine::first);
    add_index(columns, "total", "share of the variance in which it takes part", "with others",
              &SensitivityLine::total);
    return columns;
  }();
  return table;
}

std::vector<SensitivityLine> lines_of(const StudySensitivity& one) {
  std::vector<SensitivityLine> lines;
  for (std::size_t p = 0; p < one.parameters.size(); ++p)
    lines.push_back({one.scene, one.method, one.parameters[p], one.found.first[p], one.found.total[p]});
  return lines;
}

std::string note_of(const StudySensitivity& one) {
  const Sensitivity& found = one.found;
  std::string text = fmt::format("{}, {}: ", one.scene, one.method);
  if (!found.undetermined.empty())
    text += "undetermined: " + found.undetermined;
  else
    text += fmt::format("by {}, {} samples", found.estimator, found.n_used);
  if (found.n_left_out > 0)
    text += fmt::format(", {} without a value left out", found.n_left_out);
  if (found.undetermined.empty() && found.unexplained > 0)
    text += fmt::format(", {:.2g} % of the variance unexplained", 100 * found.unexplained);
  return text + "\n";
}

} // namespace

std::vector<StudySensitivity> sensitivities(const StudyFile& study, const std::vector<StudyRow>& rows) {
  std::vector<StudySensitivity> all;
  if (study.parameters.size() < 2 || rows.empty())
    return all;
  const Plan plan(study);
  std::vector<std::string> parameters;
  for (const StudyParameter& parameter : study.parameters)
    parameters.push_back(parameter.column());
  for (const std::string& name : mechanical_responses(rows)) {
    const Response response = response_of(name, rows);
    for (const StudyScene& scene : study.scenes)
      for (const std::string& method : study.row_methods()) {
        const auto values = plan.values(rows, scene.name(), method, response);
        if (std::ranges::any_of(values, [](const auto& value) { return value.has_value(); }))
          all.push_back({scene.name(), method, name, response.label, parameters, plan.of(values)});
      }
  }
  return all;
}

nlohmann::ordered_json json(const std::vector<StudySensitivity>& all) {
  auto list = nlohmann::ordered_json::array();
  for (const StudySensitivity& one : all) {
    const Sensitivity& found = one.found;
    nlohmann::ordered_json entry{{"scene", one.scene},
                                 {"method", one.method},
                                 {"response", one.response},
                                 {"label", one.label},
                                 {"estimator", found.estimator},
                                 {"samples", found.n_used},
                                 {"left_out", found.n_left_out},
                                 {"mean", found.mean},
                                 {"standard_deviation", found.deviation},
                                 {"unexplained", found.unexplained},
                                 {"undetermined", value_of(found.undetermined)},
                                 {"parameters", columns_of_sensitivity().json_rows(lines_of(one))}};
    list.push_back(std::move(entry));
  }
  return list;
}

std::string in_words(const std::vector<StudySensitivity>& all, const std::string& response) {
  std::vector<SensitivityLine> lines;
  std::string notes, label;
  for (const StudySensitivity& one : all)
    if (one.response == response) {
      label = one.label;
      notes += note_of(one);
      if (one.found.undetermined.empty())
        for (SensitivityLine& line : lines_of(one))
          lines.push_back(std::move(line));
    }
  if (label.empty())
    return "";
  return fmt::format("Sobol indices of {}: shares of its variance, intervals of 95 %\n", label) +
         (lines.empty() ? "" : columns_of_sensitivity().text(lines)) + notes + "\n";
}

} // namespace maille::studies
