#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "median.hpp"
#include "page_parts.hpp"
#include "results/measure_values.hpp"
#include "study/plan/study_table.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <set>

namespace maille::studies {

namespace {

/// More points in a plot cannot be told apart, and make the page heavy.
constexpr std::size_t most_points = 4000;

/// Names below a key, in the order of the first row that has them, behind some.
std::vector<std::string> names_below(const char* key, const std::vector<PageData>& rows,
                                     std::vector<std::string> names = {}) {
  for (const PageData& row : rows) {
    const PageData below = at(row, key);
    for (const auto& [name, value] : below.items())
      if (std::ranges::find(names, name) == names.end())
        names.push_back(name);
  }
  return names;
}

/// Names of the scenes, in the order in which they come.
std::vector<std::string> scenes_of(const std::vector<PageData>& rows) {
  std::vector<std::string> names;
  for (const PageData& row : rows)
    if (const std::string name = plain(at(row, "scene")); std::ranges::find(names, name) == names.end())
      names.push_back(name);
  return names;
}

/// What the scenes ask for by name, with the force and the energy where there are some.
std::vector<std::string> measured_columns(const std::vector<PageData>& rows) {
  std::vector<std::string> names;
  for (const char* name : {"force", "strain_energy"})
    if (std::ranges::any_of(rows, [&](const PageData& row) { return at(row, name).is_number(); }))
      names.emplace_back(name);
  return names_below("measures", rows, std::move(names));
}

PageData measured_cell(const PageData& row, const std::string& name) {
  const bool is_own = at(row, "measures").contains(name);
  const PageData value = is_own ? at(row, "measures", name) : at(row, name);
  const PageData unit = at(row, "measure_units", name);
  const std::string in = is_own ? (unit.is_string() ? plain(unit) : "") : name == "force" ? "N" : "J";
  return number_cell(value.is_number() ? measure_in_words(value.get<double>(), in) : "–", value);
}

PageData cell_of(const PageData& value) {
  return value.is_number() ? number_cell(plain(value), value) : text_cell(plain(value));
}

PageData table_of(const std::vector<PageData>& rows, const std::vector<std::string>& parameters,
                  const std::string& id) {
  PageData table{{"id", id},
                 {"caption", fmt::format("All {} rows; a click on a header sorts", rows.size())},
                 {"columns", PageData::array()},
                 {"rows", PageData::array()}};
  PageData& columns = table["columns"];
  columns.push_back(column("case", true));
  const bool has_scenes = scenes_of(rows).size() > 1;
  if (has_scenes)
    columns.push_back(column("scene", false));
  for (const std::string& name : parameters)
    columns.push_back(column(name, std::ranges::any_of(rows, [&](const PageData& row) {
                               return at(row, "parameters", name).is_number();
                             })));
  for (const char* name : {"method", "status"})
    columns.push_back(column(name, false));
  for (const char* name : {"L2 error", "max error", "total", "memory", "iterations"})
    columns.push_back(column(name, true));
  const std::vector<std::string> measured = measured_columns(rows);
  for (const std::string& name : measured)
    columns.push_back(column(name == "strain_energy" ? "strain energy" : name, true));
  columns.push_back(column("message", false));
  for (const PageData& row : rows) {
    PageData cells{number_cell(plain(at(row, "case")), at(row, "case"))};
    if (has_scenes)
      cells.push_back(text_cell(plain(at(row, "scene"))));
    for (const std::string& name : parameters)
      cells.push_back(cell_of(at(row, "parameters", name)));
    cells.push_back(text_cell(plain(at(row, "method"))));
    cells.push_back(text_cell(plain(at(row, "status"))));
    for (const char* norm : {"relative_l2", "relative_max"})
      cells.push_back(number_cell(percent(at(row, "error", norm)), at(row, "error", norm)));
    cells.push_back(number_cell(seconds(at(row, "seconds", "total")), at(row, "seconds", "total")));
    cells.push_back(number_cell(bytes(at(row, "bytes")), at(row, "bytes")));
    cells.push_back(number_cell(plain(at(row, "iterations")), at(row, "iterations")));
    for (const std::string& name : measured)
      cells.push_back(measured_cell(row, name));
    cells.push_back(text_cell(at(row, "message").is_string() ? plain(at(row, "message")) : ""));
    table["rows"].push_back({{"cells", std::move(cells)}});
  }
  return table;
}

/// By method, the median error at every value of a parameter over all cases of a scene that share it. Empty
/// where it has one value, or words.
std::vector<ChartSeries> errors_over(const std::vector<PageData>& rows, const std::string& scene,
                                     const std::string& parameter) {
  std::vector<std::string> methods;
  std::map<std::string, std::map<double, std::vector<double>>> errors;
  std::set<double> values;
  for (const PageData& row : rows) {
    const PageData value = at(row, "parameters", parameter), error = at(row, "error", "relative_l2");
    if (plain(at(row, "scene")) != scene || !value.is_number() || !error.is_number() ||
        error.get<double>() <= 0)
      continue;
    const std::string method = plain(at(row, "method"));
    if (std::ranges::find(methods, method) == methods.end())
      methods.push_back(method);
    errors[method][value.get<double>()].push_back(error.get<double>());
    values.insert(value.get<double>());
  }
  std::vector<ChartSeries> series;
  for (const std::string& method : methods) {
    series.push_back({method, {}});
    for (const auto& [value, list] : errors[method])
      series.back().points.push_back({value, 100 * upper_median(list)});
  }
  return values.size() > 1 ? series : std::vector<ChartSeries>{};
}

bool spans_decades(const std::vector<ChartSeries>& series) {
  double least = std::numeric_limits<double>::infinity(), most = 0;
  for (const ChartSeries& one : series)
    for (const ChartPoint& point : one.points)
      least = std::min(least, point.x), most = std::max(most, point.x);
  return least > 0 && most >= 30 * least;
}

/// Error over every parameter, scene by scene.
void add_plots_over_parameters(const std::vector<PageData>& rows, const std::vector<std::string>& parameters,
                               PageData& run, PageDraft& draft) {
  const std::vector<std::string> scenes = scenes_of(rows);
  for (const std::string& scene : scenes)
    for (const std::string& parameter : parameters) {
      const auto series = errors_over(rows, scene, parameter);
      if (series.empty())
        continue;
      const std::string where = scenes.size() > 1 ? scene + ": " : "";
      if (auto figure = plot(
              {parameter, "relative L2 error [%], median", spans_decades(series), true, true, series},
              fmt::format("Plot of the median error of every method over {}{}; the table has the figures",
                          where, parameter),
              fmt::format("{}error over {}; at every value the median over all cases that share it", where,
                          parameter),
              draft))
        run["plots"].push_back(*figure);
    }
}

void add_plots(const std::vector<PageData>& rows, const std::vector<std::string>& parameters, PageData& run,
               PageDraft& draft) {
  run["plots"] = PageData::array();
  add_plots_over_parameters(rows, parameters, run, draft);
  SeriesByMethod over_time;
  const std::size_t stride = rows.size() / most_points + 1;
  for (std::size_t i = 0; i < rows.size(); i += stride) {
    const PageData error = at(rows[i], "error", "relative_l2"), time = at(rows[i], "seconds", "total");
    if (error.is_number() && time.is_number() && error.get<double>() > 0 && time.get<double>() > 0)
      over_time.add(plain(at(rows[i], "method")), 1e3 * time.get<double>(), 100 * error.get<double>());
  }
  if (!over_time.series.empty())
    if (auto figure = plot(
            {"time, set-up and solve [ms]", "relative L2 error [%]", true, true, false, over_time.series},
            "Plot of the error of every case and method over its time; the table has the figures",
            "What accuracy costs in time, one point a case and method", draft))
      run["plots"].push_back(*figure);
}

/// What the study is about over its parameters, as `study --picture` draws it; tables of older versions may
/// lack what that needs.
void add_response_picture(const std::filesystem::path& table, const std::string& title, PageData& run,
                          PageDraft& draft) {
  try {
    const std::vector<StudyRow> rows = read_study_table(table).rows;
    const std::string response = default_response(rows);
    const WorkFolder folder("maille_study_picture");
    const auto svg = folder / "picture.svg";
    if (draw_study(rows, title, svg, response))
      return;
    run["body"].push_back(
        {{"source", data_uri("image/svg+xml", bytes_of_file(svg))},
         {"look", "picture"},
         {"alt", fmt::format("{} over what was varied; the table has the figures", response)},
         {"caption", fmt::format("{} over what was varied", response)}});
  } catch (const InputError&) {
    return;
  } catch (const std::runtime_error& error) {
    draft.notes.emplace_back(error.what());
  }
}

/// Which parameter makes which share, as `study` has found.
std::optional<PageData> sensitivity_table(const PageData& about, const std::string& id, PageData& run) {
  const PageData all = at(about, "sensitivity");
  PageData table{
      {"id", id},
      {"caption", "Sobol indices: shares of the variance, with intervals of 95 %"},
      {"columns",
       {column("of", false), column("scene", false), column("method", false), column("parameter", false),
        column("alone", true, "first-order index"), column("with others", true, "total index")}},
      {"rows", PageData::array()}};
  const auto cell = [](const PageData& parameter, const std::string& key) {
    const PageData value = at(parameter, key), low = at(parameter, key + "_low"),
                   high = at(parameter, key + "_high");
    if (!value.is_number() || !low.is_number() || !high.is_number())
      return number_cell("–", nullptr);
    return number_cell(low == high ? fmt::format("{:.3f}", value.get<double>())
                                   : fmt::format("{:.3f} ({:.2f} to {:.2f})", value.get<double>(),
                                                 low.get<double>(), high.get<double>()),
                       value);
  };
  for (const PageData& one : all) {
    const std::string what =
        fmt::format("{}, {}, {}", plain(at(one, "label")), plain(at(one, "scene")), plain(at(one, "method")));
    if (const PageData why = at(one, "undetermined"); why.is_string() && !plain(why).empty()) {
      run["notes"].push_back(fmt::format("Sensitivity of {}: undetermined: {}.", what, plain(why)));
      continue;
    }
    for (const PageData& parameter : at(one, "parameters"))
      table["rows"].push_back(
          {{"cells",
            {text_cell(plain(at(one, "label"))), text_cell(plain(at(one, "scene"))),
             text_cell(plain(at(one, "method"))), text_cell(plain(at(parameter, "parameter"))),
             cell(parameter, "first"), cell(parameter, "total")}}});
  }
  return table["rows"].empty() ? std::nullopt : std::optional(table);
}

/// What the study asks, in a sentence.
std::string question_of_study(const std::vector<PageData>& rows, const std::vector<std::string>& parameters) {
  std::vector<std::string> varied;
  for (const std::string& name : parameters) {
    const PageData first = at(rows.front(), "parameters", name);
    if (std::ranges::any_of(rows, [&](const PageData& row) { return at(row, "parameters", name) != first; }))
      varied.push_back(name);
  }
  const bool has_forces =
      std::ranges::any_of(rows, [](const PageData& row) { return at(row, "force").is_number(); });
  const std::string what = has_forces ? "does the force depend" : "do the answers depend";
  return varied.empty() ? "What do the methods answer?"
                        : fmt::format("How {} on {}?", what, fmt::join(varied, " and "));
}

} // namespace

void add_study_section(const std::vector<PageData>& rows, const std::filesystem::path& table_file,
                       const PageData& about, PageDraft& draft) {
  const std::string name = table_file.stem().string();
  const std::vector<std::string> parameters = names_below("parameters", rows);
  std::set<std::int64_t> cases;
  std::size_t unsettled = 0;
  for (const PageData& row : rows) {
    if (at(row, "case").is_number_integer())
      cases.insert(at(row, "case").get<std::int64_t>());
    const std::string status = plain(at(row, "status"));
    unsettled += status != "done" && status != "clamped" ? 1 : 0;
  }
  const PageData all = at(rows.front(), "cases");
  const std::string study = at(rows.front(), "study").is_string() ? plain(at(rows.front(), "study")) : name;
  const PageData title = at(about, "title");
  PageData run{{"id", id_of(name)}, {"heading", "Study: " + (title.is_string() ? plain(title) : study)}};
  const std::vector<std::string> scenes = scenes_of(rows);
  run["summary"] =
      fmt::format("{} of {} cases, {} rows, {} of them not settled; {} {}, errors against {}.", cases.size(),
                  plain(all), rows.size(), unsettled, scenes.size() > 1 ? "scenes" : "scene",
                  fmt::join(scenes, ", "), plain(at(rows.front(), "reference")));
  run["notes"] = PageData::array();
  run["question"] = question_of_study(rows, parameters);
  run["body"] = PageData::array();
  add_response_picture(table_file, title.is_string() ? plain(title) : study, run, draft);
  if (const auto table = sensitivity_table(about, id_of(name + "-sensitivity"), run))
    run["tables"] = {*table};
  add_plots(rows, parameters, run, draft);
  run["table"] = table_of(rows, parameters, id_of(name + "-table"));
  add_what_was_asked(about, run);
  draft.runs.push_back(std::move(run));
}

} // namespace maille::studies
