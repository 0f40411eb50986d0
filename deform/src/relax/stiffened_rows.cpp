#include "relax/stiffened_rows.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

/// In the order of their planes, and in a plane by place and the other's place: planes are few and costly to find, so ends are counted
/// into them. @param first of the ends of every plane, and the end
std::vector<StiffenedRows::End> in_order(const std::vector<StiffenedRows::End>& ends,
                                         const std::vector<std::int32_t>& plane,
                                         const std::vector<std::size_t>& first) {
  std::vector<StiffenedRows::End> sorted(ends.size());
  std::vector<std::size_t> next(first);
  for (std::size_t i = 0; i < ends.size(); ++i)
    sorted[next[static_cast<std::size_t>(plane[i])]++] = ends[i];
  for (std::size_t z = 0; z + 1 < first.size(); ++z)
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(first[z]),
              sorted.begin() + static_cast<std::ptrdiff_t>(first[z + 1]), [](const auto& a, const auto& b) {
                return a.at != b.at ? a.at < b.at : a.other < b.other;
              });
  return sorted;
}

} // namespace

StiffenedRows::StiffenedRows(const std::vector<End>& ends, std::int64_t slab_stride,
                             std::int64_t component_stride, int planes) {
  std::vector<std::int32_t> plane(ends.size());
  std::vector<std::size_t> first(static_cast<std::size_t>(planes) + 1, 0);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    plane[i] = static_cast<std::int32_t>(ends[i].at % component_stride / slab_stride);
    ++first[static_cast<std::size_t>(plane[i]) + 1];
  }
  for (std::size_t z = 0; z + 1 < first.size(); ++z)
    first[z + 1] += first[z];
  ends_ = in_order(ends, plane, first);
  first_row_.push_back(0);
  for (std::size_t z = 0; z + 1 < first.size(); ++z) {
    for (std::size_t i = first[z]; i < first[z + 1]; ++i) {
      if (i == first[z] || ends_[i].at != ends_[i - 1].at)
        rows_.push_back({ends_[i].at, 0, 0, static_cast<std::int32_t>(i), static_cast<std::int32_t>(i)});
      rows_.back().diagonal += ends_[i].stiffness;
      ++rows_.back().end;
    }
    first_row_.push_back(static_cast<std::int32_t>(rows_.size()));
  }
}

std::int64_t StiffenedRows::bytes() const {
  return static_cast<std::int64_t>(ends_.capacity() * sizeof(End) + rows_.capacity() * sizeof(Row) +
                                   first_row_.capacity() * sizeof(std::int32_t));
}

} // namespace maille::deform
