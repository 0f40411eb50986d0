#pragma once
/// The bounds that given displacements leave to other nodes: the seam between clipping and projection and the
/// ways to find shortest paths.

#include "feasible/bounds/step_bounds.hpp"
#include "maille/scene/shortest_paths.hpp"

#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

class BoundSource {
public:
  virtual ~BoundSource() = default;

  /// For every one of `nodes`: the greatest displacement that `ends` leave it, min over ends of p_h + d(h,
  /// node), or the least, max over ends of p_h - d(node, h), along `component`; infinite where no end leads.
  /// Ends and nodes in any order, with the same bits.
  virtual void bounds_at(Side side, int component, std::span<const PathEnd> ends,
                         std::span<const std::int64_t> nodes, std::span<double> values) = 0;
};

/// By Dijkstra's algorithm: any body. The oracle of the others.
class DijkstraBounds : public BoundSource {
public:
  DijkstraBounds(const Scene& scene, const LinkLimits& limits) : scene_(scene), limits_(limits) {}
  void bounds_at(Side side, int component, std::span<const PathEnd> ends, std::span<const std::int64_t> nodes,
                 std::span<double> values) override;

private:
  const Scene& scene_;
  const LinkLimits& limits_;
};

/// min over ends h of (p_h + d(h, i)) for every grid node i; +infinity where no end leads.
std::vector<double> upper_envelope(const Scene& scene, const LinkLimits& limits, int component,
                                   std::span<const PathEnd> ends);
/// max over ends h of (p_h - d(i, h)) for every grid node i; -infinity where no end leads.
std::vector<double> lower_envelope(const Scene& scene, const LinkLimits& limits, int component,
                                   std::vector<PathEnd> ends);

/// The prescribed values of one component that satisfy `wanted`, as ends of paths.
template<std::predicate<const Prescribed&> Wanted>
std::vector<PathEnd> path_ends(std::span<const Prescribed> prescribed, int component, Wanted wanted) {
  std::vector<PathEnd> ends;
  for (const Prescribed& p : prescribed)
    if (p.component == component && wanted(p))
      ends.push_back({p.node, p.value});
  return ends;
}

} // namespace maille::deform
