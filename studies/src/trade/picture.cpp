#include "maille/studies/export/whole_file.hpp"
#include "maille/studies/trade.hpp"
#include "trade/text.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <utility>

#include <sys/wait.h>

namespace maille::studies {

namespace {

/// Apart also where red and green look alike (Wong 2011, Nature Methods 8, 441), and by shape.
struct Look {
  const char* method;
  const char* colour;
  int point;
};
constexpr std::array<Look, 8> looks{{{"limits", "#0072B2", 5},
                                     {"literal", "#56B4E9", 4},
                                     {"sweep", "#CC79A7", 8},
                                     {"relaxed", "#009E73", 9},
                                     {"coupled", "#D55E00", 7},
                                     {"fem_q1", "#7F7F7F", 11},
                                     {"fem_q2", "#000000", 13},
                                     {"dijkstra", "#F0E442", 3}}};

Look look_of(const std::string& method) {
  for (const Look& look : looks)
    if (method == look.method)
      return look;
  return {"", "#8C564B", 1};
}

bool counts(const TradeRow& row) {
  return is_settled(row.status) && row.error && row.error->relative_l2 > 0 && row.seconds.total() > 0;
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

/// gnuplot's strings in single quotes.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text)
    if (c == '\'')
      result += "''";
    else if (c != '\n')
      result += c;
  return result + "'";
}

std::string plot(const Trade& trade, std::size_t number) {
  const Axis& axis = axes[number];
  const auto blocks = blocks_of_methods(trade, axis, number);
  std::string text = front_block(trade, axis, number);
  for (const Block& block : blocks)
    text += block.data;
  text += fmt::format("set xlabel '{}'\n", axis.label);
  text += number == 0 ? "unset key\n" : "set key outside right top Left reverse samplen 1.5 spacing 1.25\n";
  text += "plot ";
  if (trade.reference_error && trade.reference_error->relative_l2 > 0)
    text += fmt::format("{:.6g} with lines lc '#999999' lw 1.5 dt 2 title \"the reference's\\nown error\", ",
                        100 * trade.reference_error->relative_l2);
  text += fmt::format("$front{} using 1:2 with steps lc '#444444' lw 1.5 title 'front'", number);
  for (const Block& block : blocks) {
    const Look look = look_of(block.name);
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
                  quoted(file.string()));
  text += fmt::format("set multiplot layout 1,2 title {}\n", quoted(scene.title));
  text += "set logscale xy\nset format x '%g'\nset format y '%g'\n"
          "set grid xtics ytics lc '#E4E4E4' lw 0.8\nset border 3\nset tics nomirror scale 0.6\n"
          "set offsets graph 0.05, graph 0.05, graph 0.06, graph 0.06\n";
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
  if (std::system("command -v gnuplot > /dev/null 2>&1") != 0)
    return "there is no `gnuplot` to run: install the package gnuplot-nox";
  int status = 0;
  write_whole(file, [&](const std::filesystem::path& part) {
    const std::string commands = script(scene, trade, part);
    FILE* pipe = popen("gnuplot -d > /dev/null 2>&1", "w"); // -d: without the user's own settings
    if (pipe == nullptr)
      throw std::runtime_error("cannot start gnuplot");
    const bool is_written = std::fwrite(commands.data(), 1, commands.size(), pipe) == commands.size();
    status = pclose(pipe);
    if (!is_written || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
      throw std::runtime_error(fmt::format("gnuplot ended with status {}", status));
  });
  return std::nullopt;
}

} // namespace maille::studies
