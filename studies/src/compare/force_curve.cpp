#include "compare/force_curve.hpp"
#include "mechanics/mechanics_report.hpp"

#include "compare/plots.hpp"
#include "maille/scene/plausibility.hpp"
#include "text.hpp"

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// Adds a force: components in CSV, one column in the text.
void add_force_of_curve(ResultTable<CurvePoint>& columns, const std::string& name,
                        std::optional<Vec3> CurvePoint::*force) {
  add_force(columns, name, force);
  columns.add({}, {fmt::format("force on {}s [N]", name), 32, nullptr, true}, force,
              [](const Vec3& of) { return vector_in_words(of); });
}

std::optional<double> force_of(const CurvePoint& point) {
  const std::optional<Vec3>& force = point.move_force ? point.move_force : point.hold_force;
  return force ? std::optional(std::hypot((*force)[0], (*force)[1], (*force)[2])) : std::nullopt;
}

} // namespace

std::optional<Vec3> sum_of(const std::vector<Resultant>& resultants) {
  return resultants.empty() ? std::nullopt : std::optional(total_force(resultants));
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
  bool has_force = false, has_energy = false, is_moved = false;
  nlohmann::ordered_json lines = nlohmann::ordered_json::object();
  for (const ForceCurve& curve : curves)
    for (const CurvePoint& point : curve.points) {
      const std::optional<double> force = force_of(point);
      has_force = has_force || force.value_or(0) > 0;
      has_energy = has_energy || point.strain_energy.value_or(0) > 0;
      is_moved = is_moved || point.move_force.has_value();
      lines[curve.method].push_back(
          {point.largest_displacement, json_number(force), json_number(point.strain_energy)});
    }
  if (!has_force || !has_energy)
    return fmt::format("no step has a {} to draw", has_force ? "strain energy" : "force");
  return draw_curves({{"title", scene.title},
                      {"curves", std::move(lines)},
                      {"what", is_moved ? "force on moves" : "force on holds"},
                      {"per_metre", scene.dimension() == 2 ? "/m" : ""}},
                     file);
}

} // namespace maille::studies
