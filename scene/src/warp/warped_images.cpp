// Deformed images and labels, and statistics of each label.

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
  const std::size_t n = pull.grid.n_voxels();
  if (image.info.size != pull.grid.size || image.info.components < 1 ||
      image.values.size() != n * static_cast<std::size_t>(image.info.components))
    throw std::invalid_argument("expected an image on the grid of the pull");
}

/// A row of places in an image, and values interpolated linearly between voxel centres; the outermost half
/// voxel has the value of the voxel.
class RowOfPlaces {
public:
  explicit RowOfPlaces(const Index3& size)
      : row_(static_cast<std::size_t>(size[0])), layer_(row_ * static_cast<std::size_t>(size[1])) {
    for (std::size_t a = 0; a < 3; ++a) {
      last_[a] = size[a] - 1;
      low_[a].resize(row_);
      part_[a].resize(row_);
    }
  }
  /// Sets the coordinates of a row of places along `axis`.
  void put(std::size_t axis, const std::vector<double>& along) {
    int* const low = low_[axis].data();
    double* const part = part_[axis].data();
    const double last = last_[axis];
    for (std::size_t i = 0; i < row_; ++i) {
      const double x = std::min(std::max(along[i], 0.0), last);
      low[i] = static_cast<int>(x);
      part[i] = x - low[i];
    }
  }
  float linear(const float* values, std::size_t i) const {
    const double x = part_[0][i], y = part_[1][i], z = part_[2][i];
    const float* const from = values + static_cast<std::size_t>(low_[0][i]) +
                              static_cast<std::size_t>(low_[1][i]) * row_ +
                              static_cast<std::size_t>(low_[2][i]) * layer_;
    // Equal neighbours, including infinities, keep their value; the last voxel has no right neighbour.
    const auto along_x = [&](const float* two) {
      return x > 0 ? mean(double{two[0]}, double{two[1]}, x) : double{two[0]};
    };
    const auto along_y = [&](const float* four) {
      return y > 0 ? mean(along_x(four), along_x(four + row_), y) : along_x(four);
    };
    if (x > 0 && y > 0 && z > 0)
      return static_cast<float>(
          mean(mean(mean(double{from[0]}, double{from[1]}, x),
                    mean(double{from[row_]}, double{from[row_ + 1]}, x), y),
               mean(mean(double{from[layer_]}, double{from[layer_ + 1]}, x),
                    mean(double{from[layer_ + row_]}, double{from[layer_ + row_ + 1]}, x), y),
               z));
    return static_cast<float>(z > 0 ? mean(along_y(from), along_y(from + layer_), z) : along_y(from));
  }

private:
  static double mean(double a, double b, double of) { return (1 - of) * a + of * b; }

  std::size_t row_, layer_; ///< voxels of a row, of a layer
  std::array<double, 3> last_{};
  std::array<std::vector<int>, 3> low_;
  std::array<std::vector<double>, 3> part_;
};

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

/// Sums per label; caches the last label, which neighbours usually share.
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

/// Counts folded cells for the label at their centre.
void count_folded(const ImageInfo& grid, const DeformedBody& body, const Image& labels, Sums& sums) {
  const CellsAtRest rest(grid, *body.specimen);
  for_each_deformed_cell(grid, body, [&](std::int64_t, const Index3& at, const Corners& corners) {
    if (!CellMap(corners).is_folded(rest.orientation()))
      return;
    if (const std::int64_t voxel = voxel_at(grid.size, rest.middle(at)); voxel >= 0)
      ++sums.of(labels.values[voxel]).folded;
  });
}

} // namespace

Image warped(const Pull& pull, const Image& image, float background) {
  check_grid(pull, image);
  const Index3& size = pull.grid.size;
  const auto n = static_cast<std::size_t>(pull.grid.n_voxels()), row = static_cast<std::size_t>(size[0]);
  Image out{image.info, std::vector<float>(image.values.size(), background)};
  RowOfPlaces places(size);
  std::vector<double> along(row);
  std::size_t first = 0;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j, first += row) {
      for (std::size_t a = 0; a < 3; ++a) {
        const float* const shift = pull.shift.data() + a * n + first;
        const double step = a == 0 ? 1 : 0, begin = a == 0 ? 0 : a == 1 ? j : k;
        for (std::size_t i = 0; i < row; ++i)
          along[i] = begin + step * static_cast<double>(static_cast<int>(i)) + double{shift[i]};
        places.put(a, along);
      }
      for (std::size_t from = first; from < image.values.size(); from += n)
        for (std::size_t i = 0; i < row; ++i)
          if (pull.source[first + i] >= 0)
            out.values[from + i] = places.linear(image.values.data() + (from - first), i);
    }
  return out;
}

Image warped_labels(const Pull& pull, const Image& labels, float background) {
  check_grid(pull, labels);
  const std::size_t n = pull.grid.n_voxels();
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
