#include "page_parts.hpp"

#include "gnuplot.hpp"
#include "maille/base/arena.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <limits>
#include <stdexcept>

namespace maille::studies {

std::string percent(const PageData& ratio) {
  return ratio.is_number() ? fmt::format("{:.3g} %", 100 * ratio.get<double>()) : "–";
}

std::string seconds(const PageData& value) {
  if (!value.is_number())
    return "–";
  const double s = value;
  return s >= 1 || s == 0 ? fmt::format("{:.3g} s", s)
         : s >= 1e-3      ? fmt::format("{:.3g} ms", 1e3 * s)
                          : fmt::format("{:.3g} µs", 1e6 * s);
}

std::string bytes(const PageData& value) {
  return value.is_number() && value.get<double>() > 0 ? bytes_in_words(value.get<double>()) : "–";
}

std::string plain(const PageData& value) {
  if (value.is_string())
    return value.get<std::string>();
  if (value.is_number_integer())
    return fmt::format("{}", value.get<std::int64_t>());
  return value.is_number() ? fmt::format("{:.6g}", value.get<double>()) : "–";
}

PageData number_cell(std::string text, const PageData& key) {
  PageData cell{{"text", std::move(text)}, {"is_number", true}};
  if (key.is_number())
    cell["key"] = key.is_number_integer() ? fmt::format("{}", key.get<std::int64_t>())
                                          : fmt::format("{:.9g}", key.get<double>());
  return cell;
}

PageData text_cell(std::string text) {
  return {{"text", std::move(text)}};
}

PageData column(std::string name, bool is_number, std::string why) {
  PageData result{{"name", std::move(name)}, {"is_number", is_number}};
  if (!why.empty())
    result["why"] = std::move(why);
  return result;
}

PageData at(const PageData& object, const std::string& first, const std::string& second) {
  if (!object.is_object() || !object.contains(first))
    return nullptr;
  return second.empty() ? object.at(first) : at(object.at(first), second);
}

PageData picture(const std::string& bytes, std::string alt, std::string caption, const char* type) {
  return {{"source", data_uri(type, bytes)},
          {"look", "picture"},
          {"alt", std::move(alt)},
          {"caption", std::move(caption)}};
}

std::optional<PageData> plot(const Chart& chart, std::string alt, std::string caption, PageDraft& draft) {
  std::string why_not;
  const auto drawn = draw_chart(chart, why_not);
  if (!drawn) {
    if (std::ranges::find(draft.notes, why_not) == draft.notes.end())
      draft.notes.push_back(why_not);
    return std::nullopt;
  }
  return PageData{{"source", data_uri("image/svg+xml", drawn->light_svg)},
                  {"dark", data_uri("image/svg+xml", drawn->dark_svg)},
                  {"look", "plot"},
                  {"alt", std::move(alt)},
                  {"caption", std::move(caption)}};
}

void SeriesByMethod::add(const std::string& method, double x, double y) {
  auto found = std::ranges::find(series, method, &ChartSeries::name);
  if (found == series.end())
    found = series.insert(series.end(), {method, {}});
  found->points.push_back({x, y});
}

std::string id_of(const std::string& text) {
  std::string id = "id-";
  for (const char c : text)
    id += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  return id;
}

std::string data_uri(std::string_view type, std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string uri = fmt::format("data:{};base64,", type);
  uri.reserve(uri.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      uri += i + k <= bytes.size() ? digits[three >> (18 - 6 * k) & 63] : '=';
  }
  return uri;
}

std::string bytes_of_file(const std::filesystem::path& file) {
  return read_own_text_file(file, "a file of results", std::numeric_limits<std::int64_t>::max());
}

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
    MethodLook look = look_of(chart.series[i].name);
    if (look.method.empty()) // no method: each a look of its own
      look = method_looks[i % method_looks.size()];
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
