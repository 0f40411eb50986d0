#include "oracle/jam.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace maille::deform {

namespace {

/// Disjoint sets of nodes (union-find with path halving).
class Groups {
public:
  explicit Groups(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t of(std::size_t node) {
    while (parent_[node] != node)
      node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  void join(std::size_t a, std::size_t b) { parent_[std::max(of(a), of(b))] = std::min(of(a), of(b)); }

private:
  std::vector<std::size_t> parent_;
};

/// What acts on a group from outside.
struct Pull {
  double sum = 0; ///< of differences of displacement over the outer links
  std::int64_t links = 0;
  double room_up = std::numeric_limits<double>::infinity();
  double room_down = std::numeric_limits<double>::infinity();

  double reach() const {
    const double wanted = links > 0 ? std::abs(sum) / static_cast<double>(links) : 0;
    return std::min(wanted, sum > 0 ? room_up : room_down);
  }
};

/// One component's links and state, in short.
struct View {
  const LinkTable& table;
  const std::vector<double>& u;
  std::span<const double> below, above;

  std::size_t begin(std::size_t node) const { return static_cast<std::size_t>(table.first()[node]); }
  std::size_t end(std::size_t node) const { return static_cast<std::size_t>(table.first()[node + 1]); }
  std::size_t other(std::size_t entry) const { return static_cast<std::size_t>(table.neighbour()[entry]); }
  double room_up(std::size_t node, std::size_t entry) const {
    return u[other(entry)] + above[entry] - u[node];
  }
  double room_down(std::size_t node, std::size_t entry) const {
    return u[node] - u[other(entry)] - below[entry];
  }
  /// Sum over a node's links of the neighbour's displacement less its own.
  double pull(std::size_t node) const {
    double sum = 0;
    for (std::size_t e = begin(node); e < end(node); ++e)
      sum += u[other(e)] - u[node];
    return sum;
  }
};

Groups join_stopped_links(const View& view, const std::vector<std::size_t>& free,
                          const std::vector<bool>& is_free, double rounding) {
  Groups groups(view.u.size());
  for (const std::size_t i : free) {
    const double pull = view.pull(i);
    if (std::abs(pull) <= rounding)
      continue;
    for (std::size_t e = view.begin(i); e < view.end(i); ++e) {
      const double room = pull > 0 ? view.room_up(i, e) : view.room_down(i, e);
      if (room <= rounding && is_free[view.other(e)])
        groups.join(i, view.other(e));
    }
  }
  return groups;
}

} // namespace

Jams find_jams(const LinkTable& table, const ComponentSweep& component, double rounding, double smallest) {
  const View view{table, component.values(), table.below(component.component()),
                  table.above(component.component())};
  const std::vector<std::size_t> free(component.free_nodes().begin(), component.free_nodes().end());
  std::vector<bool> is_free(view.u.size(), false);
  for (const std::size_t i : free)
    is_free[i] = true;
  Groups groups = join_stopped_links(view, free, is_free, rounding);

  std::vector<Pull> pulls(view.u.size());
  for (const std::size_t i : free)
    for (std::size_t e = view.begin(i); e < view.end(i); ++e) {
      const std::size_t group = groups.of(i), other = view.other(e);
      if (is_free[other] && groups.of(other) == group)
        continue;
      Pull& pull = pulls[group];
      pull.sum += view.u[other] - view.u[i];
      pull.links += 1;
      pull.room_up = std::min(pull.room_up, view.room_up(i, e));
      pull.room_down = std::min(pull.room_down, view.room_down(i, e));
    }
  Jams jams;
  for (const Pull& pull : pulls)
    if (pull.reach() > smallest) {
      ++jams.groups;
      jams.farthest = std::max(jams.farthest, pull.reach());
    }
  return jams;
}

} // namespace maille::deform
