#include "relax/stiffened_rows.hpp"

#include <algorithm>
#include <utility>

namespace maille::deform {

namespace {

/// By plane, place and the other's place. Ends come almost in the order of their places, so those of a plane are near each other.
template<class PlaneOf>
void sort_by_planes(std::vector<StiffenedRows::End>& ends, const PlaneOf& plane_of) {
  std::vector<std::pair<std::int64_t, StiffenedRows::End>> keyed; // planes are costly to find
  keyed.reserve(ends.size());
  for (const StiffenedRows::End& end : ends)
    keyed.emplace_back(plane_of(end.at), end);
  std::ranges::sort(keyed, [](const auto& a, const auto& b) {
    return a.first != b.first           ? a.first < b.first
           : a.second.at != b.second.at ? a.second.at < b.second.at
                                        : a.second.other < b.second.other;
  });
  std::ranges::transform(keyed, ends.begin(), [](const auto& entry) { return entry.second; });
}

} // namespace

StiffenedRows::StiffenedRows(std::vector<End> ends, std::int64_t slab_stride, std::int64_t component_stride,
                             int planes)
    : ends_(std::move(ends)) {
  const auto plane_of = [&](std::int64_t at) { return at % component_stride / slab_stride; };
  sort_by_planes(ends_, plane_of);
  first_row_.assign(static_cast<std::size_t>(planes) + 1, 0);
  for (std::size_t i = 0; i < ends_.size(); ++i) {
    if (i == 0 || ends_[i].at != ends_[i - 1].at) {
      const auto first = static_cast<std::int32_t>(i);
      rows_.push_back({ends_[i].at, 0, 0, first, first});
      ++first_row_[static_cast<std::size_t>(plane_of(ends_[i].at)) + 1];
    }
    rows_.back().diagonal += ends_[i].stiffness;
    ++rows_.back().end;
  }
  for (std::size_t z = 0; z < static_cast<std::size_t>(planes); ++z)
    first_row_[z + 1] += first_row_[z];
}

std::int64_t StiffenedRows::bytes() const {
  return static_cast<std::int64_t>(ends_.capacity() * sizeof(End) + rows_.capacity() * sizeof(Row) +
                                   first_row_.capacity() * sizeof(std::int32_t));
}

} // namespace maille::deform
