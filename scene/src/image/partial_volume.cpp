#include "image/partial_volume.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maille::reader {

namespace {

std::size_t voxel_number(const Index3& size, const Index3& at) {
  return static_cast<std::size_t>(at[0] + std::int64_t{size[0]} * (at[1] + std::int64_t{size[1]} * at[2]));
}

Index3 voxel_at(const Index3& size, std::size_t voxel) {
  const auto row = static_cast<std::int64_t>(voxel) / size[0];
  return {static_cast<int>(static_cast<std::int64_t>(voxel) % size[0]), static_cast<int>(row % size[1]),
          static_cast<int>(row / size[1])};
}

/// Mean along one axis by a Gaussian; beyond the border values go on as they are there.
/// @param width in voxels
void smooth_along(std::size_t axis, double width, const Index3& size, std::vector<float>& values) {
  const int reach = static_cast<int>(std::ceil(3 * width));
  if (size[axis] == 1 || reach < 1)
    return;
  std::vector<double> weight;
  double sum = 0;
  for (int i = -reach; i <= reach; ++i)
    sum += weight.emplace_back(std::exp(-0.5 * std::pow(i / width, 2)));
  std::int64_t stride = 1;
  for (std::size_t a = 0; a < axis; ++a)
    stride *= size[a];
  std::vector<float> line(static_cast<std::size_t>(size[axis]));
  for (std::size_t first = 0; first < values.size(); ++first) {
    if (voxel_at(size, first)[axis] != 0)
      continue;
    for (std::size_t i = 0; i < line.size(); ++i)
      line[i] = values[first + i * static_cast<std::size_t>(stride)];
    for (int i = 0; i < size[axis]; ++i) {
      double mean = 0;
      for (int k = -reach; k <= reach; ++k)
        mean += weight[static_cast<std::size_t>(k + reach)] *
                double{line[static_cast<std::size_t>(std::clamp(i + k, 0, size[axis] - 1))]};
      values[first + static_cast<std::size_t>(i) * static_cast<std::size_t>(stride)] =
          static_cast<float>(mean / sum);
    }
  }
}

std::vector<float> smoothed(std::vector<float> values, const ImageInfo& info, double width) {
  for (std::size_t a = 0; a < 3; ++a)
    smooth_along(a, width / info.spacing[a], info.size, values);
  return values;
}

/// Between the middles of voxels, linear along each axis. @param at in voxels from the first one's middle
double value_between(const std::vector<float>& values, const Index3& size, const Vec3& at) {
  Index3 low{};
  Vec3 part{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double inside = std::clamp(at[a], 0.0, size[a] - 1.0);
    low[a] = std::min(static_cast<int>(inside), std::max(size[a] - 2, 0));
    part[a] = inside - low[a];
  }
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Index3 voxel = low;
    for (std::size_t a = 0; a < 3; ++a) {
      weight *= corner >> a & 1 ? part[a] : 1 - part[a];
      voxel[a] += corner >> a & 1;
    }
    if (weight > 0)
      sum += weight * double{values[voxel_number(size, voxel)]};
  }
  return sum;
}

constexpr int points_along_axis = 4;

/// Of a voxel, by points in it.
float share_above_half(const std::vector<float>& values, const Index3& size, const Index3& voxel) {
  const int in_z = size[2] == 1 ? 1 : points_along_axis;
  int n = 0, above = 0;
  for (int k = 0; k < in_z; ++k)
    for (int j = 0; j < points_along_axis; ++j)
      for (int i = 0; i < points_along_axis; ++i, ++n) {
        const Index3 point{i, j, k};
        Vec3 at{};
        for (std::size_t a = 0; a < 3; ++a)
          at[a] = voxel[a] + (a == 2 && in_z == 1 ? 0.0 : (point[a] + 0.5) / points_along_axis - 0.5);
        above += value_between(values, size, at) > 0.5 ? 1 : 0;
      }
  return static_cast<float>(above) / static_cast<float>(n);
}

/// Calls visit(voxel number) for the voxels of a cell's block and `margin` around it.
template<class Visit>
void for_each_voxel_near(const Index3& cell, const Index3& coarsen, int margin, const Index3& size,
                         Visit&& visit) {
  Index3 low{}, high{};
  for (std::size_t a = 0; a < 3; ++a) {
    low[a] = std::max(cell[a] * coarsen[a] - margin, 0);
    high[a] = std::min((cell[a] + 1) * coarsen[a] + margin, size[a]);
  }
  for (int k = low[2]; k < high[2]; ++k)
    for (int j = low[1]; j < high[1]; ++j)
      for (int i = low[0]; i < high[0]; ++i)
        visit(voxel_number(size, {i, j, k}));
}

/// The material that most voxels of matter have, in the block or as near to it as there are some.
std::uint8_t material_around(const Image& image, const std::vector<LabelRange>& ranges, const Index3& cell,
                             const Index3& coarsen) {
  constexpr int furthest = 8; // voxels
  std::array<int, 256> count{};
  for (int margin = 0; margin <= furthest; ++margin) {
    for_each_voxel_near(cell, coarsen, margin, image.info.size,
                        [&](std::size_t voxel) { ++count[material_of(image.values[voxel], ranges)]; });
    count[no_material] = 0;
    if (const auto most = std::ranges::max_element(count); *most > 0)
      return static_cast<std::uint8_t>(most - count.begin());
  }
  return ranges.front().material;
}

} // namespace

TissueShares shares_of_labels(const Image& image, const std::vector<LabelRange>& ranges) {
  TissueShares shares;
  shares.reserve(image.values.size());
  for (const float value : image.values)
    shares.push_back(material_of(value, ranges) == no_material ? 0.0F : 1.0F);
  return shares;
}

TissueShares shares_of_grey(const Image& image, double none, double full) {
  TissueShares shares;
  shares.reserve(image.values.size());
  for (const float value : image.values)
    shares.push_back(std::isfinite(value)
                         ? static_cast<float>(std::clamp((double{value} - none) / (full - none), 0.0, 1.0))
                         : 0.0F);
  return shares;
}

TissueShares shares_of_smoothed(const TissueShares& labels, const ImageInfo& info, double width) {
  std::vector<float> once = smoothed(labels, info, width);
  const std::vector<float> twice = smoothed(once, info, width);
  for (std::size_t i = 0; i < once.size(); ++i)
    once[i] = 2 * once[i] - twice[i];
  TissueShares shares(once.size());
  for (std::size_t voxel = 0; voxel < shares.size(); ++voxel) {
    const Index3 at = voxel_at(info.size, voxel);
    float least = once[voxel], most = least; // where all around are on one side, so is the voxel
    for (int way = 0; way < 27; ++way) {
      Index3 near{at[0] + way % 3 - 1, at[1] + way / 3 % 3 - 1, at[2] + way / 9 - 1};
      for (std::size_t a = 0; a < 3; ++a)
        near[a] = std::clamp(near[a], 0, info.size[a] - 1);
      const float value = once[voxel_number(info.size, near)];
      least = std::min(least, value);
      most = std::max(most, value);
    }
    shares[voxel] = least > 0.5F ? 1.0F : most <= 0.5F ? 0.0F : share_above_half(once, info.size, at);
  }
  return shares;
}

void fill_partial_cells(const Image& image, const std::vector<LabelRange>& ranges, const Index3& coarsen,
                        const TissueShares& shares, double least, Specimen& body) {
  const double whole = coarsen[0] * coarsen[1] * coarsen[2];
  body.tissue.assign(body.material_id.size(), 0);
  for (std::size_t cell = 0; cell < body.material_id.size(); ++cell) {
    const Index3 at = body.grid.cell_at(static_cast<std::int64_t>(cell));
    double sum = 0;
    for_each_voxel_near(at, coarsen, 0, image.info.size,
                        [&](std::size_t voxel) { sum += double{shares[voxel]}; });
    const double share = sum / whole;
    if (!(share >= least)) {
      body.material_id[cell] = no_material;
      continue;
    }
    body.tissue[cell] = static_cast<float>(share);
    if (body.material_id[cell] == no_material)
      body.material_id[cell] = material_around(image, ranges, at, coarsen);
  }
}

} // namespace maille::reader
