#include "compare/force_curve.hpp"
#include "mechanics/mechanics_report.hpp"

#include "export/whole_file.hpp"
#include "gnuplot.hpp"
#include "maille/scene/plausibility.hpp"
#include "text.hpp"

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// In CSV, and for people in one.
void add_force_of_curve(ResultTable<CurvePoint>& columns, const std::string& name,
                        std::optional<Vec3> CurvePoint::*force) {
  add_force(columns, name, force);
  columns.add({}, {fmt::format("force on {}s [N]", name), 32, nullptr, true}, force,
              [](const Vec3& of) { return force_in_words(of); });
}

double force_of(const CurvePoint& point) {
  const Vec3& force = *(point.move_force ? point.move_force : point.hold_force);
  return std::hypot(force[0], force[1], force[2]);
}

double energy_of(const CurvePoint& point) {
  return *point.strain_energy;
}

bool has_force(const CurvePoint& point) {
  return point.move_force || point.hold_force;
}

bool has_energy(const CurvePoint& point) {
  return point.strain_energy.has_value();
}

/// What one of the two plots has along y.
struct Axis {
  const char *quantity, *unit;
  bool (*is_there)(const CurvePoint&);
  double (*value)(const CurvePoint&);
};
constexpr std::array<Axis, 2> axes{
    {{"force", "N", has_force, force_of}, {"strain energy", "J", has_energy, energy_of}}};

/// A unit that leaves numbers from 1 to 1000.
struct Scale {
  double factor;
  const char* prefix;
};
Scale scale_for(double largest) {
  constexpr std::array<Scale, 6> scales{
      {{1e3, "k"}, {1, ""}, {1e-3, "m"}, {1e-6, "\xC2\xB5"}, {1e-9, "n"}, {1e-12, "p"}}};
  for (const Scale& scale : scales)
    if (largest >= scale.factor)
      return scale;
  return {1, ""};
}

double largest(const std::vector<ForceCurve>& curves, bool (*is_there)(const CurvePoint&),
               double (*value)(const CurvePoint&)) {
  double most = 0;
  for (const ForceCurve& curve : curves)
    for (const CurvePoint& point : curve.points)
      most = is_there(point) ? std::max(most, value(point)) : most;
  return most;
}

double displacement_of(const CurvePoint& point) {
  return point.largest_displacement;
}

std::string plot(const std::vector<ForceCurve>& curves, std::size_t number, const char* what,
                 const char* per_metre) {
  const Axis& axis = axes[number];
  const double most_x = largest(curves, axis.is_there, displacement_of),
               most_y = largest(curves, axis.is_there, axis.value);
  const Scale along = scale_for(most_x), up = scale_for(most_y);
  std::string blocks, lines;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const ForceCurve& curve = curves[i];
    if (std::ranges::none_of(curve.points, axis.is_there))
      continue;
    blocks += fmt::format("${}{} << EOD\n0 0\n", curve.method, number);
    for (const CurvePoint& point : curve.points)
      if (axis.is_there(point))
        blocks += fmt::format("{:.9g} {:.9g}\n", point.largest_displacement / along.factor,
                              axis.value(point) / up.factor);
    blocks += "EOD\n";
    const MethodLook look = look_of(curve.method);
    // Where two methods agree, the larger point of the first looks out from behind.
    lines += fmt::format("{}${}{} using 1:2 with linespoints pt {} ps {:.2g} lw 1.8 lc '{}' title '{}'",
                         lines.empty() ? "" : ", ", curve.method, number, look.point, i == 0 ? 1.3 : 0.8,
                         look.colour, curve.method);
  }
  return fmt::format(
      "{}set xrange [0:{:.6g}]\nset yrange [0:{:.6g}]\nset xlabel 'largest displacement [{}m]'\n"
      "set ylabel '{} [{}{}{}]' offset -1\nplot {}\n",
      blocks, 1.04 * most_x / along.factor, 1.06 * most_y / up.factor, along.prefix,
      number == 0 ? what : axis.quantity, up.prefix, axis.unit, per_metre, lines);
}

std::string script(const Scene& scene, const std::vector<ForceCurve>& curves,
                   const std::filesystem::path& file) {
  const bool is_svg = file.extension() == ".svg";
  const bool is_moved = std::ranges::any_of(curves, [](const ForceCurve& curve) {
    return std::ranges::any_of(curve.points, [](const CurvePoint& p) { return p.move_force.has_value(); });
  });
  const char* const per_metre = scene.dimension() == 2 ? "/m" : "";
  std::string text =
      fmt::format("set terminal {} size 1000,420 font 'DejaVu Sans,{}' background '#FFFFFF' noenhanced\n"
                  "set encoding utf8\nset output {}\nset multiplot layout 1,2 title {}\n",
                  is_svg ? "svg" : "pngcairo", is_svg ? 13 : 10, gnuplot_quoted(file.string()),
                  gnuplot_quoted(scene.title));
  text += "set format x '%g'\nset format y '%g'\n"
          "set grid xtics ytics lc '#CCCCCC' lw 0.8 dt 3\nset border 3\nset tics nomirror scale 0.6\n"
          "set key left top Left reverse samplen 2 spacing 1.25\n"
          "set lmargin at screen 0.085\nset rmargin at screen 0.485\nset tmargin at screen 0.87\n"
          "set bmargin at screen 0.15\n";
  text += plot(curves, 0, is_moved ? "force on moves" : "force on holds", per_metre);
  text += "set lmargin at screen 0.575\nset rmargin at screen 0.985\nunset key\n";
  text += plot(curves, 1, "", per_metre);
  return text + "unset multiplot\nset output\n";
}

} // namespace

std::optional<Vec3> sum_of(const std::vector<Resultant>& resultants) {
  return resultants.empty() ? std::nullopt : std::optional(total_force(resultants));
}

std::string force_in_words(std::span<const double> force) {
  double largest = 0;
  for (const double component : force)
    largest = std::max(largest, std::abs(component));
  std::string text;
  for (const double component : force)
    text += fmt::format("{}{:.4g}", text.empty() ? "(" : ", ",
                        std::abs(component) > 1e-6 * largest ? component : 0);
  return text + ")";
}

ForceCurve force_curve(const Scene& scene, const std::string& method, const std::vector<Comparison>& steps,
                       int n_steps) {
  ForceCurve curve{method, {}};
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (const ComparisonRow& row : steps[i].rows) {
      if (!row.mechanics)
        continue;
      curve.points.push_back({static_cast<int>(i) + 1, static_cast<double>(i + 1) / n_steps,
                              largest_displacement(scene, row.answer.displacement),
                              sum_of(row.mechanics->moves), sum_of(row.mechanics->holds),
                              row.answer.strain_energy});
    }
  return curve;
}

const ResultTable<CurvePoint>& columns_of_curve() {
  static const ResultTable<CurvePoint> table = [] {
    ResultTable<CurvePoint> columns({.digits = 9});
    columns.add({"step", "", "", "from 1 on"}, {"step", 6}, &CurvePoint::step);
    columns.add({"fraction", "", "", "of the moves and loads"}, {"fraction", 9, in_percent},
                &CurvePoint::fraction);
    columns.add({"largest_displacement_m", "", "m", "of a node"}, {"moves up to", 12, length_in_words},
                &CurvePoint::largest_displacement);
    add_force_of_curve(columns, "move", &CurvePoint::move_force);
    add_force_of_curve(columns, "hold", &CurvePoint::hold_force);
    columns.add({"strain_energy_j", "", "J", "J/m in 2D"}, {"energy [J]", 12, nullptr, true},
                &CurvePoint::strain_energy);
    return columns;
  }();
  return table;
}

std::optional<std::string> draw_curves(const Scene& scene, const std::vector<ForceCurve>& curves,
                                       const std::filesystem::path& file) {
  for (const Axis& axis : axes)
    if (!(largest(curves, axis.is_there, axis.value) > 0))
      return fmt::format("no step has a {} to draw", axis.quantity);
  if (auto reason = why_no_gnuplot())
    return reason;
  write_whole(file, [&](const std::filesystem::path& part) { run_gnuplot(script(scene, curves, part)); });
  return std::nullopt;
}

} // namespace maille::studies
