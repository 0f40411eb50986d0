#include "chart.hpp"

#include "data_uri.hpp"
#include "gnuplot.hpp"
#include "maille/materials/work_folder.hpp"
#include "maille/studies/method_look.hpp"

#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <stdexcept>
#include <string_view>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

/// Whatever has the ink's colour has the other one on a dark ground; as gnuplot writes them.
constexpr std::array<std::array<std::string_view, 2>, 4> inks{{{"rgb( 27,  31,  36)", "rgb(230,232,234)"},
                                                               {"rgb(27,31,36)", "rgb(230,232,234)"},
                                                               {"rgb(220, 223, 227)", "rgb(58,66,75)"},
                                                               {"color=\"black\"", "color=\"#e6e8ea\""}}};

std::string script(const Chart& chart, const fs::path& svg) {
  std::string text =
      fmt::format("set terminal svg size 900,500 dynamic font 'sans-serif,15' noenhanced\nset output {}\n"
                  "set border 3 lc rgb '#1b1f24'\nset tics nomirror scale 0.6 textcolor rgb '#1b1f24'\n"
                  "set grid xtics ytics lc rgb '#dcdfe3' lt 1 lw 1\nset format '%g'\n"
                  "set xlabel {} textcolor rgb '#1b1f24'\nset ylabel {} textcolor rgb '#1b1f24'\n"
                  "set key outside right top Left reverse samplen 1.5 spacing 1.3 textcolor rgb '#1b1f24'\n",
                  gnuplot_quoted(svg.string()), gnuplot_quoted(chart.x_label), gnuplot_quoted(chart.y_label));
  text += fmt::format("set offsets graph {0}, graph {0}, graph {1}, graph {1}\n", chart.log_x ? 0 : 0.05,
                      chart.log_y ? 0 : 0.07); // axes in decades have room by themselves
  if (chart.log_x || chart.log_y)
    text += fmt::format("set logscale {}{}\n", chart.log_x ? "x" : "", chart.log_y ? "y" : "");
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    text += fmt::format("$data{} << EOD\n", i);
    for (const ChartPoint& point : chart.series[i].points)
      text += fmt::format("{:.9g} {:.9g}\n", point.x, point.y);
    text += "EOD\n";
  }
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const MethodLook look = look_of(chart.series[i].name);
    text += fmt::format("{}$data{} using 1:2 with {} pt {} ps 1.1 lw 1.8 lc rgb '{}' title {}",
                        i == 0 ? "plot " : ", ", i, chart.has_lines ? "linespoints" : "points", look.point,
                        look.colour, gnuplot_quoted(chart.series[i].name));
  }
  return text + "\nset output\n";
}

std::string dark(std::string svg) {
  for (const auto& [from, to] : inks)
    for (std::size_t at = 0; (at = svg.find(from, at)) != std::string::npos; at += to.size())
      svg.replace(at, from.size(), to);
  return svg;
}

} // namespace

std::optional<DrawnChart> draw_chart(const Chart& chart, std::string& why_not) {
  if (const auto reason = why_no_gnuplot()) {
    why_not = *reason;
    return std::nullopt;
  }
  try {
    const WorkFolder folder("maille_chart");
    const auto svg = folder / "chart.svg";
    run_gnuplot(script(chart, svg));
    const std::string light = bytes_of_file(svg);
    return DrawnChart{light, dark(light)};
  } catch (const std::runtime_error& error) {
    why_not = error.what();
    return std::nullopt;
  }
}

} // namespace maille::studies
