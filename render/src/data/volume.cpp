#include "maille/render/volume.hpp"
#include "maille/base/vectors.hpp"

#include "maille/base/arena.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace maille::render {

namespace {

/// Bytes past the end that vectors may read: pairs of values; two gradients (six bytes) as eight bytes.
constexpr std::size_t padding = 8;

/// Passes of a binomial filter before gradients; together a Gaussian of sqrt(passes / 2) voxels. Without it,
/// steps between voxels appear as rings; four passes blur lips and lids.
constexpr int smoothing_passes = 2;

/// Filter 1/4, 1/2, 1/4 along an axis; values beyond the border equal those of the border.
void smooth_along(std::vector<float>& values, const Index3& size, std::size_t axis) {
  std::size_t stride = 1;
  for (std::size_t a = 0; a < axis; ++a)
    stride *= size[a];
  const std::size_t n = size[axis];
  std::vector<float> before(stride); // the row below, as it was
  for (std::size_t first = 0; first < values.size(); first += n * stride) {
    std::copy_n(values.data() + first, stride, before.begin());
    for (std::size_t i = 0; i < n; ++i) {
      float* const row = values.data() + first + i * stride;
      const float* const above = i + 1 < n ? row + stride : row;
      for (std::size_t s = 0; s < stride; ++s)
        row[s] = 0.25f * (std::exchange(before[s], row[s]) + above[s]) + 0.5f * row[s];
    }
  }
}

} // namespace

Vec3 VoxelGrid::index_of(const Vec3& point) const {
  const Vec3 along = transposed_times(direction, minus(point, origin));
  return {along[0] / spacing[0], along[1] / spacing[1], along[2] / spacing[2]};
}

Vec3 VoxelGrid::point_of(const Vec3& index) const {
  return plus(origin,
              times(direction, Vec3{spacing[0] * index[0], spacing[1] * index[1], spacing[2] * index[2]}));
}

Volume::Volume(const VoxelGrid& grid, std::span<const float> values, double low, double high, Depth depth,
               bool with_gradients)
    : grid_(grid), low_(low), high_(high > low ? high : low + 1), depth_(depth) {
  const std::size_t n = grid.n_voxels();
  const double scale = largest_code() / (high_ - low_);
  const auto code_of = [&](float value) {
    const double code = (static_cast<double>(value) - low_) * scale + 0.5;
    return code > 0 ? std::min(code, static_cast<double>(largest_code())) : 0.0; // NaN: 0
  };
  if (depth == Depth::bits8) {
    resize_in_large_pages(codes8_, n + padding);
    for (std::size_t v = 0; v < n; ++v)
      codes8_[v] = static_cast<std::uint8_t>(code_of(values[v]));
  } else {
    resize_in_large_pages(codes16_, n + padding);
    for (std::size_t v = 0; v < n; ++v)
      codes16_[v] = static_cast<std::uint16_t>(code_of(values[v]));
  }
  if (with_gradients)
    fill_gradients(values);
  fill_bricks();
}

int Volume::code(std::int64_t voxel) const {
  const std::size_t v = voxel;
  return depth_ == Depth::bits8 ? codes8_[v] : codes16_[v];
}

double Volume::value(std::int64_t voxel) const {
  return low_ + code(voxel) * (high_ - low_) / largest_code();
}

Vec3 Volume::gradient(std::int64_t voxel) const {
  Vec3 g{};
  for (std::size_t a = 0; a < 3; ++a)
    g[a] = gradients_[3 * static_cast<std::size_t>(voxel) + a] / 127.0;
  return g;
}

void Volume::fill_gradients(std::span<const float> values) {
  const auto [nx, ny, nz] = grid_.size;
  resize_in_large_pages(gradients_, 3 * static_cast<std::size_t>(grid_.n_voxels()) + padding);
  const Vec3& h = grid_.spacing;
  const double smallest = std::min({h[0], h[1], h[2]});
  // A slope of 1/200 of the range per voxel has half of the maximum length: noise has little weight, and
  // edges do not dominate.
  const double knee = 0.005 * (high_ - low_) / smallest;
  std::vector<float> smooth(values.size());
  std::ranges::transform(values, smooth.begin(), [&](float value) {
    return static_cast<float>(value >= low_ ? std::min<double>(value, high_) : low_);
  });
  for (int pass = 0; pass < smoothing_passes; ++pass)
    for (std::size_t a = 0; a < 3; ++a)
      smooth_along(smooth, grid_.size, a);
  const auto at = [&](int i, int j, int k) -> double {
    return smooth[i + std::int64_t{nx} * (j + std::int64_t{ny} * k)];
  };
  std::size_t out = 0;
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i, out += 3) {
        const int i0 = std::max(i - 1, 0), i1 = std::min(i + 1, nx - 1), j0 = std::max(j - 1, 0),
                  j1 = std::min(j + 1, ny - 1), k0 = std::max(k - 1, 0), k1 = std::min(k + 1, nz - 1);
        const Vec3 g{(at(i1, j, k) - at(i0, j, k)) / (std::max(1, i1 - i0) * h[0]),
                     (at(i, j1, k) - at(i, j0, k)) / (std::max(1, j1 - j0) * h[1]),
                     (at(i, j, k1) - at(i, j, k0)) / (std::max(1, k1 - k0) * h[2])};
        const double size = length(g);
        const double scale = size > 0 ? 127 / (size + knee) : 0;
        for (std::size_t a = 0; a < 3; ++a)
          gradients_[out + a] = static_cast<std::int8_t>(std::lround(g[a] * scale));
      }
}

Volume::Range Volume::range_of(const Index3& first, const Index3& last) const {
  Range range{65535, 0};
  Index3 from{}, to{};
  for (std::size_t a = 0; a < 3; ++a) {
    from[a] = std::max(first[a], 0);
    to[a] = std::min(last[a], grid_.size[a] - 1);
  }
  const auto look = [&](const auto* codes) {
    int least = 65535, largest = 0;
    for (int k = from[2]; k <= to[2]; ++k)
      for (int j = from[1]; j <= to[1]; ++j) {
        const auto* row = codes + std::int64_t{grid_.size[0]} * (j + std::int64_t{grid_.size[1]} * k);
        for (int i = from[0]; i <= to[0]; ++i) {
          least = std::min<int>(least, row[i]);
          largest = std::max<int>(largest, row[i]);
        }
      }
    range = {static_cast<std::uint16_t>(least), static_cast<std::uint16_t>(largest)};
  };
  if (depth_ == Depth::bits8)
    look(codes8());
  else
    look(codes16());
  return range;
}

void Volume::fill_bricks() {
  for (std::size_t a = 0; a < 3; ++a)
    bricks_[a] = std::max(1, (grid_.size[a] - 2 + brick_edge) >> brick_shift);
  ranges_.reserve(static_cast<std::size_t>(bricks_[0]) * static_cast<std::size_t>(bricks_[1] * bricks_[2]));
  for (int k = 0; k < bricks_[2]; ++k)
    for (int j = 0; j < bricks_[1]; ++j)
      for (int i = 0; i < bricks_[0]; ++i) {
        const Index3 first{i * brick_edge, j * brick_edge, k * brick_edge};
        ranges_.push_back(
            range_of(first, {first[0] + brick_edge, first[1] + brick_edge, first[2] + brick_edge}));
      }
}

namespace {

/// Calls take(voxel, weight) for the up to eight voxels around a point. @return false outside
template<class Take>
bool around(const VoxelGrid& grid, const Vec3& index, Take&& take) {
  Index3 low{};
  Vec3 part{};
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(index[a] >= 0 && index[a] <= grid.size[a] - 1))
      return false;
    low[a] = std::clamp(static_cast<int>(index[a]), 0, std::max(0, grid.size[a] - 2));
    part[a] = index[a] - low[a];
  }
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Index3 at = low;
    for (std::size_t a = 0; a < 3; ++a) {
      const bool upper = ((corner >> a) & 1) != 0;
      weight *= upper ? part[a] : 1 - part[a];
      at[a] += upper ? 1 : 0;
    }
    if (weight != 0)
      take(at[0] + std::int64_t{grid.size[0]} * (at[1] + std::int64_t{grid.size[1]} * at[2]), weight);
  }
  return true;
}

} // namespace

double Volume::value_at(const Vec3& index) const {
  double sum = 0;
  return around(grid_, index, [&](std::int64_t voxel, double weight) { sum += weight * value(voxel); })
             ? sum
             : low_;
}

std::int64_t Volume::bytes() const {
  return static_cast<std::int64_t>(codes8_.size() + 2 * codes16_.size() + gradients_.size() +
                                   ranges_.size() * sizeof(Range));
}

} // namespace maille::render
