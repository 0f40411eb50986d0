#include "feasible/box/separable_scans.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace maille::deform {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

GridSeed seed_at(const Grid& grid, std::int64_t node, double value) {
  const Index3 at = grid.node_at(node);
  return {at[0], at[1], at[2], value + 0.0};
}

bool comes_first(const GridSeed& a, const GridSeed& b) {
  return std::array{a.z, a.y, a.x} < std::array{b.z, b.y, b.x};
}

} // namespace

void BoxBounds::bounds_at(Side side, int component, std::span<const PathEnd> ends,
                          std::span<const std::int64_t> nodes, std::span<double> values) {
  std::ranges::fill(values, side == Side::least ? -infinity : infinity);
  if (ends.empty() || nodes.empty())
    return;
  seeds_.clear();
  seeds_.reserve(ends.size());
  for (const PathEnd& end : ends)
    seeds_.push_back(seed_at(grid_, end.node, end.potential));
  queries_.clear();
  queries_.reserve(nodes.size());
  for (const std::int64_t node : nodes)
    queries_.push_back(seed_at(grid_, node, 0));
  std::ranges::sort(seeds_, comes_first);
  const Slopes slopes(bounds_[component], side);
  Bound<double> bound;
  bound.is_least = side == Side::least;
  std::ranges::copy(slopes.ahead, bound.ahead);
  std::ranges::copy(slopes.behind, bound.behind);
  // A pair costs about a quarter of what a node of a scanned slab does.
  if (static_cast<std::int64_t>(seeds_.size() * queries_.size()) <= 4 * work_of_scans()) {
    bound.sample = values.data();
    by_pairs(bound);
  } else {
    by_scans(bound, slopes, values);
  }
}

/// Nodes of the slabs that hold seeds, there and back.
std::int64_t BoxBounds::work_of_scans() const {
  std::int64_t slabs = 1;
  for (std::size_t i = 1; i < seeds_.size(); ++i)
    slabs += seeds_[i].z != seeds_[i - 1].z ? 1 : 0;
  return 2 * slabs * grid_.nodes()[0] * grid_.nodes()[1];
}

void BoxBounds::by_pairs(Bound<double>& bound) {
  const std::size_t n = (seeds_.size() + nodes_per_block - 1) / nodes_per_block * nodes_per_block;
  for (auto& array : arrays_)
    array.assign(n, 0.0);
  std::ranges::fill(arrays_[3], bound.is_least ? -infinity : infinity);
  for (std::size_t i = 0; i < seeds_.size(); ++i) {
    arrays_[0][i] = seeds_[i].x;
    arrays_[1][i] = seeds_[i].y;
    arrays_[2][i] = seeds_[i].z;
    arrays_[3][i] = seeds_[i].value;
  }
  const GridSeedArrays seeds{arrays_[0].data(), arrays_[1].data(), arrays_[2].data(), arrays_[3].data(),
                             static_cast<int>(n)};
  sample_by_pairs(bound, seeds, {queries_.data(), static_cast<int>(queries_.size())});
}

void BoxBounds::by_scans(Bound<double>& bound, const Slopes& slopes, std::span<double> values) {
  order_.resize(queries_.size());
  std::iota(order_.begin(), order_.end(), 0);
  std::ranges::sort(order_,
                    [&](std::int32_t a, std::int32_t b) { return comes_first(queries_[a], queries_[b]); });
  std::ranges::sort(queries_, comes_first);
  sorted_values_.assign(values.begin(), values.end());

  const Index3& n = grid_.nodes();
  const int width = (n[0] + nodes_per_block - 1) / nodes_per_block * nodes_per_block;
  Sweep<double> sweep;
  sweep.x_end = width;
  sweep.slab_row = width + nodes_per_block;
  std::ranges::copy(n, sweep.nodes);
  if (slab_.size() == 0) {
    slab_ = AlignedArray<double>(static_cast<std::size_t>(sweep.slab_row * n[1]));
    row_ = AlignedArray<double>(static_cast<std::size_t>(width));
  }
  row_paths_.fill(slopes, n[0]);
  bound.seeds = seeds_.data();
  bound.n_seeds = static_cast<int>(seeds_.size());
  bound.row = row_paths_.data();
  bound.slab = slab_.data();
  bound.one_row = row_.data();
  bound.sample = sorted_values_.data();
  sweep.bounds[0] = bound;
  sweep.n_bounds = 1;
  sample_bound(sweep, {queries_.data(), static_cast<int>(queries_.size())});
  for (std::size_t i = 0; i < order_.size(); ++i)
    values[order_[i]] = sorted_values_[i];
}

} // namespace maille::deform
