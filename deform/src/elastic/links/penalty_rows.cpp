#include "elastic/links/penalty_rows.hpp"

#include <algorithm>
#include <tuple>

namespace maille::deform {

List<PenaltyLink> merged(List<PenaltyLink> links) {
  const auto place = [](const PenaltyLink& link) { return std::tuple(link.component, link.axis, link.node); };
  std::ranges::stable_sort(links, {}, place);
  std::size_t n = 0;
  for (std::size_t i = 0; i < links.size(); ++i)
    if (n > 0 && place(links[n - 1]) == place(links[i]))
      links[n - 1].stiffness += links[i].stiffness;
    else
      links[n++] = links[i];
  links.resize(n);
  return links;
}

namespace {

/// Places per bucket of the counting sort of ends; few ends per bucket are left to sort.
constexpr std::int64_t places_per_bucket = 32;

/// @param place_of a number below `places` that says their order but for that of ends at one place, which is
///        by the other's
template<class PlaceOf>
List<PenaltyRows::End> in_order(const List<PenaltyRows::End>& ends, std::int64_t places,
                                const PlaceOf& place_of) {
  std::vector<std::uint32_t> bucket(ends.size());
  std::vector<std::size_t> next(static_cast<std::size_t>(places / places_per_bucket) + 2, 0);
  for (std::size_t i = 0; i < ends.size(); ++i) {
    bucket[i] = static_cast<std::uint32_t>(place_of(ends[i].at) / places_per_bucket);
    ++next[bucket[i] + 1];
  }
  for (std::size_t i = 1; i < next.size(); ++i)
    next[i] += next[i - 1];
  List<PenaltyRows::End> sorted(ends.size());
  for (std::size_t i = 0; i < ends.size(); ++i)
    sorted[next[bucket[i]]++] = ends[i];
  std::size_t first = 0;
  for (const std::size_t end : next) { // each is the end of its bucket now
    std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(first),
              sorted.begin() + static_cast<std::ptrdiff_t>(end),
              [](const auto& a, const auto& b) { return a.at != b.at ? a.at < b.at : a.other < b.other; });
    first = end;
  }
  return sorted;
}

} // namespace

PenaltyRows::PenaltyRows(const List<End>& ends, std::int64_t slab_stride, std::int64_t component_stride,
                         int planes) {
  if (ends.empty())
    return;
  // Planes follow one another, and in a plane its components, each rounded up to whole buckets.
  const std::int64_t slab = (slab_stride + places_per_bucket - 1) / places_per_bucket * places_per_bucket,
                     components = 1 + std::ranges::max(ends, {}, &End::at).at / component_stride;
  const auto plane_of = [&](std::int64_t at) { return at % component_stride / slab_stride; };
  ends_ = in_order(ends, planes * components * slab, [&](std::int64_t at) {
    const std::int64_t component = at / component_stride, in_component = at - component * component_stride,
                       z = in_component / slab_stride;
    return (z * components + component) * slab + in_component - z * slab_stride;
  });
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

} // namespace maille::deform
