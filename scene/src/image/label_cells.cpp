#include "image/label_cells.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

namespace maille::reader {

std::optional<LabelRange> parse_label(std::string_view text) {
  const auto number = [](std::string_view part) -> std::optional<double> {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(value))
      return std::nullopt;
    return value;
  };
  const auto dots = text.find("..");
  const auto low = number(text.substr(0, dots));
  const auto high = dots == std::string_view::npos ? low : number(text.substr(dots + 2));
  if (!low || !high || *high < *low)
    return std::nullopt;
  // Voxels are float32: the one that was written as 0.3 is the nearest to it, which lies above.
  return LabelRange{static_cast<float>(*low), static_cast<float>(*high), 0};
}

std::uint8_t material_of(float value, const std::vector<LabelRange>& ranges) {
  for (const LabelRange& range : ranges)
    if (value >= range.low && value <= range.high)
      return range.material;
  return no_material;
}

LabelCells::LabelCells(const Image& image, const std::vector<LabelRange>& ranges, const Index3& first,
                       const Index3& coarsen, const Specimen& body)
    : image_(image), ranges_(ranges), first_(first), coarsen_(coarsen), body_(body) {
  std::set<float> found;
  labels_.assign(static_cast<std::size_t>(body.grid.n_cells()), 0);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell))
      found.insert(labels_[static_cast<std::size_t>(cell)] = label_of(cell));
  found_.assign(found.begin(), found.end());
  is_picture_ = found_.size() > 255;
}

float LabelCells::label_of(std::int64_t cell) const {
  std::vector<float> values;
  constexpr int furthest = 8; // voxels: a cell that is tissue in part may have none of its material
  for (int margin = 0; values.empty() && margin <= furthest; ++margin)
    for_each_voxel_of_block(cell, margin, [&](std::size_t voxel) {
      if (material_of(image_.values[voxel], ranges_) == body_.material(cell))
        values.push_back(image_.values[voxel]);
    });
  std::ranges::sort(values);
  float label = 0;
  std::ptrdiff_t most = 0;
  for (auto run = values.begin(); run != values.end();) {
    const auto end = std::upper_bound(run, values.end(), *run);
    if (end - run > most) {
      most = end - run;
      label = *run;
    }
    run = end;
  }
  return label;
}

std::vector<std::int32_t> LabelCells::whole_labels() const {
  constexpr auto most = static_cast<float>(largest_whole_label);
  if (is_picture_ || !std::ranges::all_of(found_, [](float label) {
        return std::abs(label) <= most && label == std::floor(label);
      }))
    return {};
  return {labels_.begin(), labels_.end()};
}

std::vector<std::int32_t> LabelCells::regions() const {
  std::vector<std::int32_t> regions(labels_.size(), 0);
  for (std::size_t cell = 0; cell < labels_.size(); ++cell)
    regions[cell] =
        is_picture_
            ? std::int32_t{body_.material(static_cast<std::int64_t>(cell))}
            : static_cast<std::int32_t>(std::ranges::lower_bound(found_, labels_[cell]) - found_.begin());
  return regions;
}

} // namespace maille::reader
