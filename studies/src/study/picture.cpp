#include "study/table_files.hpp"

#include "gnuplot.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace maille::studies {

namespace {

constexpr double least_percent = 1e-3;
constexpr int columns = 3, plot_width = 400, plot_height = 300, head_height = 70;

/// What a picture is of: one column of the table.
struct Response {
  std::size_t column = 0;
  std::string measure; ///< not empty: the column of a measure
  std::string label;
  bool is_percent = false, is_error = false;

  /// Of a row; nothing where it has no such number.
  std::optional<double> value(const StudyRow& row) const {
    const double value = (is_percent ? 100 : 1) * (measure.empty() ? in_column(row) : of_measure(row));
    if (!std::isfinite(value))
      return std::nullopt;
    return is_error ? std::max(is_percent ? least_percent : 0.0, value) : value;
  }

private:
  double in_column(const StudyRow& row) const {
    const Values values = columns_of_study().values(row);
    return values[column].is_number() ? values[column].get<double>() : NAN;
  }
  double of_measure(const StudyRow& row) const {
    const auto found = std::ranges::find(row.measures, measure, &StudyMeasure::name);
    return found == row.measures.end() ? NAN : found->value.value_or(NAN);
  }
};

/// Columns whose numbers say how a case came out.
bool is_response(const Column& column) {
  return !column.csv.empty() && (column.is_real || column.csv == "bytes" || column.csv == "iterations") &&
         column.csv != "processor_share" && column.csv != "load_average";
}

Response response_of(const std::string& name, const std::vector<StudyRow>& rows) {
  Response response;
  const auto& list = columns_of_study().list();
  const auto column = std::ranges::find(list, name, &Column::csv);
  if (column == list.end()) {
    response.measure = name;
    response.is_percent = response.is_error = name.ends_with("_error");
    std::string unit = response.is_percent ? "%" : "";
    for (const StudyRow& row : rows)
      for (const StudyMeasure& measure : row.measures)
        if (measure.name == name && unit.empty())
          unit = measure.unit;
    response.label = unit.empty() ? name : fmt::format("{} [{}]", name, unit);
    return response;
  }
  response.column = static_cast<std::size_t>(column - list.begin());
  response.is_percent = name.ends_with("relative_l2") || name.ends_with("relative_max");
  response.is_error = response.is_percent || name.ends_with("rms_m");
  const std::string unit = response.is_percent ? "%" : column->unit;
  response.label = name == "relative_l2" ? "L2 error [%]"
                   : unit.empty()        ? name
                                         : fmt::format("{} [{}]", name, unit);
  return response;
}

double number_of(const StudyRow& row, const std::string& parameter) {
  for (const auto& [name, value] : row.parameters)
    if (const double* number = std::get_if<double>(&value); number != nullptr && name == parameter)
      return *number;
  return NAN;
}

/// The value of one method at every value of a parameter.
struct Line {
  std::string method;
  std::map<double, std::vector<double>> values;
};

struct Plot {
  std::string scene, parameter;
  std::vector<Line> lines;
  bool is_scattered = false; ///< other parameters change from each value to the next: no line leads there
  bool has_values() const {
    return std::ranges::any_of(lines, [](const Line& line) { return line.values.size() > 1; });
  }
};

/// Of one method over two parameters, on a whole grid of their values.
struct Surface {
  std::string scene, method, along_x, along_y;
  std::map<double, std::map<double, double>> rows; ///< by y, then x

  bool is_whole() const {
    return rows.size() > 2 && rows.begin()->second.size() > 2 &&
           std::ranges::all_of(rows, [&](const auto& row) {
             return std::ranges::equal(
                 row.second, rows.begin()->second, {}, [](const auto& point) { return point.first; },
                 [](const auto& point) { return point.first; });
           });
  }
};

template<class Items, class Same, class Make>
auto& found_or_added(Items& items, const Same& same, const Make& make) {
  const auto found = std::ranges::find_if(items, same);
  return found == items.end() ? items.emplace_back(make()) : *found;
}

/// The parameters of numbers that have several values, in the order of the table.
std::vector<std::string> varied_parameters(const std::vector<StudyRow>& rows) {
  std::vector<std::string> varied;
  for (const auto& parameter : rows.empty() ? StudyRow().parameters : rows.front().parameters) {
    std::set<double> values;
    for (const StudyRow& row : rows)
      if (const double value = number_of(row, parameter.first); !std::isnan(value))
        values.insert(value);
    if (values.size() > 1)
      varied.push_back(parameter.first);
  }
  return varied;
}

std::vector<Plot> plots_of(const std::vector<StudyRow>& rows, const Response& response) {
  std::vector<Plot> plots;
  for (const StudyRow& row : rows) {
    const std::optional<double> value = response.value(row);
    for (const auto& parameter : row.parameters) {
      const std::string& name = parameter.first;
      const double* number = std::get_if<double>(&parameter.second);
      if (number == nullptr || !value)
        continue;
      Plot& plot = found_or_added(
          plots, [&](const Plot& p) { return p.scene == row.scene && p.parameter == name; },
          [&] {
            return Plot{row.scene, name, {}, false};
          });
      Line& line = found_or_added(
          plot.lines, [&](const Line& l) { return l.method == row.method; },
          [&] {
            return Line{row.method, {}};
          });
      line.values[*number].push_back(*value);
    }
  }
  std::erase_if(plots, [](const Plot& plot) { return !plot.has_values(); });
  const bool varies_several = varied_parameters(rows).size() > 1;
  for (Plot& plot : plots)
    plot.is_scattered =
        varies_several && std::ranges::all_of(plot.lines, [](const Line& line) {
          return std::ranges::all_of(line.values, [](const auto& at) { return at.second.size() == 1; });
        });
  return plots;
}

/// One a scene and method; none unless exactly two parameters are varied, on a grid.
std::vector<Surface> surfaces_of(const std::vector<StudyRow>& rows, const Response& response) {
  const std::vector<std::string> varied = varied_parameters(rows);
  std::vector<Surface> surfaces;
  if (varied.size() != 2)
    return surfaces;
  for (const StudyRow& row : rows)
    if (const std::optional<double> value = response.value(row)) {
      Surface& surface = found_or_added(
          surfaces, [&](const Surface& s) { return s.scene == row.scene && s.method == row.method; },
          [&] {
            return Surface{row.scene, row.method, varied[0], varied[1], {}};
          });
      surface.rows[number_of(row, varied[1])][number_of(row, varied[0])] = *value;
    }
  std::erase_if(surfaces, [](const Surface& surface) { return !surface.is_whole(); });
  return surfaces;
}

/// Of values that span a factor of 30 and more, all above 0: they stand in decades.
bool spans_decades(double least, double most) {
  return least > 0 && most >= 30 * least;
}

/// An axis a little longer than its values.
std::string axis(char name, double least, double most) {
  if (spans_decades(least, most)) {
    const double room = std::pow(most / least, 0.04);
    return fmt::format("set logscale {0}\nset {0}range [{1:.9g}:{2:.9g}]\n", name, least / room, most * room);
  }
  const double size = most > least ? most - least : std::max(std::abs(most), 1e-30);
  return fmt::format("unset logscale {0}\nset {0}range [{1:.9g}:{2:.9g}]\n", name, least - 0.04 * size,
                     most + 0.04 * size);
}

std::string axis_of(const Plot& plot) {
  double least = INFINITY, most = -INFINITY;
  for (const Line& line : plot.lines) {
    least = std::min(least, line.values.begin()->first);
    most = std::max(most, line.values.rbegin()->first);
  }
  return axis('x', least, most);
}

/// The value, and the least and the most of the cases that share it.
std::string data_of(const Plot& plot, std::size_t number) {
  std::string text;
  for (const Line& line : plot.lines) {
    text += fmt::format("${}{} << EOD\n", line.method, number);
    for (const auto& [at, values] : line.values)
      text += fmt::format("{:.9g} {:.6g} {:.6g} {:.6g}\n", at, upper_median(values),
                          *std::ranges::min_element(values), *std::ranges::max_element(values));
    text += "EOD\n";
  }
  return text;
}

std::string commands_of(const Plot& plot, std::size_t number, const Response& response, double key_top) {
  std::string text = data_of(plot, number);
  text += fmt::format("set title {} offset 0,-0.6\nset xlabel {} offset 0,0.4\n{}",
                      gnuplot_quoted(plot.scene), gnuplot_quoted(plot.parameter), axis_of(plot));
  text += number % columns == 0 ? fmt::format("set ylabel {} offset -0.5\n", gnuplot_quoted(response.label))
                                : "unset ylabel\n";
  text += number == 0
              ? fmt::format("set key at screen 0.5,screen {:.4f} center top horizontal samplen 2\n", key_top)
              : "unset key\n";
  std::string bands, curves;
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const Line& line = plot.lines[i];
    const MethodLook look = look_of(line.method);
    if (std::ranges::any_of(line.values, [](const auto& at) { return at.second.size() > 1; }))
      bands += fmt::format("${}{} using 1:3:4 with filledcurves lc '{}' notitle, ", line.method, number,
                           look.colour);
    // Where two methods agree, the larger point of the first looks out from behind.
    curves +=
        fmt::format("{}${}{} using 1:2 with {} pt {} ps {:.2g} lw 1.5 lc '{}' title '{}'", i == 0 ? "" : ", ",
                    line.method, number, plot.is_scattered ? "points" : "linespoints", look.point,
                    i == 0 ? 1.2 : 0.7, look.colour, line.method);
  }
  return text + "plot " + bands + curves + "\n";
}

/// The key stands once, above all: a line of the method in every plot where it is, whichever comes first.
void bring_longest_first(std::vector<Plot>& plots) {
  const auto most = std::ranges::max_element(plots, {}, [](const Plot& plot) { return plot.lines.size(); });
  for (const Line& line : most->lines)
    if (std::ranges::find(plots.front().lines, line.method, &Line::method) == plots.front().lines.end())
      plots.front().lines.push_back(
          {line.method, {{plots.front().lines.front().values.begin()->first, {NAN}}}});
}

/// A multiplot of so many, under a title. @return what comes before its plots
std::string head_of(std::size_t n_plots, const std::string& title, const std::filesystem::path& file,
                    bool is_map) {
  const int rows = (static_cast<int>(n_plots) + columns - 1) / columns;
  const int across = std::min(columns, static_cast<int>(n_plots));
  const int width = plot_width * std::max(2, across), height = head_height + plot_height * rows;
  const bool is_svg = file.extension() == ".svg";
  std::string text = fmt::format(
      "set terminal {} size {},{} font 'DejaVu Sans,{}' background '#FFFFFF' noenhanced\nset output {}\n",
      is_svg ? "svg" : "pngcairo", width, height, is_svg ? 13 : 10, gnuplot_quoted(file.string()));
  const double top = 1 - static_cast<double>(head_height) / height;
  text += fmt::format("set label 1 {} at screen 0.5,screen {:.4f} center\n", gnuplot_quoted(title),
                      1 - 0.25 * head_height / height);
  text += fmt::format("set multiplot layout {},{} margins {:.4f},{},{:.4f},{:.4f} spacing {:.4f},{:.4f}\n",
                      rows, across, 80.0 / width, is_map ? 0.85 : 0.985, 55.0 / height, top - 15.0 / height,
                      (is_map ? 84.0 : 60.0) / width, 90.0 / height);
  return text + "set format x '%g'\nset format y '%g'\nset grid xtics ytics lc '#E4E4E4' lw 0.8\nset border "
                "3\nset tics nomirror scale 0.6\nset style fill transparent solid 0.15 noborder\n";
}

std::string script(const std::vector<Plot>& plots, const Response& response, const std::string& title,
                   const std::filesystem::path& file) {
  const int rows = (static_cast<int>(plots.size()) + columns - 1) / columns;
  std::string text = head_of(plots.size(), title, file, false);
  double least = INFINITY, most = -INFINITY;
  for (const Plot& plot : plots)
    for (const Line& line : plot.lines)
      for (const auto& [at, values] : line.values)
        for (const double value : values)
          if (!std::isnan(value)) {
            least = std::min(least, value);
            most = std::max(most, value);
          }
  text += response.is_percent ? fmt::format("set logscale y\nset yrange [{}:200]\n", least_percent)
                              : axis('y', least, most);
  for (std::size_t number = 0; number < plots.size(); ++number)
    text += commands_of(plots[number], number, response,
                        1 - 0.45 * head_height / (head_height + plot_height * rows)) +
            (number == 0 ? "unset label 1\n" : "");
  return text + "unset multiplot\nset output\n";
}

/// Colours of one scale for all, and lines of equal value with their numbers.
std::string script(const std::vector<Surface>& surfaces, const Response& response, const std::string& title,
                   const std::filesystem::path& file) {
  double least = INFINITY, most = -INFINITY;
  for (const Surface& surface : surfaces)
    for (const auto& [y, row] : surface.rows)
      for (const auto& [x, value] : row) {
        least = std::min(least, value);
        most = std::max(most, value);
      }
  std::string text = head_of(surfaces.size(), title, file, true);
  text +=
      "set view map\nset style fill solid 1 noborder\nset border 15\nunset grid\nset pm3d corners2color mean "
      "interpolate 6,6\nset contour base\nunset key\n"
      "set cntrparam levels auto 6\nset cntrlabel onecolor start 3 interval 30 font "
      "',8' format '%.3g'\n"
      "set palette defined (0 '#440154', 0.25 '#3B528B', 0.5 '#21918C', 0.75 '#5EC962', 1 '#FDE725')\n"
      "set colorbox user origin screen 0.89,screen 0.2 size screen 0.018,screen 0.55\n";
  text += axis('z', least, most) + (spans_decades(least, most) ? "set logscale cb\n" : "") +
          fmt::format("set cbrange [{:.9g}:{:.9g}]\nset cblabel {}\n", least,
                      most > least ? most : least + std::max(std::abs(least), 1e-30),
                      gnuplot_quoted(response.label));
  for (std::size_t number = 0; number < surfaces.size(); ++number) {
    const Surface& surface = surfaces[number];
    text += fmt::format("$s{} << EOD\n", number);
    for (const auto& [y, row] : surface.rows) {
      for (const auto& [x, value] : row)
        text += fmt::format("{:.9g} {:.9g} {:.9g}\n", x, y, value);
      text += "\n";
    }
    const auto& first = surface.rows.begin()->second;
    text += fmt::format(
        "EOD\nset title {} offset 0,-0.6\nset xlabel {} offset 0,0.4\nset ylabel {} offset -1.5\n{}{}",
        gnuplot_quoted(surface.scene + ", " + surface.method), gnuplot_quoted(surface.along_x),
        gnuplot_quoted(surface.along_y), axis('x', first.begin()->first, first.rbegin()->first),
        axis('y', surface.rows.begin()->first, surface.rows.rbegin()->first));
    text += fmt::format("splot $s{0} with pm3d nocontour, $s{0} with lines lc '#FFFFFF' lw 0.8 nosurface, "
                        "$s{0} with labels tc '#FFFFFF' nosurface\n",
                        number);
    if (number == 0)
      text += "unset label 1\nunset colorbox\n";
  }
  return text + "unset multiplot\nset output\n";
}

} // namespace

std::vector<std::string> study_responses() {
  std::vector<std::string> names;
  for (const Column& column : columns_of_study().list())
    if (is_response(column))
      names.push_back(column.csv);
  return names;
}

std::optional<std::string> draw_study(const std::vector<StudyRow>& rows, const std::string& title,
                                      const std::filesystem::path& file, const std::string& column) {
  const Response response = response_of(column, rows);
  const std::vector<Surface> surfaces = surfaces_of(rows, response);
  std::vector<Plot> plots = plots_of(rows, response);
  if (plots.empty())
    return column == "relative_l2"
               ? "no parameter has errors at several values"
               : fmt::format("no parameter of numbers has `{}` at several values", column);
  if (auto reason = why_no_gnuplot())
    return reason;
  bring_longest_first(plots);
  write_whole(file, [&](const std::filesystem::path& part) {
    const std::string of = title + ": " + response.label;
    run_gnuplot(surfaces.empty() ? script(plots, response, of, part) : script(surfaces, response, of, part));
  });
  return std::nullopt;
}

} // namespace maille::studies
