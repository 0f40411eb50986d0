#include "feasible/box/separable_scans.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>

namespace maille::deform {

namespace {

constexpr Side sides[2] = {Side::least, Side::greatest};

int n_blocks(int nodes) {
  return (nodes + nodes_per_block - 1) / nodes_per_block;
}

/// Rows of a slab bound are spaced by one extra cache line, so that equal x of all rows do not share a few
/// cache sets.
std::int64_t slab_row(int nodes) {
  return std::int64_t{nodes_per_block} * (n_blocks(nodes) + 1);
}

/// Steps along z, which shift whole slabs, capped by the largest displacement difference: wider links never
/// bind, and shifts by their slack would cost digits.
LinkIntervals<double> no_farther(LinkIntervals<double> steps, double farthest) {
  steps.low[2] = std::max(steps.low[2], -farthest);
  steps.high[2] = std::min(steps.high[2], farthest);
  return steps;
}

} // namespace

template<class T>
void RowPaths<T>::fill(const Slopes& slopes, int nodes) {
  const int end = nodes + nodes_per_block; // the last strip's padding is read too
  if (offsets_.size() == 0)
    offsets_ = AlignedArray<T>(static_cast<std::size_t>(nodes - 1 + end));
  for (int offset = 1 - nodes; offset < end; ++offset)
    offsets_[offset + nodes - 1] = static_cast<T>(slopes.along(0, offset) + 0.0);
}

template<class T>
SeparableScans<T>::SeparableScans(const Grid& grid, const std::array<LinkIntervals<double>, 3>& bounds,
                                  int threads)
    : grid_(grid), bounds_(bounds), threads_(threads) {}

template<class T>
void SeparableScans<T>::prepare() {
  if (!workspaces_.empty())
    return;
  workspaces_ = std::vector<Workspace>(static_cast<std::size_t>(threads_));
  const Index3& n = grid_.nodes();
  for (Workspace& workspace : workspaces_) {
    for (auto& slab : workspace.slab)
      slab = AlignedArray<T>(static_cast<std::size_t>(slab_row(n[0]) * n[1]));
    workspace.row = AlignedArray<T>(static_cast<std::size_t>(n_blocks(n[0]) * nodes_per_block));
  }
  for (int b = 0; b < grid_.dimension(); ++b)
    for (std::size_t side = 0; side < 2; ++side)
      components_[b].row_paths[side].fill(Slopes(bounds_[b], sides[side]), n[0]);
}

template<class T>
void SeparableScans<T>::add(int component, const Field<T>& field, std::span<const HandleValue> handles,
                            Rounding& rounding) {
  prepare();
  Component& c = components_[component];
  c.field = field;
  c.is_added = true;
  const auto rises = [&](const HandleValue& handle) {
    return static_cast<T>(handle.value) > field.at(handle.at);
  };
  const std::ptrdiff_t n_rising = std::ranges::count_if(handles, rises);
  for (auto& seeds : c.seeds)
    seeds.clear();
  c.seeds[0].reserve(n_rising);
  c.seeds[1].reserve(handles.size() - static_cast<std::size_t>(n_rising));
  for (const HandleValue& handle : handles) {
    const T target = static_cast<T>(handle.value) + T{0}; // no negative zero
    rounding.largest = std::max(rounding.largest, std::abs(double{target}));
    if (target != field.at(handle.at))
      c.seeds[rises(handle) ? 0 : 1].push_back({handle.at[0], handle.at[1], handle.at[2], double{target}});
  }
  c.margin = safe_margin<T>(grid_.nodes(), rounding.largest);
  c.farthest = 4 * rounding.largest;
}

template<class T>
Sweep<T> SeparableScans<T>::sweep(int component, int strip, int n_strips, Workspace& workspace) const {
  const Component& c = components_[component];
  const Index3& n = grid_.nodes();
  Sweep<T> sweep;
  sweep.field = c.field;
  sweep.x_begin = n_blocks(n[0]) * strip / n_strips * nodes_per_block;
  sweep.x_end = std::min(n_blocks(n[0]) * (strip + 1) / n_strips * nodes_per_block,
                         static_cast<int>(c.field.row_stride));
  sweep.slab_row = slab_row(n[0]);
  sweep.margin = c.margin;
  std::ranges::copy(n, sweep.nodes);
  for (std::size_t side = 0; side < 2; ++side) {
    if (c.seeds[side].empty())
      continue;
    const Slopes slopes(no_farther(bounds_[component], c.farthest), sides[side]);
    Bound<T>& bound = sweep.bounds[sweep.n_bounds++];
    bound.is_least = sides[side] == Side::least;
    bound.seeds = c.seeds[side].data();
    bound.n_seeds = static_cast<int>(c.seeds[side].size());
    std::ranges::copy(slopes.ahead, bound.ahead);
    std::ranges::copy(slopes.behind, bound.behind);
    bound.row = c.row_paths[side].data();
    bound.slab = workspace.slab[side].data();
    bound.one_row = workspace.row.data();
  }
  return sweep;
}

template<class T>
std::int64_t SeparableScans<T>::run(ThreadTeam& team) {
  std::array<int, 3> active{};
  int n_active = 0;
  for (int b = 0; b < grid_.dimension(); ++b) {
    Component& c = components_[b];
    if (c.is_added && !(c.seeds[0].empty() && c.seeds[1].empty()))
      active[n_active++] = b;
    c.is_added = false;
  }
  if (n_active == 0)
    return 0;
  const int threads = std::min(team.threads(), threads_);
  const bool alone = threads == 1 || n_active * grid_.n_nodes() < nodes_worth_a_thread;
  const int wanted = alone ? 1 : threads / std::gcd(threads, n_active);
  const int n_strips = std::min(wanted, n_blocks(grid_.nodes()[0]));
  std::atomic<std::int64_t> visited{0};
  const auto do_strip = [&](int item, int thread) {
    const int component = active[item / n_strips];
    visited += clamp_strip(sweep(component, item % n_strips, n_strips, workspaces_[thread]));
  };
  if (alone)
    for (int item = 0; item < n_active; ++item)
      do_strip(item, 0);
  else
    team.run(n_active * n_strips, do_strip);
  for (int i = 0; i < n_active; ++i)
    place_handles(components_[active[i]]);
  return visited;
}

/// Restores handles that rounding displaced where other handles just allow them.
template<class T>
void SeparableScans<T>::place_handles(Component& component) const {
  for (const auto& seeds : component.seeds)
    for (const GridSeed& seed : seeds)
      component.field.at({seed.x, seed.y, seed.z}) = static_cast<T>(seed.value);
}

template class RowPaths<float>;
template class RowPaths<double>;
template class SeparableScans<float>;
template class SeparableScans<double>;

} // namespace maille::deform
