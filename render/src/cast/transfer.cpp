// Converts looks to tables.

#include "cast/cast_task.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace maille::render {

TransferTable transfer_table(const Look& look, const Volume& volume, double step) {
  TransferTable table;
  const Vec3& h = volume.grid().spacing;
  const double unit = look.unit_distance > 0 ? look.unit_distance : std::min({h[0], h[1], h[2]});
  // A maximum has no length: it uses the look's opacity directly.
  const double exponent = look.mode == LookMode::composite ? step / unit : 1;
  table.visible_before.push_back(0);
  for (int i = 0; i < TransferTable::size; ++i) {
    const double value = volume.low() + (volume.high() - volume.low()) * i / (TransferTable::size - 1);
    const double opacity = std::clamp(look.opacity_at(value), 0.0, 1.0);
    table.alpha.push_back(static_cast<float>(1 - std::pow(1 - opacity, exponent)));
    const Rgb colour = look.colour_at(value);
    for (std::size_t a = 0; a < 3; ++a)
      table.colour[a].push_back(colour[a]);
    table.visible_before.push_back(table.visible_before.back() + (table.alpha.back() > 0 ? 1 : 0));
  }
  return table;
}

std::vector<float> gloss_table(const Shading& shading) {
  std::vector<float> gloss;
  for (int i = 0; i < gloss_size; ++i)
    gloss.push_back(static_cast<float>(
        shading.specular * std::pow(static_cast<double>(i) / (gloss_size - 1), shading.shininess)));
  return gloss;
}

namespace {

/// First and last table entry of the codes of a non-empty range, both inclusive.
std::pair<std::size_t, std::size_t> entries_of(const Volume::Range& range, const Volume& volume) {
  const double scale = static_cast<double>(TransferTable::size - 1) / volume.largest_code();
  return {static_cast<std::size_t>(std::max(0.0, std::floor(range.least * scale))),
          static_cast<std::size_t>(
              std::min(static_cast<double>(TransferTable::size - 1), std::ceil(range.largest * scale)))};
}

} // namespace

bool is_visible(const Volume::Range& range, const TransferTable& table, const Look& look,
                const Volume& volume) {
  if (range.least > range.largest)
    return false; // no voxel
  if (look.mode == LookMode::isosurface)
    return volume.low() + range.largest * (volume.high() - volume.low()) / volume.largest_code() >=
           look.isovalue;
  const auto [first, last] = entries_of(range, volume);
  return table.visible_before[last + 1] > table.visible_before[first];
}

bool is_all_visible(const Volume::Range& range, const TransferTable& table, const Look& look,
                    const Volume& volume) {
  if (look.mode == LookMode::isosurface || range.least > range.largest)
    return false;
  const auto [first, last] = entries_of(range, volume);
  return table.visible_before[last + 1] - table.visible_before[first] ==
         static_cast<std::int32_t>(last + 1 - first);
}

} // namespace maille::render
