#include "maille/scene/warp/displacement_field.hpp"

#include "conditions/number_table.hpp"
#include "maille/scene/scene.hpp"
#include "maille/scene/voxel_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace maille {

bool is_image_file(const std::filesystem::path& file) {
  return has_image_ending(file) || std::filesystem::is_directory(file);
}

DisplacementImage::DisplacementImage(const std::filesystem::path& file, double metres, const Specimen* body)
    : image_(read_image(file)), metres_(metres) {
  const int n = image_.info.components, axes = image_.info.size[2] == 1 ? 2 : 3;
  if (n != 3 && n != axes)
    throw InputError(
        {{file.string(), 0, "", fmt::format("{} values a voxel: a displacement along each axis", axes),
          fmt::format("{}", n)}});
  if (!body)
    return;
  image_.info = in_world_of(image_.info, *body);
  if (const auto& rows = image_.info.vectors_to_world) {
    to_object_.emplace();
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t row = 0; row < 3; ++row)
          (*to_object_)[a][c] += body->placement.direction[row][a] * (*rows)[row][c];
  }
  continue_matter(file, *body);
}

/// Extrapolates: displacement images are 0 outside matter, but the surface is half a voxel beyond the outer
/// centres.
void DisplacementImage::continue_matter(const std::filesystem::path& file, const Specimen& body) {
  const ImageInfo& info = image_.info;
  const Index3& n = info.size;
  const std::size_t n_voxels = info.n_voxels();
  const std::size_t components = info.components;
  std::vector<bool> is_known(n_voxels, true), is_matter(n_voxels, false);
  std::int64_t n_unknown = 0, n_matter = 0;
  std::size_t voxel = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i, ++voxel) {
        Vec3 world = info.origin;
        const Vec3 along{i * info.spacing[0], j * info.spacing[1], k * info.spacing[2]};
        for (std::size_t row = 0; row < 3; ++row)
          for (std::size_t a = 0; a < 3; ++a)
            world[row] += info.direction[row][a] * along[a];
        const Vec3 x = point_in_object(body.placement, world);
        Index3 cell{};
        for (int a = 0; a < body.grid.dimension(); ++a)
          cell[a] = static_cast<int>(
              std::floor(std::clamp((x[a] - body.origin[a]) / body.grid.spacing()[a], -1.0, 2e9)));
        is_matter[voxel] = body.grid.has_cell(cell) && body.is_matter(body.grid.cell(cell));
        n_matter += is_matter[voxel] ? 1 : 0;
        bool is_zero = true, is_finite = true;
        for (std::size_t c = 0; c < components; ++c) {
          is_zero = is_zero && image_.values[c * n_voxels + voxel] == 0;
          is_finite = is_finite && std::isfinite(image_.values[c * n_voxels + voxel]);
        }
        is_known[voxel] = is_matter[voxel] || !(is_zero || !is_finite);
        n_unknown += is_known[voxel] ? 0 : 1;
      }
  if (n_unknown == 0 || n_matter == 0)
    return;
  const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(n[0]),
                                          static_cast<std::size_t>(n[0]) * static_cast<std::size_t>(n[1])};
  std::int64_t n_continued = 0;
  for (int pass = 0; pass < 3; ++pass) { // across faces, then edges, then corners
    const std::vector<bool> before = is_known;
    voxel = 0;
    for (int k = 0; k < n[2]; ++k)
      for (int j = 0; j < n[1]; ++j)
        for (int i = 0; i < n[0]; ++i, ++voxel) {
          if (before[voxel])
            continue;
          const Index3 at{i, j, k};
          Vec3 sum{};
          int n_lines = 0;
          for (std::size_t a = 0; a < 3; ++a)
            for (const int step : {-1, 1}) {
              const auto inside = [&](int of) { return at[a] + of * step >= 0 && at[a] + of * step < n[a]; };
              const auto place = [&](std::size_t of) {
                return step > 0 ? voxel + of * stride[a] : voxel - of * stride[a];
              };
              if (!inside(1) || !before[place(1)] || (pass == 0 && !is_matter[place(1)]))
                continue;
              ++n_lines;
              const bool has_second = inside(2) && before[place(2)];
              for (std::size_t c = 0; c < components; ++c) {
                const float near = image_.values[c * n_voxels + place(1)];
                sum[c] += has_second ? 2 * double{near} - double{image_.values[c * n_voxels + place(2)]}
                                     : double{near};
              }
            }
          if (n_lines == 0)
            continue;
          is_known[voxel] = true;
          ++n_continued;
          for (std::size_t c = 0; c < components; ++c)
            image_.values[c * n_voxels + voxel] = static_cast<float>(sum[c] / n_lines);
        }
  }
  if (n_continued > 0)
    warn_of_file(
        file, fmt::format("is 0 or no number beside the matter: the field goes on in a straight line over {} "
                          "voxels around it",
                          n_continued));
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
      continue; // a slice is constant across its plane
    if (!(index >= -0.5 - rounding && index <= last + 0.5 + rounding))
      return std::nullopt;
    index = std::clamp(index, 0.0, last);
    low[a] = std::min(static_cast<int>(index), info.size[a] - 2);
    part[a] = index - low[a];
  }
  Vec3 sum{};
  const std::size_t n = info.n_voxels();
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
  if (!to_object_)
    return sum;
  Vec3 turned{};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t c = 0; c < 3; ++c)
      turned[a] += (*to_object_)[a][c] * sum[c];
  return turned;
}

std::vector<DisplacementPoint> read_displacement_points(const std::filesystem::path& file,
                                                        const FileUnits* scene) {
  constexpr Dimension length = Dimension::length;
  const reader::NumberTable table = reader::read_number_table(file,
                                                              {{"x", length},
                                                               {"y", length},
                                                               {"z", length, false},
                                                               {"ux", length},
                                                               {"uy", length},
                                                               {"uz", length, false},
                                                               {"sigma", length, false}},
                                                              scene ? *scene : FileUnits{});
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
  std::map<Vec3, const DisplacementPoint*> at;
  for (const DisplacementPoint& point : points)
    if (const auto [there, is_new] = at.emplace(point.place, &point);
        !is_new && there->second->displacement != point.displacement)
      faults.push_back({file.string(), point.line, "x", "each place once",
                        fmt::format("({:g}, {:g}, {:g}) m of line {} again, with another displacement",
                                    point.place[0], point.place[1], point.place[2], there->second->line)});
  if (!faults.empty())
    throw InputError(std::move(faults));
  return points;
}

} // namespace maille
