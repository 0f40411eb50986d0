#include "fit/fit.hpp"
#include "fit/parameters.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::studies {

namespace {

/// What is worth a sentence.
constexpr double worth_saying = 0.01;

/// Which components lose something, how much, and whether anything moves them.
std::string beyond_reach(const FitRow& row, const Scene& scene) {
  std::string driven, left_alone;
  for (int b = 0; b < scene.dimension(); ++b) {
    const double lost = row.floor[b];
    if (lost < worth_saying)
      continue;
    std::string& list = is_driven(scene, b) ? driven : left_alone;
    list += fmt::format("{}{} ({:.3g} %)", list.empty() ? "" : ", ", "xyz"[b], 100 * lost);
  }
  std::string text;
  if (!left_alone.empty())
    text =
        fmt::format("nothing moves {}, which stay 0 whatever the numbers: components do not feel each other, "
                    "so there is no Poisson effect and no bending",
                    left_alone);
  if (!driven.empty())
    text += fmt::format("{}the reference moves {} beyond everything that is prescribed there, which "
                        "components for themselves never do",
                        text.empty() ? "" : "; ", driven);
  return text;
}

bool is_turned(const Scene& scene) {
  return !is_along_grid(scene);
}

} // namespace

std::vector<std::string> reasons_for(const FitReport& report, std::span<const FitCase> fitted) {
  std::vector<std::string> reasons;
  for (std::size_t i = 0; i < fitted.size(); ++i)
    if (const std::string lost = beyond_reach(report.fitted[i], fitted[i].scene); !lost.empty())
      reasons.push_back(fmt::format("{}: at least {:.3g} % with any numbers: {}", report.fitted[i].scene,
                                    100 * report.fitted[i].least(), lost));
  if (std::ranges::any_of(fitted, [](const FitCase& one) { return is_turned(one.scene); }))
    reasons.push_back("fibres are turned against the grid: a turned material couples the components, and "
                      "limits or weights along the "
                      "axes of the grid do not (docs/limits.md)");
  for (const FitRow& row : report.fitted)
    if (row.alone && row.error.relative_l2 - *row.alone > worth_saying)
      reasons.push_back(fmt::format(
          "{}: alone it would come to {:.3g} %, with numbers that serve all scenes it comes to {:.3g} %{}",
          row.scene, 100 * *row.alone, 100 * row.error.relative_l2,
          report.method == "limits" ? "; limits do not grow with the move, elastic strains do" : ""));
  if (report.fit.status == Status::clamped)
    reasons.push_back(
        "no limits were found that let every move through: the best of those that cut some back");
  return reasons;
}

} // namespace maille::studies
