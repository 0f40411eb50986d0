// Images and labels where their matter has gone, and what became of each label.

#include "maille/scene/warp/warp.hpp"
#include "warp/deformed_cells.hpp"
#include "warp/label_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <span>
#include <stdexcept>
#include <vector>

namespace maille {

namespace {

using namespace warping;
using Eigen::Vector3d;

void check_grid(const Pull& pull, const Image& image) {
  const auto n = static_cast<std::size_t>(pull.grid.n_voxels());
  if (image.info.size != pull.grid.size || image.info.components < 1 ||
      image.values.size() != n * static_cast<std::size_t>(image.info.components))
    throw std::invalid_argument("expected an image on the grid of the pull");
}

/// Linear between middles of voxels; the outermost half voxel has the value of the voxel.
float linear(const float* values, const Index3& size, const Vector3d& at) {
  std::array<std::size_t, 3> low{}, high{};
  std::array<double, 3> part{};
  bool is_between = true; // eight voxels, along every axis
  for (std::size_t a = 0; a < 3; ++a) {
    const double x = std::clamp(at[static_cast<Eigen::Index>(a)], 0.0, size[a] - 1.0);
    low[a] = static_cast<std::size_t>(x);
    high[a] = std::min(low[a] + 1, static_cast<std::size_t>(size[a]) - 1);
    part[a] = x - static_cast<double>(low[a]);
    is_between = is_between && part[a] > 0;
  }
  const auto row = static_cast<std::size_t>(size[0]), layer = row * static_cast<std::size_t>(size[1]);
  if (is_between) {
    const float* const from = values + low[0] + low[1] * row + low[2] * layer;
    const auto mean = [](double a, double b, double of) { return (1 - of) * a + of * b; };
    const auto along_x = [&](const float* two) { return mean(double{two[0]}, double{two[1]}, part[0]); };
    return static_cast<float>(mean(mean(along_x(from), along_x(from + row), part[1]),
                                   mean(along_x(from + layer), along_x(from + layer + row), part[1]),
                                   part[2]));
  }
  const auto between = [&](std::size_t j, std::size_t k) {
    const float* const begin = values + j * row + k * layer;
    // Equal neighbours, infinities among them, keep their value.
    return part[0] == 0 ? double{begin[low[0]]}
                        : (1 - part[0]) * double{begin[low[0]]} + part[0] * double{begin[high[0]]};
  };
  const auto in_layer = [&](std::size_t k) {
    return part[1] == 0 ? between(low[1], k)
                        : (1 - part[1]) * between(low[1], k) + part[1] * between(high[1], k);
  };
  return static_cast<float>(part[2] == 0 ? in_layer(low[2])
                                         : (1 - part[2]) * in_layer(low[2]) + part[2] * in_layer(high[2]));
}

struct Sum {
  std::int64_t voxels = 0;
  Vector3d indices = Vector3d::Zero();
  void add(const Vector3d& at) {
    ++voxels;
    indices += at;
  }
  Vec3 centroid(const Affine3& to_world) const {
    if (voxels == 0)
      return {};
    const Vector3d x = to_world.of(indices / static_cast<double>(voxels));
    return {x[0], x[1], x[2]};
  }
};

struct LabelSums {
  Sum rest, now;
  std::int64_t left_out = 0, folded = 0, points = 0;
  double ratio = 0;
};

std::int32_t whole(float value) {
  constexpr float largest = 1 << 24;
  if (!(std::abs(value) <= largest) || value != std::floor(value))
    throw std::invalid_argument(
        fmt::format("expected labels, whole numbers of at most 2^24, found {}", value));
  return static_cast<std::int32_t>(value);
}

/// Neighbouring voxels mostly have the same label.
class Sums {
public:
  LabelSums& of(float value) {
    if (!last_ || value != last_value_) {
      last_value_ = value;
      last_ = &all_[whole(value)];
    }
    return *last_;
  }
  const std::map<std::int32_t, LabelSums>& all() const { return all_; }

private:
  std::map<std::int32_t, LabelSums> all_;
  LabelSums* last_ = nullptr;
  float last_value_ = 0;
};

/// Folded cells count for the label at their middle.
void count_folded(const ImageInfo& grid, const DeformedBody& body, const Image& labels, Sums& sums) {
  const CellsAtRest rest(grid, *body.specimen);
  for_each_deformed_cell(grid, body, [&](std::int64_t, const Index3& at, const Corners& corners) {
    if (!CellMap(corners).is_folded(rest.orientation()))
      return;
    if (const std::int64_t voxel = voxel_at(grid.size, rest.middle(at)); voxel >= 0)
      ++sums.of(labels.values[static_cast<std::size_t>(voxel)]).folded;
  });
}

} // namespace

Image warped(const Pull& pull, const Image& image, float background) {
  check_grid(pull, image);
  const auto n = static_cast<std::size_t>(pull.grid.n_voxels());
  Image out{image.info, std::vector<float>(image.values.size(), background)};
  for_each_voxel(pull.grid, [&](std::size_t voxel, const Vector3d& at) {
    if (pull.source[voxel] < 0)
      return;
    const Vector3d rest = at + Vector3d(pull.shift[voxel], pull.shift[n + voxel], pull.shift[2 * n + voxel]);
    for (std::size_t c = 0; c < static_cast<std::size_t>(image.info.components); ++c)
      out.values[c * n + voxel] = linear(image.values.data() + c * n, pull.grid.size, rest);
  });
  return out;
}

Image warped_labels(const Pull& pull, const Image& labels, float background) {
  check_grid(pull, labels);
  const auto n = static_cast<std::size_t>(pull.grid.n_voxels());
  Image out{labels.info, std::vector<float>(labels.values.size(), background)};
  for (std::size_t first = 0; first < labels.values.size(); first += n)
    for (std::size_t voxel = 0; voxel < n; ++voxel)
      if (pull.source[voxel] >= 0)
        out.values[first + voxel] = labels.values[first + static_cast<std::size_t>(pull.source[voxel])];
  return out;
}

std::vector<WarpedLabel> warped_label_table(const Pull& pull, std::span<const DeformedBody> bodies,
                                            const Image& labels, const Image& after, const Image& ratio) {
  for (const Image* image : {&labels, &after, &ratio})
    check_grid(pull, *image);
  Sums sums;
  std::vector<RestCells> rest;
  for (const DeformedBody& body : bodies)
    rest.emplace_back(pull.grid, *body.specimen);
  for_each_voxel(pull.grid, [&](std::size_t voxel, const Vector3d& at) {
    const bool is_matter =
        std::ranges::any_of(rest, [&](const RestCells& cells) { return cells.cell_at(at) >= 0; });
    if (const float label = labels.values[voxel]; label != 0) {
      LabelSums& sum = sums.of(label);
      if (is_matter) {
        sum.rest.add(at);
        sum.ratio += double{ratio.values[voxel]};
      } else {
        ++sum.left_out;
      }
    }
    if (pull.source[voxel] >= 0 && after.values[voxel] != 0)
      sums.of(after.values[voxel]).now.add(at);
  });
  for (const DeformedBody& body : bodies)
    count_folded(pull.grid, body, labels, sums);
  for (const auto& [label, points] : label_parts(pull.grid, bodies, labels))
    sums.of(label).points = points;
  const Affine3 to_world = voxels_to_world(pull.grid);
  const double voxel_volume = std::abs(to_world.linear.determinant());
  std::vector<WarpedLabel> table;
  for (const auto& [label, sum] : sums.all()) {
    if (label == 0)
      continue;
    WarpedLabel row;
    row.label = label;
    row.voxels = sum.rest.voxels;
    row.left_out = sum.left_out;
    row.warped = sum.now.voxels;
    row.folded = sum.folded;
    row.volume_at_rest = voxel_volume * static_cast<double>(sum.rest.voxels);
    row.volume = voxel_volume * static_cast<double>(sum.now.voxels);
    row.sub_voxel_volume = voxel_volume * static_cast<double>(sum.points) / points_per_voxel;
    row.integral_of_det_f = voxel_volume * sum.ratio;
    row.centroid_at_rest = sum.rest.centroid(to_world);
    row.centroid = sum.now.centroid(to_world);
    table.push_back(row);
  }
  return table;
}

} // namespace maille
