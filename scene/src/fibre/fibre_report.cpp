#include "maille/scene/fibre/fibre_report.hpp"

#include <fmt/format.h>

#include <numbers>

namespace maille {

std::string in_words(const FibreReport& report) {
  if (report.source != "tensor_image")
    return report.source;
  std::string text = fmt::format("from a tensor image: {} cells", report.cells);
  if (report.without_direction() == 0)
    text += ", each with a direction";
  else
    text += fmt::format(", {} without a direction ({} no tensor, {} not positive, {} isotropic), filled from "
                        "neighbours {}, from "
                        "their label {}, from the body {}",
                        report.without_direction(), report.no_tensor, report.not_positive, report.isotropic,
                        report.from_neighbours, report.from_label, report.from_body);
  if (report.smoothing_radius > 0)
    text += fmt::format("; smoothed over {:.4g} mm, by {:.1f} deg on average", report.smoothing_radius * 1e3,
                        report.smoothing_turn * 180 / std::numbers::pi);
  return text;
}

} // namespace maille
