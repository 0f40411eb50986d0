#pragma once
/// Where admission and repair get the bounds that given displacements leave to other nodes: the seam between
/// them and the ways to find shortest paths.

#include "feasible/bounds/step_bounds.hpp"
#include "maille/scene/shortest_paths.hpp"

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

} // namespace maille::deform
