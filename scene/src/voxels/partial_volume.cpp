#include "voxels/partial_volume.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

/// Weights of a Gaussian mean along an axis, from -reach to reach.
struct Gaussian {
  int reach = 0;
  std::vector<double> weight{1};
  double sum = 1;

  /// @param width in voxels
  Gaussian(double width, int size) {
    if (size == 1)
      return;
    reach = static_cast<int>(std::ceil(3 * width));
    weight.clear();
    sum = 0;
    for (int i = -reach; i <= reach; ++i)
      sum += weight.emplace_back(std::exp(-0.5 * std::pow(i / width, 2)));
  }
};

/// Means along one axis; values beyond the border equal those of the border.
class Smoothing {
public:
  Smoothing(const ImageInfo& info, double width)
      : n_{static_cast<std::size_t>(info.size[0]), static_cast<std::size_t>(info.size[1]),
           static_cast<std::size_t>(info.size[2])},
        along_{Gaussian(width / info.spacing[0], info.size[0]),
               Gaussian(width / info.spacing[1], info.size[1]),
               Gaussian(width / info.spacing[2], info.size[2])} {}

  int reach_across() const { return along_[2].reach; }
  /// Smooths a layer along x and y.
  void in_plane(std::span<float> layer) const {
    const int reach = along_[0].reach;
    const auto row = [&](std::size_t j) { return layer.subspan(j * n_[0], n_[0]); };
    std::vector<float> line(n_[0] + 2 * static_cast<std::size_t>(reach));
    for (std::size_t j = 0; j < n_[1]; ++j) {
      std::fill_n(line.begin(), reach, row(j).front());
      std::fill(std::ranges::copy(row(j), line.begin() + reach).out, line.end(), row(j).back());
      mean(
          along_[0], [&](int i) { return line.data() + reach + i; }, row(j));
    }
    const std::vector<float> before(layer.begin(), layer.end());
    for (std::size_t j = 0; j < n_[1]; ++j)
      mean(
          along_[1], [&](int i) { return before.data() + at(j, i, 1) * n_[0]; }, row(j));
  }
  /// Smooths layer k across layers. @pre the layers within reach are loaded
  void across(const LayerWindow& layers, int k, std::span<float> to) const {
    mean(
        along_[2],
        [&](int i) { return layers.layer(static_cast<int>(at(static_cast<std::size_t>(k), i, 2))).data(); },
        to);
  }

private:
  /// Index `of` shifted by i, clipped to the border.
  std::size_t at(std::size_t of, int i, std::size_t axis) const {
    return static_cast<std::size_t>(std::clamp<std::int64_t>(static_cast<std::int64_t>(of) + i, 0,
                                                             static_cast<std::int64_t>(n_[axis]) - 1));
  }
  /// @param from values shifted by i along the axis
  template<class From>
  static void mean(const Gaussian& along, From&& from, std::span<float> to) {
    if (along.reach < 1)
      return std::copy_n(from(0), to.size(), to.begin()), void();
    std::vector<double> sum(to.size(), 0);
    for (int i = -along.reach; i <= along.reach; ++i) {
      const float* const values = from(i);
      const double weight = along.weight[i + along.reach];
      for (std::size_t n = 0; n < to.size(); ++n)
        sum[n] += weight * double{values[n]};
    }
    for (std::size_t n = 0; n < to.size(); ++n)
      to[n] = static_cast<float>(sum[n] / along.sum);
  }

  std::array<std::size_t, 3> n_;
  std::array<Gaussian, 3> along_;
};

/// A window whose layers are modified layers of another window.
/// @param kept   number of layers before the current one that stay loaded
/// @param change modifies a layer in place
template<class Change>
LayerWindow changed(std::shared_ptr<LayerWindow> from, int kept, Change change) {
  return {from->info(), [from, kept, change](int k, std::vector<float>& values) {
            from->move_to(k - kept, k + 1);
            const auto layer = from->layer(k);
            values.insert(values.end(), layer.begin(), layer.end());
            change(std::span(values).last(layer.size()));
          }};
}

std::shared_ptr<LayerWindow> shared(LayerWindow window) {
  return std::make_shared<LayerWindow>(std::move(window));
}

/// Value by linear interpolation between voxel centres. @param at in voxels from the first one's centre
double value_between(const LayerWindow& values, const Index3& size, const Vec3& at) {
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
      sum += weight * double{values.at(voxel)};
  }
  return sum;
}

constexpr int points_along_axis = 4;

/// Bins of values, 128 per power of two; values <= 0 are in the first bin, values inside a body in the last.
constexpr std::size_t n_bins = 0x3f7c;
std::size_t bin_of(float value) {
  return value > 0 ? std::min<std::size_t>(std::bit_cast<std::uint32_t>(value) >> 16, n_bins - 1) : 0;
}

/// Bins of the sample points of a voxel; a single one if all are equal.
void find_bins(const LayerWindow& values, const Index3& size, const Index3& voxel,
               std::vector<std::size_t>& bins) {
  float least = std::numeric_limits<float>::infinity(), most = -least;
  VoxelBlock(voxel, {1, 1, 1}, 1, size).for_each(size, [&](std::size_t v) {
    least = std::min(least, values[v]);
    most = std::max(most, values[v]);
  });
  bins.assign(1, bin_of(least));
  if (bins.front() == bin_of(most)) // uniform neighbourhood: uniform voxel
    return;
  bins.clear();
  const int in_z = size[2] == 1 ? 1 : points_along_axis;
  for (int k = 0; k < in_z; ++k)
    for (int j = 0; j < points_along_axis; ++j)
      for (int i = 0; i < points_along_axis; ++i) {
        const Index3 point{i, j, k};
        Vec3 at{};
        for (std::size_t a = 0; a < 3; ++a)
          at[a] = voxel[a] + (a == 2 && in_z == 1 ? 0.0 : (point[a] + 0.5) / points_along_axis - 0.5);
        bins.push_back(bin_of(static_cast<float>(value_between(values, size, at))));
      }
}

/// The most frequent material of matter voxels in the block or, without any, in the nearest ones.
std::uint8_t material_around(const LayerWindow& image, const std::vector<LabelRange>& ranges,
                             const Index3& cell, const Index3& coarsen) {
  std::array<int, 256> count{};
  const Index3& size = image.info().size;
  for (int margin = 0; margin <= furthest_voxel; ++margin) {
    VoxelBlock(cell, coarsen, margin, size).for_each(size, [&](std::size_t voxel) {
      ++count[material_of(image[voxel], ranges)];
    });
    count[no_material] = 0;
    if (const auto most = std::ranges::max_element(count); *most > 0)
      return static_cast<std::uint8_t>(most - count.begin());
  }
  return ranges.front().material;
}

/// The threshold bin for which the number of tissue points equals that of a material's voxels, and the
/// fraction of the bin that is tissue. @param points by bin
std::pair<std::size_t, double> level_of(const std::vector<std::int64_t>& points, std::int64_t wanted) {
  std::size_t bin = n_bins - 1;
  for (; bin > 0 && points[bin] < wanted; --bin)
    wanted -= points[bin];
  const auto n = static_cast<double>(points[bin]);
  return {bin, n > 0 ? static_cast<double>(wanted) / n : 0};
}

/// 2 G f - G G f for fractions f of voxels.
LayerWindow sharpened(LayerWindow labels, double width) {
  const ImageInfo info = labels.info();
  const auto smoothing = std::make_shared<const Smoothing>(info, width);
  const int reach = smoothing->reach_across();
  const auto in_plane = [smoothing](std::span<float> layer) { smoothing->in_plane(layer); };
  const auto first_planes = shared(changed(shared(std::move(labels)), 0, in_plane));
  const auto once =
      shared({info, [=](int k, std::vector<float>& values) {
                first_planes->move_to(k - reach, k + reach + 1);
                values.resize(values.size() + first_planes->layer_size());
                smoothing->across(*first_planes, k, std::span(values).last(first_planes->layer_size()));
              }});
  // Computed as far ahead as the second mean needs; `once` keeps the layers they are made from.
  const auto second_planes = shared(changed(once, reach, in_plane));
  return {info, [=](int k, std::vector<float>& values) {
            second_planes->move_to(k - reach, k + reach + 1);
            values.resize(values.size() + once->layer_size());
            const auto twice = std::span(values).last(once->layer_size());
            smoothing->across(*second_planes, k, twice);
            for (std::size_t i = 0; i < twice.size(); ++i)
              twice[i] = 2 * once->layer(k)[i] - twice[i];
          }};
}

/// Calls visit(voxel of layer k, is matter, its material or the nearest one, bins) for matter and for voxels
/// that the surface at 1/2 cuts: others have no tissue, so flat faces stay in place.
template<class Visit>
void for_each_voxel(LayerWindow& image, LayerWindow& values, const std::vector<LabelRange>& ranges, int k,
                    Visit&& visit) {
  const Index3& size = values.info().size;
  values.move_to(k - 1, k + 2);
  image.move_to(k - furthest_voxel, k + furthest_voxel + 1);
  std::vector<std::size_t> bins;
  std::size_t voxel = 0;
  for (int j = 0; j < size[1]; ++j)
    for (int i = 0; i < size[0]; ++i, ++voxel) {
      const std::uint8_t own = material_of(image.layer(k)[voxel], ranges);
      find_bins(values, size, {i, j, k}, bins);
      if (own != no_material)
        visit(voxel, true, own, bins);
      else if (*std::ranges::max_element(bins) > bin_of(0.5F))
        visit(voxel, false, material_around(image, ranges, {i, j, k}, {1, 1, 1}), bins);
    }
}

} // namespace

LayerWindow shares_of_labels(LayerWindow image, const std::vector<LabelRange>& ranges) {
  return changed(shared(std::move(image)), 0, [&ranges](std::span<float> values) {
    for (float& value : values)
      value = material_of(value, ranges) == no_material ? 0.0F : 1.0F;
  });
}

LayerWindow shares_of_grey(LayerWindow image, double none, double full) {
  return changed(shared(std::move(image)), 0, [none, full](std::span<float> values) {
    for (float& value : values)
      value = std::isfinite(value)
                  ? static_cast<float>(std::clamp((double{value} - none) / (full - none), 0.0, 1.0))
                  : NAN;
  });
}

Index3 voids_around(const ImageInfo& info, double width, const Index3& coarsen) {
  Index3 voids{};
  const std::size_t n_axes = info.size[2] > 1 ? 3 : 2;
  for (std::size_t a = 0; a < n_axes;
       ++a) { // range of the first mean, plus voxels that the surface may enter
    const int voxels = static_cast<int>(std::min(std::ceil(3 * width / info.spacing[a]), 1e6)) + 2;
    voids[a] = (voxels + coarsen[a] - 1) / coarsen[a] * coarsen[a];
  }
  return voids;
}

LayerWindow shares_of_smoothed(const LayeredImage& image, const std::vector<LabelRange>& ranges,
                               double width) {
  const int n_points =
      points_along_axis * points_along_axis * (image.info().size[2] == 1 ? 1 : points_along_axis);
  std::array<std::int64_t, 256> wanted{};
  std::array<std::vector<std::int64_t>, 256> points;
  const auto labels = [&] { return shared(image.open(1 + 2 * furthest_voxel)); };
  const auto values = [&] { return shared(sharpened(shares_of_labels(image.open(1), ranges), width)); };
  const auto first = values(), seen = labels();
  for (int k = 0; k < image.info().size[2]; ++k)
    for_each_voxel(
        *seen, *first, ranges, k,
        [&](std::size_t, bool is_own, std::uint8_t material, const std::vector<std::size_t>& bins) {
          wanted[material] += is_own ? n_points : 0;
          points[material].resize(n_bins);
          for (const std::size_t bin : bins)
            points[material][bin] += n_points / std::ssize(bins);
        });
  std::array<std::pair<std::size_t, double>, 256> levels;
  for (std::size_t material = 0; material < levels.size(); ++material)
    if (wanted[material] > 0)
      levels[material] = level_of(points[material], wanted[material]);
  return {image.info(),
          [again = values(), voxels = labels(), &ranges, levels](int k, std::vector<float>& to) {
            const std::size_t before = to.size();
            to.resize(before + again->layer_size(), 0);
            for_each_voxel(
                *voxels, *again, ranges, k,
                [&](std::size_t voxel, bool, std::uint8_t material, const std::vector<std::size_t>& bins) {
                  const auto& [level, part] = levels[material];
                  double n = 0;
                  for (const std::size_t bin : bins)
                    n += bin < level ? 0 : bin == level ? part : 1;
                  to[before + voxel] = static_cast<float>(n / static_cast<double>(bins.size()));
                });
          }};
}

std::int64_t fill_partial_cells(const LayeredImage& image, const std::vector<LabelRange>& ranges,
                                const Index3& coarsen, LayerWindow shares, double least, bool of_matter,
                                bool keeps_volume, Specimen& body) {
  const double whole = coarsen[0] * coarsen[1] * coarsen[2];
  const Index3& size = image.info().size;
  LayerWindow voxels = image.open(coarsen[2] + 2 * furthest_voxel);
  std::vector<std::uint8_t> materials = body.material_id;
  std::vector<float> tissue(materials.size(), 0);
  std::array<double, 256> lost{}, room{}; // by material
  std::int64_t without = 0;
  for (std::size_t cell = 0; cell < materials.size(); ++cell) {
    const Index3 at = body.grid.cell_at(static_cast<std::int64_t>(cell));
    const VoxelBlock block(at, coarsen, 0, size);
    if (at[0] == 0 && at[1] == 0) {
      shares.move_to(block.low[2], block.high[2]);
      voxels.move_to(block.low[2] - furthest_voxel, block.high[2] + furthest_voxel);
    }
    double sum = 0;
    block.for_each(size, [&](std::size_t voxel) {
      if (std::isnan(shares[voxel]))
        without += !of_matter || material_of(voxels[voxel], ranges) != no_material ? 1 : 0;
      else
        sum += double{shares[voxel]};
    });
    const double share = sum / whole;
    if ((keeps_volume ? share > 0 : share >= least) && materials[cell] == no_material)
      materials[cell] = material_around(voxels, ranges, at, coarsen);
    if (!(share >= least)) {
      lost[materials[cell]] += share;
      materials[cell] = no_material;
      continue;
    }
    tissue[cell] = static_cast<float>(share);
    room[materials[cell]] += share * (1 - share);
  }
  for (std::size_t cell = 0; keeps_volume && cell < tissue.size(); ++cell)
    if (float& part = tissue[cell]; part > 0 && part < 1)
      part += static_cast<float>(std::min(lost[materials[cell]] / room[materials[cell]], 1.0)) * part *
              (1 - part);
  body.material_id = std::move(materials);
  body.tissue = std::move(tissue);
  return without;
}

} // namespace maille::reader
