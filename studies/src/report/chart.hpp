#pragma once
/// Plots, drawn by gnuplot.

#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

struct ChartPoint {
  double x = 0, y = 0;
};

struct ChartSeries {
  std::string name; ///< a method's name has the colour that it has everywhere
  std::vector<ChartPoint> points;
};

struct Chart {
  std::string x_label, y_label;
  bool log_x = false, log_y = false;
  bool has_lines = false; ///< between the points of a series
  std::vector<ChartSeries> series;
};

/// For pages of light and of dark colour, without ground.
struct DrawnChart {
  std::string light_svg, dark_svg;
};

/// @return nothing where there is no gnuplot, or it failed; `why_not` then says so
std::optional<DrawnChart> draw_chart(const Chart& chart, std::string& why_not);

} // namespace maille::studies
