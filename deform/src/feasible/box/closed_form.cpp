#include "feasible/box/closed_form.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

constexpr int chunks_per_thread = 4;

std::size_t row_size(const Grid& grid) {
  return static_cast<std::size_t>((grid.nodes()[0] + nodes_per_block - 1) / nodes_per_block *
                                  nodes_per_block);
}

template<class T>
std::int64_t volume(const Cone<T>& cone) {
  return std::int64_t{1} * (cone.end[0] - cone.begin[0]) * (cone.end[1] - cone.begin[1]) *
         (cone.end[2] - cone.begin[2]);
}

} // namespace

template<class T>
double safe_margin(const Index3& nodes, double largest) {
  const double links = 8.0 + nodes[0] + nodes[1] + nodes[2];
  return 4 * links * static_cast<double>(std::numeric_limits<T>::epsilon()) * largest;
}

template<class T>
ClosedForm<T>::ClosedForm(const Grid& grid) {
  for (int b = 0; b < grid.dimension(); ++b)
    row_[b] = AlignedArray<T>(row_size(grid));
}

template<class T>
void ClosedForm<T>::add(int component, const Field<T>& field, const LinkIntervals<double>& bounds,
                        const Index3& handle, double value, Rounding& rounding, bool stops) {
  const double now = static_cast<double>(field.at(handle)),
               target = static_cast<double>(static_cast<T>(value));
  if (target == now) // a feasible state that has the value already lies between the bounds
    return;
  const bool raises = target > now;
  const Slopes slopes(bounds, raises ? Side::least : Side::greatest);
  rounding.largest = std::max(rounding.largest, std::abs(target));
  Cone<T>& cone = cones_[n_cones_++];
  cone = {};
  cone.field = field;
  cone.value = target + 0.0; // no negative zero
  cone.margin = safe_margin<T>(field.nodes, rounding.largest);
  cone.raises = raises;
  cone.stops = stops;
  for (std::size_t a = 0; a < 3; ++a) {
    cone.handle[a] = handle[a];
    cone.ahead[a] = slopes.ahead[a];
    cone.behind[a] = slopes.behind[a];
    cone.end[a] = field.nodes[a];
  }
  AlignedArray<T>& row = row_[component];
  cone.row = row.data();
  for (int x = 0; x < static_cast<int>(row.size()); ++x)
    row[x] = static_cast<T>(slopes.along(0, x - handle[0]) + 0.0);
  if (stops)
    enclose(cone);
}

template<class T>
std::int64_t ClosedForm<T>::run(ThreadTeam& team) {
  std::int64_t nodes = 0;
  std::array<int, 4> first_slab{};
  for (std::size_t i = 0; i < static_cast<std::size_t>(n_cones_); ++i) {
    nodes += volume(cones_[i]);
    first_slab[i + 1] = first_slab[i] + cones_[i].end[2] - cones_[i].begin[2];
  }
  const int n_slabs = first_slab[n_cones_];
  const bool alone = nodes < nodes_worth_a_thread || team.threads() == 1;
  const int n_chunks = alone ? 1 : std::min(n_slabs, chunks_per_thread * team.threads());
  std::atomic<std::int64_t> visited{0};
  const auto do_chunk = [&](int chunk, int) {
    const auto begin = static_cast<int>(std::int64_t{n_slabs} * chunk / n_chunks);
    const auto end = static_cast<int>(std::int64_t{n_slabs} * (chunk + 1) / n_chunks);
    std::int64_t mine = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n_cones_); ++i) {
      const int from = std::max(begin, first_slab[i]), to = std::min(end, first_slab[i + 1]);
      if (from < to)
        mine += apply(cones_[i], cones_[i].begin[2] + from - first_slab[i],
                      cones_[i].begin[2] + to - first_slab[i]);
    }
    visited += mine;
  };
  if (n_slabs > 0)
    team.run(n_chunks, do_chunk);
  n_cones_ = 0;
  return visited;
}

template double safe_margin<float>(const Index3&, double);
template double safe_margin<double>(const Index3&, double);
template class ClosedForm<float>;
template class ClosedForm<double>;

} // namespace maille::deform
