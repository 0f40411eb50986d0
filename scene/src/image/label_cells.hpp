#pragma once
/// What a label image's grey values stand for, which voxels are in which cells, and the label of each cell:
/// what tells one muscle from another.

#include "maille/scene/image.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>

namespace maille::reader {

/// Grey values from `low` to `high`, both inclusive, and the material that they stand for.
struct LabelRange {
  float low = 0, high = 0; ///< as voxels are
  std::uint8_t material = 0;
};

/// Beyond, float32, of which voxels are, skips whole numbers.
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

/// The cells of a body that was read from an image and cut down to its matter.
class LabelCells {
public:
  /// @param image    of the labels, not cut down
  /// @param first    cell 0 of the body, counted in the cells of the whole image
  /// @param coarsen  voxels of a cell along each axis
  /// @param body     as cut down; must outlive this, and so must `image`
  LabelCells(const Image& image, const std::vector<LabelRange>& ranges, const Index3& first,
             const Index3& coarsen, const Specimen& body);

  const ImageInfo& info() const { return image_.info; }
  /// The grey value that most voxels of a cell's material have, of equals the smallest, where there is none
  /// in it of those nearest to it; for each cell of the grid, 0 without matter.
  const std::vector<float>& labels() const { return labels_; }
  /// The same as whole numbers; empty where one is none, or there are more than 255.
  std::vector<std::int32_t> whole_labels() const;
  /// A number for each cell, the same in every cell of one muscle: that of its label. More than 255 grey
  /// values in matter are those of a picture, not labels: then materials tell the regions apart.
  std::vector<std::int32_t> regions() const;
  /// Calls visit(voxel number) for the voxels of a cell that are of its region.
  template<class Visit>
  void for_each_voxel(std::int64_t cell, Visit&& visit) const {
    for_each_voxel_of_block(cell, 0, [&](std::size_t voxel) {
      const float value = image_.values[voxel];
      if (is_picture_ ? material_of(value, ranges_) == body_.material(cell)
                      : value == labels_[static_cast<std::size_t>(cell)])
        visit(voxel);
    });
  }

private:
  template<class Visit>
  void for_each_voxel_of_block(std::int64_t cell, int margin, Visit&& visit) const {
    const Index3 at = body_.grid.cell_at(cell);
    const Index3& size = image_.info.size;
    Index3 low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = (first_[a] + at[a]) * coarsen_[a];
      high[a] = std::min(low[a] + coarsen_[a] + margin, size[a]);
      low[a] = std::max(low[a] - margin, 0);
    }
    for (int k = low[2]; k < high[2]; ++k)
      for (int j = low[1]; j < high[1]; ++j)
        for (int i = low[0]; i < high[0]; ++i)
          visit(static_cast<std::size_t>(i + std::int64_t{size[0]} * (j + std::int64_t{size[1]} * k)));
  }
  float label_of(std::int64_t cell) const;

  const Image& image_;
  const std::vector<LabelRange>& ranges_;
  Index3 first_, coarsen_;
  const Specimen& body_;
  std::vector<float> labels_;
  std::vector<float> found_; ///< the labels of matter, sorted
  bool is_picture_ = false;
};

} // namespace maille::reader
