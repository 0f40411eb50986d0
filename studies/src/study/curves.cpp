#include "study/picture_parts.hpp"

#include "gnuplot.hpp"
#include "median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille::studies {

namespace {

constexpr double least_percent = 1e-3, most_percent = 200;

/// The value of one method at every value of a parameter.
struct Line {
  std::string method;
  std::map<double, std::vector<double>> values;
};

struct Plot {
  std::string scene, parameter;
  std::vector<std::string> names; ///< of values that are texts: they stand at 0, 1, 2, ...
  std::vector<Line> lines;
  bool is_scattered = false; ///< other parameters change from each value to the next: no line leads there
  bool has_values() const {
    return std::ranges::any_of(lines, [](const Line& line) { return line.values.size() > 1; });
  }
};

template<class Items, class Same, class Make>
auto& found_or_added(Items& items, const Same& same, const Make& make) {
  const auto found = std::ranges::find_if(items, same);
  return found == items.end() ? items.emplace_back(make()) : *found;
}

double place_of(const std::string& text, std::vector<std::string>& names) {
  const auto found = std::ranges::find(names, text);
  const auto place = found - names.begin();
  if (found == names.end())
    names.push_back(text);
  return static_cast<double>(place);
}

std::vector<Plot> plots_of(const std::vector<StudyRow>& rows, const Response& response) {
  const VariedParameters varied = varied_parameters(rows);
  std::vector<Plot> plots;
  for (const StudyRow& row : rows) {
    const std::optional<double> value = response.value(row);
    for (const auto& parameter : row.parameters) {
      const std::string& name = parameter.first;
      const bool is_text = std::ranges::find(varied.texts, name) != varied.texts.end();
      if (!value || (!is_text && std::ranges::find(varied.numbers, name) == varied.numbers.end()))
        continue;
      Plot& plot = found_or_added(
          plots, [&](const Plot& p) { return p.scene == row.scene && p.parameter == name; },
          [&] {
            return Plot{row.scene, name, {}, {}, false};
          });
      Line& line = found_or_added(
          plot.lines, [&](const Line& l) { return l.method == row.method; },
          [&] {
            return Line{row.method, {}};
          });
      const double* number = std::get_if<double>(&parameter.second);
      const double at = !is_text ? *number
                                 : place_of(number != nullptr ? fmt::format("{:g}", *number)
                                                              : std::get<std::string>(parameter.second),
                                            plot.names);
      line.values[at].push_back(*value);
    }
  }
  std::erase_if(plots, [](const Plot& plot) { return !plot.has_values(); });
  const bool varies_several = varied.numbers.size() + varied.texts.size() > 1;
  for (Plot& plot : plots)
    plot.is_scattered =
        varies_several && plot.names.empty() && std::ranges::all_of(plot.lines, [](const Line& line) {
          return std::ranges::all_of(line.values, [](const auto& at) { return at.second.size() == 1; });
        });
  return plots;
}

std::string axis_of(const Plot& plot) {
  if (!plot.names.empty()) {
    std::string text = fmt::format("unset logscale x\nset xrange [-0.6:{}]\nset xtics (",
                                   static_cast<double>(plot.names.size()) - 0.4);
    for (std::size_t i = 0; i < plot.names.size(); ++i)
      text += fmt::format("{}{} {}", i == 0 ? "" : ", ", gnuplot_quoted(plot.names[i]), i);
    return text + ")\n";
  }
  double least = INFINITY, most = -INFINITY;
  for (const Line& line : plot.lines) {
    least = std::min(least, line.values.begin()->first);
    most = std::max(most, line.values.rbegin()->first);
  }
  return "set xtics autofreq\n" + gnuplot_axis('x', least, most);
}

/// The value, and the least and the most of the cases that share it.
std::string data_of(const Plot& plot, std::size_t number) {
  std::string text;
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const Line& line = plot.lines[i];
    // Bars of methods stand beside each other.
    const double aside =
        plot.names.empty()
            ? 0
            : 0.14 * (static_cast<double>(i) - 0.5 * static_cast<double>(plot.lines.size() - 1));
    text += fmt::format("$d{}_{} << EOD\n", i, number);
    for (const auto& [at, values] : line.values)
      text += fmt::format("{:.9g} {:.6g} {:.6g} {:.6g}\n", at + aside, upper_median(values),
                          *std::ranges::min_element(values), *std::ranges::max_element(values));
    text += "EOD\n";
  }
  return text;
}

std::string commands_of(const Plot& plot, std::size_t number, const Response& response, double key_top) {
  std::string text = data_of(plot, number);
  text += fmt::format("set title {} offset 0,-0.6\nset xlabel {} offset 0,0.4\n{}",
                      gnuplot_quoted(plot.scene), gnuplot_quoted(plot.parameter), axis_of(plot));
  text += number % plots_across == 0
              ? fmt::format("set ylabel {} offset -0.5\n", gnuplot_quoted(response.label))
              : "unset ylabel\n";
  text += number == 0
              ? fmt::format("set key at screen 0.5,screen {:.4f} center top horizontal samplen 2\n", key_top)
              : "unset key\n";
  std::string bands, curves;
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const Line& line = plot.lines[i];
    const MethodLook look = look_of(line.method);
    if (std::ranges::any_of(line.values, [](const auto& at) { return at.second.size() > 1; }))
      bands +=
          plot.names.empty()
              ? fmt::format("$d{}_{} using 1:3:4 with filledcurves lc '{}' notitle, ", i, number, look.colour)
              : fmt::format("$d{}_{} using 1:2:3:4 with yerrorbars pt -1 lw 2.5 lc '{}' notitle, ", i, number,
                            look.colour);
    // Where two methods agree, the larger point of the first looks out from behind.
    curves +=
        fmt::format("{}$d{}_{} using 1:2 with {} pt {} ps {:.2g} lw 1.5 lc '{}' title {}", i == 0 ? "" : ", ",
                    i, number, plot.is_scattered || !plot.names.empty() ? "points" : "linespoints",
                    look.point, i == 0 ? 1.2 : 0.7, look.colour, gnuplot_quoted(line.method));
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

} // namespace

std::optional<std::string> curve_script(const std::vector<StudyRow>& rows, const Response& response,
                                        const std::string& title, const std::filesystem::path& file) {
  std::vector<Plot> plots = plots_of(rows, response);
  if (plots.empty())
    return std::nullopt;
  bring_longest_first(plots);
  const int lines = (static_cast<int>(plots.size()) + plots_across - 1) / plots_across;
  std::string text = head_of_picture(plots.size(), title, file, false);
  double least = INFINITY, most = -INFINITY;
  for (const Plot& plot : plots)
    for (const Line& line : plot.lines)
      for (const auto& [at, values] : line.values)
        for (const double value : values)
          if (!std::isnan(value)) {
            least = std::min(least, value);
            most = std::max(most, value);
          }
  text += response.is_percent ? fmt::format("set logscale y\nset yrange [{}:{:.6g}]\n", least_percent,
                                            std::max(most_percent, 1.3 * most))
                              : gnuplot_axis('y', least, most);
  for (std::size_t number = 0; number < plots.size(); ++number)
    text += commands_of(plots[number], number, response,
                        1 - 0.45 * head_height / (head_height + plot_height * lines)) +
            (number == 0 ? "unset label 1\n" : "");
  return text + "unset multiplot\nset output\n";
}

} // namespace maille::studies
