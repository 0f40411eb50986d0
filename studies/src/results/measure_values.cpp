#include "results/measure_values.hpp"

#include "maille/scene/plausibility.hpp"
#include "results/result_table.hpp"
#include "text.hpp"

#include <algorithm>
#include <numbers>

namespace maille::studies {

namespace {

std::string value_in_words(const MeasuredValue& value) {
  if (!value.is_line)
    return value.value ? measure_in_words(*value.value, value.unit) : value.why_not;
  std::optional<double> least, most;
  for (const LinePoint& point : value.line)
    if (point.value) {
      least = std::min(least.value_or(*point.value), *point.value);
      most = std::max(most.value_or(*point.value), *point.value);
    }
  return least ? fmt::format("{} to {}", measure_in_words(*least, value.unit),
                             measure_in_words(*most, value.unit))
               : value.why_not;
}

const ResultTable<MeasureLine>& columns_of_lines() {
  static const ResultTable<MeasureLine> table([](ResultTable<MeasureLine>& columns) {
    constexpr auto value = &MeasureRow::value;
    columns.add({"", "", "", "its name"}, {"measure", -16}, &MeasureLine::row, value, &MeasuredValue::name);
    columns.add({"", "", "", "that answered"}, {"method", -18}, &MeasureLine::whose);
    columns.add({"", "", "", "in the unit that suits it"}, {"value", 24}, &MeasureLine::row, value,
                value_in_words);
    columns.add({"", "", "", "against the reference's"}, {"error", 10, in_percent, true}, &MeasureLine::row,
                &MeasureRow::error);
    columns.add({"", "", "", "x, y and z of the world"}, {" vector", 0, nullptr, true}, &MeasureLine::row,
                [](const MeasureRow& row) {
                  return row.value.vector ? std::optional(fmt::format(
                                                " {} {}", vector_in_words(*row.value.vector), row.value.unit))
                                          : std::nullopt;
                });
  });
  return table;
}

nlohmann::ordered_json point_json(const LinePoint& point, bool is_vector) {
  nlohmann::ordered_json out{{"along", point.along}, {"place", point.place}, {"value", nullptr}};
  out["value"] = json_number(point.value);
  if (is_vector)
    out["vector"] = point.vector ? nlohmann::ordered_json(*point.vector) : nullptr;
  return out;
}

bool is_of_vectors(const MeasuredValue& value) {
  return std::ranges::any_of(value.line, [](const LinePoint& point) { return point.vector.has_value(); });
}

} // namespace

std::vector<MeasureRow> with_errors(std::vector<MeasuredValue> values,
                                    const std::vector<MeasuredValue>& reference) {
  std::vector<MeasureRow> rows;
  for (MeasuredValue& value : values) {
    const std::size_t i = rows.size();
    const std::optional<double> error =
        i < reference.size() ? relative_error(value, reference[i]) : std::nullopt;
    rows.push_back({std::move(value), error});
  }
  return rows;
}

std::vector<MeasureRow> without_values(const std::vector<Measure>& measures, int dimension,
                                       const std::string& why) {
  std::vector<MeasureRow> rows;
  for (const Measure& measure : measures) {
    MeasuredValue& value = rows.emplace_back().value;
    value.name = measure.name;
    value.unit = unit_of(measure, dimension);
    value.is_line = measure.is_line;
    value.is_vector = measure.is_vector() && !measure.is_line;
    value.why_not = why;
  }
  return rows;
}

nlohmann::ordered_json measures_json(const std::vector<MeasureRow>& rows) {
  auto list = nlohmann::ordered_json::array();
  for (const MeasureRow& row : rows) {
    const MeasuredValue& value = row.value;
    nlohmann::ordered_json& out = list.emplace_back(nlohmann::ordered_json{{"name", value.name}});
    out["unit"] = value.unit;
    if (value.is_line) {
      out["line"] = nlohmann::ordered_json::array();
      for (const LinePoint& point : value.line)
        out["line"].push_back(point_json(point, is_of_vectors(value)));
    } else {
      out["value"] = json_number(value.value);
      if (value.is_vector)
        out["vector"] = value.vector ? nlohmann::ordered_json(*value.vector) : nullptr;
    }
    if (!value.why_not.empty())
      out["why_not"] = value.why_not;
  }
  return list;
}

nlohmann::ordered_json measure_errors_json(const std::vector<MeasureRow>& rows) {
  nlohmann::ordered_json out;
  for (const MeasureRow& row : rows)
    if (row.error)
      out[row.value.name] = json_number(row.error);
  return out;
}

nlohmann::ordered_json measure_cells(const std::vector<MeasureRow>& rows, bool with_error) {
  nlohmann::ordered_json cells;
  for (const MeasureRow& row : rows) {
    for (const auto& [column, value] : row.value.columns())
      cells[column] = value ? nlohmann::ordered_json(*value) : nullptr;
    if (with_error)
      cells[row.value.name + "_error"] = row.error ? nlohmann::ordered_json(*row.error) : nullptr;
  }
  return cells;
}

std::vector<MeasureLine> lines_of(const std::string& whose, const std::vector<MeasureRow>& rows) {
  std::vector<MeasureLine> lines;
  for (const MeasureRow& row : rows)
    lines.push_back({whose, &row});
  return lines;
}

std::string measures_in_words(const std::vector<MeasureLine>& answers) {
  std::vector<MeasureLine> sorted;
  for (const MeasureLine& first : answers) {
    const auto is_of_it = [&](const MeasureLine& line) {
      return line.row->value.name == first.row->value.name;
    };
    if (std::ranges::none_of(sorted, is_of_it))
      std::ranges::copy_if(answers, std::back_inserter(sorted), is_of_it);
  }
  return sorted.empty() ? "" : columns_of_lines().text(sorted);
}

std::string measure_steps_in_words(const std::vector<MeasureStep>& steps) {
  constexpr std::size_t least_width = 12;
  std::string text;
  for (const MeasureStep& step : steps) {
    std::string head = fmt::format("{:>6} {:>9}", "step", "fraction"),
                line = fmt::format("{:>6} {:>9}", step.step, in_percent(step.fraction));
    bool has_any = false;
    for (const MeasureRow& row : step.rows) {
      if (row.value.is_line)
        continue;
      const std::size_t width = std::max(least_width, row.value.name.size());
      head += fmt::format(" {:>{}}", row.value.name, width);
      line += fmt::format(" {:>{}}",
                          row.value.value ? measure_in_words(*row.value.value, row.value.unit) : "-", width);
      has_any = true;
    }
    if (has_any)
      text += (text.empty() ? head + "\n" : "") + line + "\n";
  }
  return text;
}

std::string measure_steps_csv(const std::vector<MeasureStep>& steps) {
  std::string text;
  for (const MeasureStep& step : steps) {
    std::string head = "step,fraction", line = fmt::format("{},{:.9g}", step.step, step.fraction);
    for (const MeasureRow& row : step.rows)
      for (const auto& [column, value] : row.value.columns()) {
        head += "," + column;
        line += "," + csv_number(value, 9);
      }
    if (head != "step,fraction")
      text += (text.empty() ? head + "\n" : "") + line + "\n";
  }
  return text;
}

std::string measure_in_words(double value, std::string_view unit) {
  if (unit.empty())
    return in_percent(value);
  if (unit == "m")
    return length_in_words(value);
  if (unit == "Pa")
    return in_pascals(value);
  if (unit == "rad")
    return fmt::format("{:.4g} deg", value * 180 / std::numbers::pi);
  if (unit == "m^3")
    return fmt::format("{:.5g} mm^3", 1e9 * value);
  if (unit == "m^2")
    return fmt::format("{:.5g} mm^2", 1e6 * value);
  return fmt::format("{:.4g} {}", value, unit);
}

std::string vector_in_words(std::span<const double> vector) {
  double largest = 0;
  for (const double component : vector)
    largest = std::max(largest, std::abs(component));
  std::string text;
  for (const double component : vector)
    text += fmt::format("{}{:.4g}", text.empty() ? "(" : ", ",
                        std::abs(component) > 1e-6 * largest ? component : 0);
  return text + ")";
}

std::string line_csv(const MeasuredValue& value) {
  const bool is_vector = is_of_vectors(value);
  std::string text = "along_m,x_m,y_m,z_m," + value.name +
                     (is_vector ? fmt::format(",{0}_x,{0}_y,{0}_z", value.name) : "") + "\n";
  for (const LinePoint& point : value.line) {
    text += fmt::format("{:.9g},{:.9g},{:.9g},{:.9g},{}", point.along, point.place[0], point.place[1],
                        point.place[2], csv_number(point.value, 9));
    for (std::size_t a = 0; a < 3 && is_vector; ++a)
      text += "," + csv_number(point.vector ? std::optional((*point.vector)[a]) : std::nullopt, 9);
    text += "\n";
  }
  return text;
}

} // namespace maille::studies
