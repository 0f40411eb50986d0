#include "maille/studies/study_table.hpp"

#include "gnuplot.hpp"
#include "maille/studies/export/whole_file.hpp"
#include "median.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille::studies {

namespace {

constexpr double least_percent = 1e-3;
constexpr int columns = 3, plot_width = 400, plot_height = 300, head_height = 70;

/// Errors [%] of one method at every value of a parameter.
struct Line {
  std::string method;
  std::map<double, std::vector<double>> errors;
};

struct Plot {
  std::string scene, parameter;
  std::vector<Line> lines;
  bool has_values() const {
    return std::ranges::any_of(lines, [](const Line& line) { return line.errors.size() > 1; });
  }
};

template<class Items, class Same, class Make>
auto& found_or_added(Items& items, const Same& same, const Make& make) {
  const auto found = std::ranges::find_if(items, same);
  return found == items.end() ? items.emplace_back(make()) : *found;
}

std::vector<Plot> plots_of(const std::vector<StudyRow>& rows) {
  std::vector<Plot> plots;
  for (const StudyRow& row : rows)
    for (const auto& [name, value] : row.parameters) {
      const double* number = std::get_if<double>(&value);
      if (number == nullptr || !row.error || !std::isfinite(row.error->relative_l2))
        continue;
      Plot& plot = found_or_added(
          plots, [&](const Plot& p) { return p.scene == row.scene && p.parameter == name; },
          [&] {
            return Plot{row.scene, name, {}};
          });
      Line& line = found_or_added(
          plot.lines, [&](const Line& l) { return l.method == row.method; },
          [&] {
            return Line{row.method, {}};
          });
      line.errors[*number].push_back(std::max(least_percent, 100 * row.error->relative_l2));
    }
  std::erase_if(plots, [](const Plot& plot) { return !plot.has_values(); });
  return plots;
}

/// The axis of the parameter, a little longer than its values; in decades where they span a factor of 30 and
/// more.
std::string axis_of(const Plot& plot) {
  double least = INFINITY, most = -INFINITY;
  for (const Line& line : plot.lines) {
    least = std::min(least, line.errors.begin()->first);
    most = std::max(most, line.errors.rbegin()->first);
  }
  if (least > 0 && most >= 30 * least) {
    const double room = std::pow(most / least, 0.04);
    return fmt::format("set logscale x\nset xrange [{:.9g}:{:.9g}]\n", least / room, most * room);
  }
  const double room = 0.04 * (most - least);
  return fmt::format("unset logscale x\nset xrange [{:.9g}:{:.9g}]\n", least - room, most + room);
}

std::string data_of(const Plot& plot, std::size_t number) {
  std::string text;
  for (const Line& line : plot.lines) {
    text += fmt::format("${}{} << EOD\n", line.method, number);
    for (const auto& [value, errors] : line.errors)
      text += fmt::format("{:.9g} {:.6g}\n", value, upper_median(errors));
    text += "EOD\n";
  }
  return text;
}

std::string commands_of(const Plot& plot, std::size_t number, double key_top) {
  std::string text = data_of(plot, number);
  text += fmt::format("set title {} offset 0,-0.6\nset xlabel {} offset 0,0.4\n{}",
                      gnuplot_quoted(plot.scene), gnuplot_quoted(plot.parameter), axis_of(plot));
  text += number % columns == 0 ? "set ylabel 'L2 error [%]' offset 1\n" : "unset ylabel\n";
  text += number == 0
              ? fmt::format("set key at screen 0.5,screen {:.4f} center top horizontal samplen 2\n", key_top)
              : "unset key\n";
  text += "plot ";
  for (std::size_t i = 0; i < plot.lines.size(); ++i) {
    const std::string& method = plot.lines[i].method;
    const MethodLook look = look_of(method);
    // Where two methods agree, the larger point of the first looks out from behind.
    text +=
        fmt::format("{}${}{} using 1:2 with linespoints pt {} ps {:.2g} lw 1.5 lc '{}' title '{}'",
                    i == 0 ? "" : ", ", method, number, look.point, i == 0 ? 1.2 : 0.7, look.colour, method);
  }
  return text + "\n";
}

/// The key stands once, above all: a line of the method in every plot where it is, whichever comes first.
void bring_longest_first(std::vector<Plot>& plots) {
  const auto most = std::ranges::max_element(plots, {}, [](const Plot& plot) { return plot.lines.size(); });
  for (const Line& line : most->lines)
    if (std::ranges::find(plots.front().lines, line.method, &Line::method) == plots.front().lines.end())
      plots.front().lines.push_back(
          {line.method, {{plots.front().lines.front().errors.begin()->first, {NAN}}}});
}

std::string script(const std::vector<Plot>& plots, const std::string& title,
                   const std::filesystem::path& file) {
  const int rows = (static_cast<int>(plots.size()) + columns - 1) / columns;
  const int width = plot_width * columns, height = head_height + plot_height * rows;
  const bool is_svg = file.extension() == ".svg";
  std::string text = fmt::format(
      "set terminal {} size {},{} font 'DejaVu Sans,{}' background '#FFFFFF' noenhanced\nset output {}\n",
      is_svg ? "svg" : "pngcairo", width, height, is_svg ? 13 : 10, gnuplot_quoted(file.string()));
  const double top = 1 - static_cast<double>(head_height) / height;
  text += fmt::format("set label 1 {} at screen 0.5,screen {:.4f} center\n", gnuplot_quoted(title),
                      1 - 0.25 * head_height / height);
  text += fmt::format("set multiplot layout {},{} margins 0.055,0.985,{:.4f},{:.4f} spacing 0.045,{:.4f}\n",
                      rows, columns, 55.0 / height, top - 15.0 / height, 90.0 / height);
  text += fmt::format("set logscale y\nset yrange [{}:200]\nset format x '%g'\nset format y '%g'\n"
                      "set grid xtics ytics lc '#E4E4E4' lw 0.8\nset border 3\nset tics nomirror scale 0.6\n",
                      least_percent);
  for (std::size_t number = 0; number < plots.size(); ++number)
    text += commands_of(plots[number], number, 1 - 0.45 * head_height / height) +
            (number == 0 ? "unset label 1\n" : "");
  return text + "unset multiplot\nset output\n";
}

} // namespace

std::optional<std::string> draw_study(const std::vector<StudyRow>& rows, const std::string& title,
                                      const std::filesystem::path& file) {
  std::vector<Plot> plots = plots_of(rows);
  if (plots.empty())
    return "no parameter has errors at several values";
  if (auto reason = why_no_gnuplot())
    return reason;
  bring_longest_first(plots);
  write_whole(file, [&](const std::filesystem::path& part) { run_gnuplot(script(plots, title, part)); });
  return std::nullopt;
}

} // namespace maille::studies
