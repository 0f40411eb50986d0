#include "study/picture_parts.hpp"

#include "export/whole_file.hpp"
#include "gnuplot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace maille::studies {

double number_of(const StudyRow& row, const std::string& parameter) {
  for (const auto& [name, value] : row.parameters)
    if (const double* number = std::get_if<double>(&value); number != nullptr && name == parameter)
      return *number;
  return NAN;
}

VariedParameters varied_parameters(const std::vector<StudyRow>& rows) {
  VariedParameters varied;
  for (const auto& parameter : rows.empty() ? StudyRow().parameters : rows.front().parameters) {
    std::set<std::variant<double, std::string>> values;
    bool has_text = false;
    for (const StudyRow& row : rows)
      for (const auto& [name, value] : row.parameters)
        if (name == parameter.first) {
          values.insert(value);
          has_text = has_text || std::holds_alternative<std::string>(value);
        }
    if (values.size() > 1)
      (has_text ? varied.texts : varied.numbers).push_back(parameter.first);
  }
  return varied;
}

bool spans_decades(double least, double most) {
  return least > 0 && most >= 30 * least;
}

std::string gnuplot_axis(char name, double least, double most) {
  if (spans_decades(least, most)) {
    const double room = std::pow(most / least, 0.04);
    return fmt::format("set logscale {0}\nset {0}range [{1:.9g}:{2:.9g}]\n", name, least / room, most * room);
  }
  const double size = most > least ? most - least : std::max(std::abs(most), 1e-30);
  return fmt::format("unset logscale {0}\nset {0}range [{1:.9g}:{2:.9g}]\n", name, least - 0.04 * size,
                     most + 0.04 * size);
}

std::string head_of_picture(std::size_t n_plots, const std::string& title, const std::filesystem::path& file,
                            bool is_map) {
  const int rows = (static_cast<int>(n_plots) + plots_across - 1) / plots_across;
  const int across = std::min(plots_across, static_cast<int>(n_plots));
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

std::optional<std::string> draw_study(const std::vector<StudyRow>& rows, const std::string& title,
                                      const std::filesystem::path& file, const std::string& column) {
  const Response response = response_of(column.empty() ? default_response(rows) : column, rows);
  const std::string of = title + ": " + response.label;
  const auto script = [&](const std::filesystem::path& part) {
    const auto map = map_script(rows, response, of, part);
    return map ? map : curve_script(rows, response, of, part);
  };
  if (!script(file))
    return response.name == "relative_l2"
               ? "no parameter has errors at several values"
               : fmt::format("no parameter has `{}` at several values", response.name);
  if (auto reason = why_no_gnuplot())
    return reason;
  write_whole(file, [&](const std::filesystem::path& part) { run_gnuplot(*script(part)); });
  return std::nullopt;
}

} // namespace maille::studies
