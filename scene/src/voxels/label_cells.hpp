#pragma once
/// Meaning of a label image's grey values, the voxels of each cell, and the label of each cell, which
/// distinguishes muscles.

#include "maille/images/layers.hpp"
#include "maille/materials/toml_reader.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>

namespace maille::reader {

/// Grey values from `low` to `high`, both inclusive, and their material.
struct LabelRange {
  float low = 0, high = 0; ///< type of voxels
  std::uint8_t material = 0;
};

/// Largest label: above it float32, the type of voxels, skips whole numbers.
inline constexpr std::int64_t largest_whole_label = 1 << 24;
inline bool is_label(std::int64_t label) {
  return label >= -largest_whole_label && label <= largest_whole_label;
}
/// `a label from -16777216 to 16777216`
inline std::string wanted_label() {
  return "a label from -" + std::to_string(largest_whole_label) + " to " +
         std::to_string(largest_whole_label);
}

/// "17" or "1150..4000"; material 0.
std::optional<LabelRange> parse_label(std::string_view text);

std::uint8_t material_of(float value, const std::vector<LabelRange>& ranges);

/// Adds a fault for ranges without cells of matter: a missing label is a mistake.
/// @param label_of  a cell's label
void check_labels_exist(const std::vector<LabelRange>& ranges, const Specimen& body,
                        const std::function<float(std::int64_t)>& label_of, int line, const std::string& path,
                        FaultList& faults);

/// Whole numbers that are single labels, not parts of a range.
std::vector<float> single_labels(const std::vector<LabelRange>& ranges);

/// Calls visit(value, n) for n consecutive equal values: labels form few such runs.
template<class Visit>
void for_each_run(std::span<const float> values, Visit&& visit) {
  for (std::size_t first = 0; first < values.size();) {
    const float value = values[first];
    std::size_t end = first + 1;
    for (bool are_equal = true; are_equal && end + 8 <= values.size();) {
      for (std::size_t i = end; i < end + 8; ++i)
        are_equal &= values[i] == value;
      end += are_equal ? 8 : 0;
    }
    while (end < values.size() && values[end] == value)
      ++end;
    visit(value, end - first);
    first = end;
  }
}

/// Counts the voxels of labels, and collects the grey values of an image.
class LabelCensus {
public:
  /// @param ranges must outlive this
  explicit LabelCensus(const std::vector<LabelRange>& ranges) : ranges_(ranges), voxels_(ranges.size(), 0) {}
  void add(float value, std::size_t n = 1);
  /// Number of voxels with a value in a range.
  std::int64_t voxels(std::size_t range) const { return voxels_[range]; }
  /// The non-zero grey values as short text: a list if they are few, else their range.
  std::string in_words() const;

private:
  const std::vector<LabelRange>& ranges_;
  std::vector<std::int64_t> voxels_;
  std::set<float> values_; ///< except 0; capped once there are too many to list
  float low_ = std::numeric_limits<float>::infinity(), high_ = -low_;
  float last_ = std::numeric_limits<float>::quiet_NaN();
};

/// First and end voxel of a block along each axis.
struct VoxelBlock {
  Index3 low{}, high{};

  /// The voxels of the cell at `cell`, plus a margin.
  VoxelBlock(const Index3& cell, const Index3& coarsen, int margin, const Index3& size) {
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max(cell[a] * coarsen[a] - margin, 0);
      high[a] = std::min((cell[a] + 1) * coarsen[a] + margin, size[a]);
    }
  }
  std::size_t first_voxel(const Index3& size) const { return voxel(low[0], low[1], low[2], size); }
  /// Calls visit(first voxel number, end voxel number) for each row along x.
  template<class Visit>
  void for_each_row(const Index3& size, Visit&& visit) const {
    for (int k = low[2]; k < high[2]; ++k)
      for (int j = low[1]; j < high[1]; ++j)
        visit(voxel(low[0], j, k, size), voxel(high[0], j, k, size));
  }
  /// Calls visit(voxel number).
  template<class Visit>
  void for_each(const Index3& size, Visit&& visit) const {
    for_each_row(size, [&](std::size_t first, std::size_t end) {
      for (std::size_t voxel = first; voxel < end; ++voxel)
        visit(voxel);
    });
  }

private:
  static std::size_t voxel(int i, int j, int k, const Index3& size) {
    return static_cast<std::size_t>(i + std::int64_t{size[0]} * (j + std::int64_t{size[1]} * k));
  }
};

/// Search radius for a voxel of the material of a cell [voxels]: partly filled cells may contain none.
inline constexpr int furthest_voxel = 8;

/// The cells of a body that was read from an image and cropped to its matter.
class LabelCells {
public:
  /// @param image    labels, not cropped
  /// @param first    position of cell 0 of the body in the cells of the whole image
  /// @param coarsen  voxels of a cell along each axis
  /// @param body     cropped; must outlive this, as must `image` and `ranges`
  LabelCells(const LayeredImage& image, const std::vector<LabelRange>& ranges, const Index3& first,
             const Index3& coarsen, const Specimen& body);

  const ImageInfo& info() const { return image_.info(); }
  /// The most frequent grey value of a cell's material in the cell, the smallest if several are equally
  /// frequent; if the material has no voxel in the cell, that of the nearest voxels. One per cell of the
  /// grid, 0 outside the body.
  const std::vector<float>& labels() const { return labels_; }
  /// The same as whole numbers; empty if a value is not whole, or there are more than 255.
  std::vector<std::int32_t> whole_labels() const;
  /// A number per cell that is equal within a muscle: that of its label. If matter has more than 255 grey
  /// values, the image is a picture and not labels; then materials define the regions.
  std::vector<std::int32_t> regions() const;
  /// Calls visit(cell, voxel numbers of its region) for the cells of matter, in order.
  template<class Visit>
  void for_each_cell(Visit&& visit) const {
    std::vector<std::size_t> own;
    for_each_block(0, [&](std::int64_t cell, const LayerWindow& voxels) {
      own.clear();
      block_of(cell, 0).for_each(info().size, [&](std::size_t voxel) {
        if (is_picture_ ? material_of(voxels[voxel], ranges_) == body_.material(cell)
                        : voxels[voxel] == labels_[cell])
          own.push_back(voxel);
      });
      visit(cell, own);
    });
  }

private:
  VoxelBlock block_of(std::int64_t cell, int margin) const {
    const Index3 at = body_.grid.cell_at(cell);
    return {{first_[0] + at[0], first_[1] + at[1], first_[2] + at[2]}, coarsen_, margin, info().size};
  }
  /// Calls visit(cell, voxels) for the cells of matter, with the voxels of its block and `margin` around.
  template<class Visit>
  void for_each_block(int margin, Visit&& visit) const {
    LayerWindow voxels = image_.open(coarsen_[2] + 2 * margin);
    const std::int64_t n_of_layer = std::int64_t{body_.grid.cells()[0]} * body_.grid.cells()[1];
    for (std::int64_t cell = 0; cell < body_.grid.n_cells(); ++cell) {
      if (cell % n_of_layer == 0) {
        const VoxelBlock block = block_of(cell, margin);
        voxels.move_to(block.low[2], block.high[2]);
      }
      if (body_.is_matter(cell))
        visit(cell, voxels);
    }
  }
  float label_of(std::int64_t cell, const LayerWindow& voxels, std::vector<float>& values) const;

  const LayeredImage& image_;
  const std::vector<LabelRange>& ranges_;
  Index3 first_, coarsen_;
  const Specimen& body_;
  std::vector<float> labels_;
  std::vector<float> found_; ///< the labels of matter, sorted
  bool is_picture_ = false;
};

} // namespace maille::reader
