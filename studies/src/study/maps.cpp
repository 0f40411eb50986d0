#include "study/picture_parts.hpp"

#include "gnuplot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille::studies {

namespace {

struct Map {
  std::string scene, method;
  std::map<double, std::map<double, double>> rows; ///< by y, then x

  bool is_whole_grid() const {
    return rows.size() > 2 && rows.begin()->second.size() > 2 &&
           std::ranges::all_of(rows, [&](const auto& row) {
             return std::ranges::equal(
                 row.second, rows.begin()->second, {}, [](const auto& point) { return point.first; },
                 [](const auto& point) { return point.first; });
           });
  }
  /// Whether points lie about in the plane: not on a line that rises or falls, as zipped parameters do.
  bool is_spread() const {
    std::map<double, std::pair<double, double>> columns; // by x, the least and the most y
    for (const auto& [y, row] : rows)
      for (const auto& [x, value] : row) {
        const auto at = columns.try_emplace(x, y, y).first;
        at->second = {std::min(at->second.first, y), std::max(at->second.second, y)};
      }
    bool rises = true, falls = true;
    for (auto at = columns.begin(); at != columns.end(); ++at) {
      const auto next = std::next(at);
      rises = rises && at->second.first == at->second.second &&
              (next == columns.end() || at->second.second <= next->second.first);
      falls = falls && at->second.first == at->second.second &&
              (next == columns.end() || at->second.second >= next->second.first);
    }
    constexpr std::size_t least_points = 9;
    return !rises && !falls && n_points() >= least_points;
  }
  std::size_t n_points() const {
    std::size_t n = 0;
    for (const auto& [y, row] : rows)
      n += row.size();
    return n;
  }
};

std::vector<Map> maps_of(const std::vector<StudyRow>& rows, const Response& response,
                         const std::vector<std::string>& parameters) {
  std::vector<Map> maps;
  for (const StudyRow& row : rows) {
    const std::optional<double> value = response.value(row);
    if (!value)
      continue;
    auto map = std::ranges::find_if(
        maps, [&](const Map& m) { return m.scene == row.scene && m.method == row.method; });
    if (map == maps.end())
      map = maps.insert(map, {row.scene, row.method, {}});
    map->rows[number_of(row, parameters[1])][number_of(row, parameters[0])] = *value;
  }
  std::erase_if(maps, [](const Map& map) { return !map.is_whole_grid() && !map.is_spread(); });
  return maps;
}

/// Round values between the ends: five to ten of them.
std::vector<double> round_levels(double least, double most) {
  std::vector<double> levels;
  const auto add = [&](double level) {
    if (level > least && level < most)
      levels.push_back(level);
  };
  if (spans_decades(least, most)) {
    const bool is_long = most > 3e3 * least;
    for (double decade = std::pow(10, std::floor(std::log10(least))); decade < most; decade *= 10)
      for (const double digit : {1.0, 2.0, 5.0})
        if (digit == 1 || !is_long)
          add(digit * decade);
  } else if (most > least) {
    const double wanted = (most - least) / 7, decade = std::pow(10, std::floor(std::log10(wanted)));
    const double step = decade * (wanted <= decade       ? 1
                                  : wanted <= 2 * decade ? 2
                                  : wanted <= 5 * decade ? 5
                                                         : 10);
    for (double i = std::ceil(least / step); i * step < most; ++i)
      add(i * step);
  }
  return levels;
}

std::string data_of(const Map& map, std::size_t number) {
  std::string text = fmt::format("$s{} << EOD\n", number);
  for (const auto& [y, row] : map.rows) {
    for (const auto& [x, value] : row)
      text += fmt::format("{:.9g} {:.9g} {:.9g}\n", x, y, value);
    text += "\n";
  }
  return text + "EOD\n";
}

/// The ends of the axes and of the values over all maps: plots can be compared.
struct Extent {
  double least = INFINITY, most = -INFINITY;
  void include(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

} // namespace

std::optional<std::string> map_script(const std::vector<StudyRow>& rows, const Response& response,
                                      const std::string& title, const std::filesystem::path& file) {
  const VariedParameters varied = varied_parameters(rows);
  if (varied.numbers.size() != 2 || !varied.texts.empty())
    return std::nullopt;
  const std::vector<Map> maps = maps_of(rows, response, varied.numbers);
  if (maps.empty())
    return std::nullopt;
  Extent along_x, along_y, values;
  for (const Map& map : maps)
    for (const auto& [y, row] : map.rows)
      for (const auto& [x, value] : row) {
        along_x.include(x);
        along_y.include(y);
        values.include(value);
      }
  std::string text = head_of_picture(maps.size(), title, file, true);
  text +=
      "set view map\nset style fill solid 1 noborder\nset border 15\nunset grid\nset pm3d corners2color mean "
      "interpolate 8,8\nset contour base\nunset key\nset cntrparam cubicspline\nset cntrparam points 8\n"
      "set cntrlabel onecolor start 14 interval 400 font ',8' format '%.3g'\n"
      "set palette defined (0 '#440154', 0.25 '#3B528B', 0.5 '#21918C', 0.75 '#5EC962', 1 '#FDE725')\n"
      "set colorbox user origin screen 0.89,screen 0.2 size screen 0.018,screen 0.55\n";
  const std::vector<double> levels = round_levels(values.least, values.most);
  if (!levels.empty())
    text += fmt::format("set cntrparam levels discrete {:.9g}\n", fmt::join(levels, ","));
  text += gnuplot_axis('z', values.least, values.most) +
          (spans_decades(values.least, values.most) ? "set logscale cb\n" : "") +
          fmt::format("set cbrange [{:.9g}:{:.9g}]\nset cblabel {}\n", values.least,
                      values.most > values.least ? values.most
                                                 : values.least + std::max(std::abs(values.least), 1e-30),
                      gnuplot_quoted(response.label));
  text += gnuplot_axis('x', along_x.least, along_x.most) + gnuplot_axis('y', along_y.least, along_y.most);
  for (std::size_t number = 0; number < maps.size(); ++number) {
    const Map& map = maps[number];
    text += data_of(map, number) +
            fmt::format("set title {} offset 0,-0.6\nset xlabel {} offset 0,0.4\nset ylabel {} offset -1.5\n",
                        gnuplot_quoted(map.scene + ", " + map.method), gnuplot_quoted(varied.numbers[0]),
                        gnuplot_quoted(varied.numbers[1]));
    const std::string lines =
        levels.empty() ? ""
                       : fmt::format(", $s{0} with lines lc '#FFFFFF' lw 0.9 nosurface, $s{0} with "
                                     "labels tc '#FFFFFF' nosurface",
                                     number);
    // Between cases that lie anyhow nothing is known: a point each, in its colour.
    text += map.is_whole_grid()
                ? fmt::format("splot $s{} with pm3d nocontour{}\n", number, lines)
                : fmt::format("plot $s{0} using 1:2 with points pt 7 ps 1.25 lc '#8A9099', $s{0} using 1:2:3 "
                              "with points pt 7 ps 1 palette\n",
                              number);
    if (number == 0)
      text += "unset label 1\nunset colorbox\n";
  }
  return text + "unset multiplot\nset output\n";
}

} // namespace maille::studies
