#include "voxels/label_cells.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

namespace maille::reader {

namespace {

constexpr std::size_t most_listed = 40; ///< grey values

} // namespace

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
  // Voxels are float32: 0.3 in the file is the nearest float, which is slightly larger.
  return LabelRange{static_cast<float>(*low), static_cast<float>(*high), 0};
}

std::vector<float> single_labels(const std::vector<LabelRange>& ranges) {
  std::vector<float> labels;
  for (const LabelRange& range : ranges)
    if (range.low == range.high && range.low == std::floor(range.low))
      labels.push_back(range.low);
  return labels.size() == ranges.size() ? labels : std::vector<float>{};
}

std::uint8_t material_of(float value, const std::vector<LabelRange>& ranges) {
  for (const LabelRange& range : ranges)
    if (value >= range.low && value <= range.high)
      return range.material;
  return no_material;
}

void check_labels_exist(const std::vector<LabelRange>& ranges, const Specimen& body,
                        const std::function<float(std::int64_t)>& label_of, int line, const std::string& path,
                        FaultList& faults) {
  if (ranges.empty())
    return;
  LabelCensus census(ranges);
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell))
      census.add(label_of(cell));
  std::vector<std::string> absent;
  for (std::size_t i = 0; i < ranges.size(); ++i)
    if (census.voxels(i) == 0)
      absent.push_back(ranges[i].low == ranges[i].high
                           ? fmt::format("{:g}", ranges[i].low)
                           : fmt::format("{:g}..{:g}", ranges[i].low, ranges[i].high));
  if (!absent.empty())
    faults.add(line, path, "labels that some matter has: " + census.in_words(),
               fmt::format("{}, which none has", fmt::join(absent, ", ")));
}

void LabelCensus::add(float value, std::size_t n) {
  for (std::size_t i = 0; i < ranges_.size(); ++i)
    if (value >= ranges_[i].low && value <= ranges_[i].high)
      voxels_[i] += static_cast<std::int64_t>(n);
  if (value == last_)
    return;
  last_ = value;
  if (value != 0 && std::isfinite(value) && values_.size() <= most_listed)
    values_.insert(value);
  low_ = std::fmin(low_, value);
  high_ = std::fmax(high_, value);
}

std::string LabelCensus::in_words() const {
  if (values_.empty())
    return "nothing but 0";
  if (values_.size() <= most_listed)
    return fmt::format("{}", fmt::join(values_, ", "));
  return fmt::format("more than {} grey values from {} to {}", most_listed, low_, high_);
}

LabelCells::LabelCells(const LayeredImage& image, const std::vector<LabelRange>& ranges, const Index3& first,
                       const Index3& coarsen, const Specimen& body)
    : image_(image), ranges_(ranges), first_(first), coarsen_(coarsen), body_(body) {
  std::set<float> found;
  std::vector<float> values;
  labels_.assign(body.grid.n_cells(), 0);
  float last = std::numeric_limits<float>::quiet_NaN();
  for_each_block(body.tissue.empty() ? 0 : furthest_voxel, [&](std::int64_t cell, const LayerWindow& voxels) {
    const float label = labels_[cell] = label_of(cell, voxels, values);
    if (label != last)
      found.insert(label);
    last = label;
  });
  found_.assign(found.begin(), found.end());
  is_picture_ = found_.size() > 255;
}

/// @param values scratch memory
float LabelCells::label_of(std::int64_t cell, const LayerWindow& voxels, std::vector<float>& values) const {
  const VoxelBlock own = block_of(cell, 0);
  bool are_equal = true; // and in the image: a smooth surface may extend beyond its border
  for (std::size_t a = 0; a < 3; ++a)
    are_equal &= own.low[a] < own.high[a];
  const float first = are_equal ? voxels[own.first_voxel(info().size)] : 0;
  own.for_each_row(info().size, [&](std::size_t voxel, std::size_t end) {
    for (; voxel < end; ++voxel)
      are_equal &= voxels[voxel] == first;
  });
  if (are_equal && material_of(first, ranges_) == body_.material(cell))
    return first;
  values.clear();
  float last = std::numeric_limits<float>::quiet_NaN();
  bool is_of_cell = false;
  for (int margin = 0; values.empty() && margin <= furthest_voxel; ++margin)
    block_of(cell, margin).for_each(info().size, [&](std::size_t voxel) {
      const float value = voxels[voxel];
      if (!(value == last))
        is_of_cell = material_of(value, ranges_) == body_.material(cell);
      last = value;
      if (is_of_cell)
        values.push_back(value);
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
