#include "explain_fibres.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maille::studies {

std::string fibre_words(const Specimen& body) {
  if (body.fibres.empty())
    return "one direction everywhere";
  return body.fibre_report.source.empty() ? "a direction for each cell" : in_words(body.fibre_report);
}

nlohmann::ordered_json in_json(const FibreReport& report) {
  return {{"source", report.source},
          {"cells", report.cells},
          {"without_direction",
           {{"no_tensor", report.no_tensor},
            {"not_positive", report.not_positive},
            {"isotropic", report.isotropic}}},
          {"filled",
           {{"from_neighbours", report.from_neighbours},
            {"from_label", report.from_label},
            {"from_body", report.from_body}}},
          {"smoothing_radius_m", report.smoothing_radius},
          {"smoothing_turn_deg", report.smoothing_turn * 180 / std::numbers::pi}};
}

std::string contraction_words(const Scene& scene) {
  double least = INFINITY, most = 0;
  std::int64_t count = 0;
  for (const double stress : scene.active_stress)
    if (stress > 0) {
      least = std::min(least, stress);
      most = std::max(most, stress);
      ++count;
    }
  if (count == 0)
    return "no fibre pulls";
  const std::string range =
      least == most ? fmt::format("{:.4g} Pa", most) : fmt::format("{:.4g} to {:.4g} Pa", least, most);
  return fmt::format("fibres of {} pull with {}: coupled and finite elements only",
                     count == 1 ? "1 cell" : fmt::format("{} cells", count), range);
}

} // namespace maille::studies
