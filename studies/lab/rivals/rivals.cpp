#include "rivals/rivals.hpp"

#include <algorithm>
#include <cmath>
#include <queue>

namespace maille::lab {

FlatLinks::FlatLinks(const Scene& scene, const LinkLimits& limits, int component, double quantum) {
  const Grid& grid = scene.specimen.grid;
  const auto n = static_cast<std::size_t>(grid.n_nodes());
  constexpr Step no_links{{none, none, none, none, none, none}};
  drop.assign(n, no_links);
  climb.assign(n, no_links);
  constexpr double longest = 1 << 30; // values span no more, so nothing longer binds
  const auto b = static_cast<std::size_t>(component);
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    stride[2 * a] = -grid.stride(axis);
    stride[2 * a + 1] = grid.stride(axis);
    for (std::size_t i = 0; i < n; ++i) {
      const Index3 at = grid.node_at(static_cast<std::int64_t>(i));
      if (at[a] + 1 >= grid.nodes()[a])
        continue;
      const auto link = limits.intervals(at, axis);
      if (!link)
        continue;
      const std::size_t j = i + static_cast<std::size_t>(grid.stride(axis));
      const auto down = static_cast<std::int32_t>(std::min(-std::floor(link->low[b] / quantum), longest));
      const auto up = static_cast<std::int32_t>(std::min(std::ceil(link->high[b] / quantum), longest));
      drop[i].length[2 * a + 1] = climb[j].length[2 * a] = down;
      climb[i].length[2 * a + 1] = drop[j].length[2 * a] = up;
    }
  }
}

std::int64_t dijkstra_flat(const std::vector<FlatLinks::Step>& steps,
                           const std::array<std::int64_t, 6>& stride, std::vector<std::int32_t>& values,
                           std::span<const FlatSeed> seeds) {
  // The rise of a node never exceeds that of the node that caused it, for the state is feasible: so rises are
  // settled from the largest down. A heap entry is the rise in the upper half, the node in the lower.
  std::vector<std::int32_t> risen = values;
  std::priority_queue<std::uint64_t> queue;
  const auto offer = [&](std::size_t node, std::int32_t value) {
    if (value <= risen[node])
      return;
    risen[node] = value;
    const auto rise = static_cast<std::uint32_t>(value - values[node]);
    queue.push(std::uint64_t{rise} << 32 | node);
  };
  for (const FlatSeed& seed : seeds)
    offer(static_cast<std::size_t>(seed.node), seed.value);
  std::int64_t settled = 0;
  while (!queue.empty()) {
    const std::uint64_t top = queue.top();
    queue.pop();
    const auto node = static_cast<std::size_t>(top & 0xffffffffU);
    if (static_cast<std::uint32_t>(risen[node] - values[node]) != top >> 32)
      continue; // risen further since
    ++settled;
    for (std::size_t d = 0; d < 6; ++d)
      if (const std::int32_t length = steps[node].length[d]; length != FlatLinks::none)
        offer(node + static_cast<std::size_t>(stride[d]), risen[node] - length);
  }
  values = std::move(risen);
  return settled;
}

namespace {

/// How far the link in direction d from node i to node j is outside its limits, in quanta.
std::int32_t violation(const FlatLinks& links, const std::vector<std::int32_t>& x, std::size_t i,
                       std::size_t j, std::size_t d) {
  return std::max({0, x[i] - links.drop[i].length[d] - x[j], x[j] - x[i] - links.climb[i].length[d]});
}

/// Links of the state outside their limits; `visited` is 0.
ChainMailOutcome count_violations(const std::vector<FlatLinks>& links, double quantum,
                                  const std::vector<std::vector<std::int32_t>>& state) {
  ChainMailOutcome outcome;
  for (std::size_t b = 0; b < links.size(); ++b)
    for (std::size_t i = 0; i < state[b].size(); ++i)
      for (const std::size_t d : {1U, 3U, 5U}) {
        if (links[b].drop[i].length[d] == FlatLinks::none)
          continue;
        const std::int32_t by =
            violation(links[b], state[b], i, i + static_cast<std::size_t>(links[b].stride[d]), d);
        ++outcome.links;
        outcome.violated_links += by > 1 ? 1 : 0;
        outcome.largest_violation = std::max(outcome.largest_violation, by * quantum);
      }
  return outcome;
}

} // namespace

ChainMailOutcome enhanced_chain_mail(const std::vector<FlatLinks>& links, double quantum,
                                     std::vector<std::vector<std::int32_t>>& state, std::int64_t handle,
                                     std::span<const std::int32_t> target) {
  struct Candidate {
    std::int32_t violation;
    std::uint32_t order; ///< of two equal violations the first found goes first
    std::uint32_t node, sponsor;
    std::uint32_t direction;
    bool operator<(const Candidate& other) const {
      return violation < other.violation || (violation == other.violation && order > other.order);
    }
  };
  std::priority_queue<Candidate> list;
  std::vector<bool> is_done(state[0].size(), false);
  std::uint32_t order = 0;
  std::int64_t visited = 0;
  const auto offer_neighbours = [&](std::size_t i) {
    for (std::size_t d = 0; d < 6; ++d) {
      if (links[0].drop[i].length[d] == FlatLinks::none)
        continue;
      const std::size_t j = i + static_cast<std::size_t>(links[0].stride[d]);
      if (is_done[j])
        continue;
      std::int32_t worst = 0;
      for (std::size_t b = 0; b < links.size(); ++b)
        worst = std::max(worst, violation(links[b], state[b], i, j, d));
      if (worst > 0)
        list.push({worst, order++, static_cast<std::uint32_t>(j), static_cast<std::uint32_t>(i),
                   static_cast<std::uint32_t>(d)});
    }
  };
  const auto h = static_cast<std::size_t>(handle);
  for (std::size_t b = 0; b < links.size(); ++b)
    state[b][h] = target[b];
  is_done[h] = true;
  offer_neighbours(h);
  while (!list.empty()) {
    const Candidate next = list.top();
    list.pop();
    if (is_done[next.node])
      continue;
    is_done[next.node] = true;
    ++visited;
    for (std::size_t b = 0; b < links.size(); ++b) {
      const std::int32_t from = state[b][next.sponsor];
      state[b][next.node] =
          std::clamp(state[b][next.node], from - links[b].drop[next.sponsor].length[next.direction],
                     from + links[b].climb[next.sponsor].length[next.direction]);
    }
    offer_neighbours(next.node);
  }
  ChainMailOutcome outcome = count_violations(links, quantum, state);
  outcome.visited = visited;
  return outcome;
}

} // namespace maille::lab
