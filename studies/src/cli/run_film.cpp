#include "cli/outputs.hpp"

#include "maille/materials/text_file.hpp"
#include "picture/comparison_picture.hpp"
#include "play/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

namespace maille::studies {

std::optional<std::string> film_steps(const Scene& scene, const std::string& method,
                                      const std::vector<Comparison>& steps,
                                      const std::filesystem::path& mp4) {
  constexpr double film_seconds = 4, longest_frame = 0.25; // few steps; upper bound per step
  constexpr int n_digits = 6;
  if (!has_ffmpeg())
    return "no film: there is no `ffmpeg` to run";
  const Displacement rest(scene.specimen.grid);
  std::vector<std::pair<double, const Displacement*>> moments{{0, &rest}};
  for (std::size_t i = 0; i < steps.size(); ++i)
    for (const ComparisonRow& row : steps[i].rows)
      if (has_displacement(row.answer.status))
        moments.emplace_back(static_cast<double>(i + 1) / static_cast<double>(steps.size()),
                             &row.answer.displacement);
  if (moments.size() < 2)
    return "no film: no step has an answer";
  PictureSettings settings;
  settings.title = scene.title;
  settings.width = settings.largest_height = 1000;
  settings.warp = 1;
  settings.is_anatomical = scene.specimen.shape == "image";
  for (const auto& moment : moments)
    settings.also_in_view.push_back(moment.second);
  const WorkFolder frames("maille_film");
  const std::filesystem::path stem = frames / "step";
  std::int64_t n = 0;
  for (const auto& [time, displacement] : moments) {
    const std::filesystem::path png = fmt::format("{}_{:0{}}.png", stem.string(), n++, n_digits);
    PicturePanel panel;
    panel.label = fmt::format("{}, {:.0f} %", method, 100 * time);
    panel.displacement = displacement;
    if (const auto why_not = render_comparison(scene, {panel}, png, settings))
      return "no film: " + *why_not;
  }
  const double frame_seconds = std::min(longest_frame, film_seconds / static_cast<double>(n));
  return make_film(stem, n_digits, n, frame_seconds, mp4);
}

} // namespace maille::studies
