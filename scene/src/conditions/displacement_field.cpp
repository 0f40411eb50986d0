#include "maille/scene/warp/displacement_field.hpp"

#include "conditions/number_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

namespace maille {

DisplacementImage::DisplacementImage(const std::filesystem::path& file, double metres)
    : image_(read_image(file)), metres_(metres) {
  const int n = image_.info.components, axes = image_.info.size[2] == 1 ? 2 : 3;
  if (n != 3 && n != axes)
    throw InputError(
        {{file.string(), 0, "", fmt::format("{} values a voxel: a displacement along each axis", axes),
          fmt::format("{}", n)}});
}

std::optional<Vec3> DisplacementImage::at(const Vec3& point) const {
  const ImageInfo& info = image_.info;
  Index3 low{};
  Vec3 part{};
  for (std::size_t a = 0; a < 3; ++a) {
    double index = 0;
    for (std::size_t row = 0; row < 3; ++row)
      index += info.direction[row][a] * (point[row] - info.origin[row]) / info.spacing[a];
    constexpr double rounding = 1e-6;
    const double last = info.size[a] - 1;
    if (info.size[a] == 1)
      continue; // a slice goes on across itself
    if (!(index >= -0.5 - rounding && index <= last + 0.5 + rounding))
      return std::nullopt;
    index = std::clamp(index, 0.0, last);
    low[a] = std::min(static_cast<int>(index), info.size[a] - 2);
    part[a] = index - low[a];
  }
  Vec3 sum{};
  const auto n = static_cast<std::size_t>(info.n_voxels());
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Index3 at = low;
    for (std::size_t a = 0; a < 3; ++a) {
      weight *= corner >> a & 1 ? part[a] : 1 - part[a];
      at[a] += corner >> a & 1;
    }
    if (weight == 0)
      continue;
    const auto voxel = static_cast<std::size_t>(at[0] + std::int64_t{info.size[0]} *
                                                            (at[1] + std::int64_t{info.size[1]} * at[2]));
    for (std::size_t c = 0; c < static_cast<std::size_t>(info.components); ++c)
      sum[c] += weight * metres_ * double{image_.values[c * n + voxel]};
  }
  if (!std::ranges::all_of(sum, [](double value) { return std::isfinite(value); }))
    return std::nullopt;
  return sum;
}

std::vector<DisplacementPoint> read_displacement_points(const std::filesystem::path& file) {
  constexpr Dimension length = Dimension::length;
  const reader::NumberTable table = reader::read_number_table(file, {{"x", length},
                                                                     {"y", length},
                                                                     {"z", length, false},
                                                                     {"ux", length},
                                                                     {"uy", length},
                                                                     {"uz", length, false},
                                                                     {"sigma", length, false}});
  std::vector<DisplacementPoint> points;
  std::vector<Fault> faults;
  for (const reader::NumberRow& row : table.rows) {
    const auto& v = row.values;
    points.push_back({{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, std::nullopt, row.line});
    if (!table.has[6])
      continue;
    points.back().sigma = v[6];
    if (!(v[6] > 0))
      faults.push_back({file.string(), row.line, "sigma", "a length > 0", fmt::format("{} m", v[6])});
  }
  if (!faults.empty())
    throw InputError(std::move(faults));
  return points;
}

} // namespace maille
