#include "export/whole_file.hpp"
#include "gnuplot.hpp"
#include "trade/trade.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace maille::studies {

namespace {

bool counts(const TradeRow& row) {
  return is_converged(row.status) && row.error && row.error->relative_l2 > 0 && row.seconds.total() > 0;
}

/// What one of the two plots has along x.
struct Axis {
  const char* label;
  bool TradeRow::*on_front;
  double (*value)(const TradeRow&);
};

double milliseconds(const TradeRow& row) {
  return 1e3 * row.seconds.total();
}
double mebibytes(const TradeRow& row) {
  return static_cast<double>(row.bytes) / 1048576;
}
constexpr std::array<Axis, 2> axes{{{"time [ms], set-up and solve", &TradeRow::on_time_front, milliseconds},
                                    {"memory [MiB]", &TradeRow::on_memory_front, mebibytes}}};

/// `"name" with points` and the like of one method; its points as a block of data.
struct Block {
  std::string name, data;
};

std::vector<Block> blocks_of_methods(const Trade& trade, const Axis& axis, std::size_t number) {
  std::vector<Block> blocks;
  for (const std::string& method : trade.settings.methods) {
    std::string points;
    for (const TradeRow& row : trade.rows)
      if (row.way.method == method && counts(row) && axis.value(row) > 0)
        points += fmt::format("{:.6g} {:.6g}\n", axis.value(row), 100 * row.error->relative_l2);
    if (!points.empty())
      blocks.push_back({method, fmt::format("${}{} << EOD\n{}EOD\n", method, number, points)});
  }
  return blocks;
}

/// The front as steps: from each of its points to the right at the same error, then down.
std::string front_block(const Trade& trade, const Axis& axis, std::size_t number) {
  std::vector<std::pair<double, double>> points;
  for (const TradeRow& row : trade.rows)
    if (row.*axis.on_front && counts(row))
      points.emplace_back(axis.value(row), 100 * row.error->relative_l2);
  std::ranges::sort(points);
  std::string text;
  for (const auto& [cost, error] : points)
    text += fmt::format("{:.6g} {:.6g}\n", cost, error);
  return fmt::format("$front{} << EOD\n{}EOD\n", number, text);
}

/// What the points span, and a little more: the program's own choice would be whole decades.
std::string ranges(const Trade& trade, const Axis& axis) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  double least_x = infinity, most_x = 0, least_y = infinity, most_y = 0;
  for (const TradeRow& row : trade.rows) {
    if (!counts(row) || !(axis.value(row) > 0))
      continue;
    least_x = std::min(least_x, axis.value(row));
    most_x = std::max(most_x, axis.value(row));
    least_y = std::min(least_y, 100 * row.error->relative_l2);
    most_y = std::max(most_y, 100 * row.error->relative_l2);
  }
  if (trade.reference_error && trade.reference_error->relative_l2 > 0)
    least_y = std::min(least_y, 100 * trade.reference_error->relative_l2);
  return fmt::format("set xrange [{:.4g}:{:.4g}]\nset yrange [{:.4g}:{:.4g}]\n", least_x / 1.8, most_x * 1.8,
                     least_y / 1.4, most_y * 1.4);
}

std::string plot(const Trade& trade, std::size_t number) {
  const Axis& axis = axes[number];
  const auto blocks = blocks_of_methods(trade, axis, number);
  std::string text = front_block(trade, axis, number);
  for (const Block& block : blocks)
    text += block.data;
  text += fmt::format("set xlabel '{}'\n{}", axis.label, ranges(trade, axis));
  text += number == 0 ? "unset key\n" : "set key outside right top Left reverse samplen 1.5 spacing 1.25\n";
  text += "plot ";
  if (trade.reference_error && trade.reference_error->relative_l2 > 0)
    text += fmt::format("{:.6g} with lines lc '#999999' lw 1.5 dt 2 title \"reference's error\", ",
                        100 * trade.reference_error->relative_l2);
  text += fmt::format("$front{} using 1:2 with steps lc '#444444' lw 1.5 title 'front'", number);
  for (const Block& block : blocks) {
    const MethodLook look = look_of(block.name);
    text += fmt::format(", ${}{} using 1:2 with points pt {} ps 0.9 lc '{}' title '{}'", block.name, number,
                        look.point, look.colour, block.name);
  }
  return text + "\n";
}

std::string script(const Scene& scene, const Trade& trade, const std::filesystem::path& file) {
  const bool is_svg = file.extension() == ".svg";
  std::string text =
      fmt::format("set terminal {}\nset output {}\n",
                  is_svg ? "svg size 1100,460 font 'DejaVu Sans,13' background '#FFFFFF' noenhanced"
                         : "pngcairo size 1100,460 font 'DejaVu Sans,10' background '#FFFFFF' noenhanced",
                  gnuplot_quoted(file.string()));
  text += fmt::format("set multiplot layout 1,2 title {}\n", gnuplot_quoted(scene.title));
  text += "set logscale xy\nset format x '%g'\nset format y '%g'\n"
          "set grid xtics ytics lc '#E4E4E4' lw 0.8\nset border 3\nset tics nomirror scale 0.6\n"
          "set mxtics\n";
  text += "set lmargin at screen 0.07\nset rmargin at screen 0.44\nset tmargin at screen 0.88\nset bmargin "
          "at screen 0.15\n"
          "set ylabel 'L2 error [%]'\n";
  text += plot(trade, 0);
  text += "set lmargin at screen 0.50\nset rmargin at screen 0.85\nunset ylabel\n";
  text += plot(trade, 1);
  return text + "unset multiplot\nset output\n";
}

} // namespace

std::optional<std::string> draw_trade(const Scene& scene, const Trade& trade,
                                      const std::filesystem::path& file) {
  if (std::ranges::none_of(trade.rows, counts))
    return "no row has an error";
  if (auto reason = why_no_gnuplot())
    return reason;
  write_whole(file, [&](const std::filesystem::path& part) { run_gnuplot(script(scene, trade, part)); });
  return std::nullopt;
}

} // namespace maille::studies
