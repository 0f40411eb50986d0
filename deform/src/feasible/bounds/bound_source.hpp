#pragma once
/// Bounds that prescribed displacements impose on other nodes: the interface between clipping or projection
/// and the algorithms for shortest paths, and path lengths where limits are equal along an axis.
///
/// Notation: d(i, j) is the shortest path over the slack of links, from node i to node j; p the displacement
/// of a handle. Limits are difference constraints, so every feasible u_i is at least p - d(i, handle) and at
/// most p + d(handle, i), and clamping between the bounds of all handles is the least movement
/// (docs/theory.md, Theorem 1). Exact, but for the rounding of sums along paths.

#include "maille/scene/link_limits.hpp"

#include <array>
#include <concepts>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// Bound around a handle of given displacement: the least displacement of other nodes (raising: L_i = p -
/// d(i, handle)), or the greatest (U_i = p + d(handle, i)).
enum class Side { least, greatest };

/// Change of the bound per link, in the direction of the axis (ahead) and against it (behind); a bound
/// at offset o is p + sum_a o_a * (o_a >= 0 ? ahead[a] : behind[a]) on a box (docs/theory.md, Theorem 2).
struct Slopes {
  Vec3 ahead{}, behind{};

  Slopes(const LinkIntervals<double>& links, Side side)
      : ahead(side == Side::least ? links.low : links.high),
        behind(side == Side::least ? links.high : links.low) {}
  double along(std::size_t axis, int offset) const {
    return offset * (offset >= 0 ? ahead[axis] : behind[axis]);
  }
};

/// Per component, by link axis [m]; zero along axes that the grid does not have. @pre limits.is_homogeneous()
std::array<LinkIntervals<double>, 3> intervals_by_axis(const Scene& scene, const LinkLimits& limits);

/// The largest d(i, j) + d(j, i) of two nodes of a full grid: the range of their displacement difference.
double slack_range(const LinkIntervals<double>& by_axis, const Index3& nodes);

/// True if every node of the body is joined to `from` by a lattice path of links that never turns back along
/// any axis, so that closed forms hold although the body does not fill its grid. O(nodes) time, two slabs.
bool reaches_all_monotonely(const Specimen& body, const Index3& from);

class BoundSource {
public:
  virtual ~BoundSource() = default;

  /// For each of `nodes`: the greatest displacement that `ends` allow, min over ends of p_h + d(h, node), or
  /// the least, max over ends of p_h - d(node, h), along `component`; infinite without a path. Bits do not
  /// depend on the order of ends and nodes.
  virtual void bounds_at(Side side, int component, std::span<const PathEnd> ends,
                         std::span<const std::int64_t> nodes, std::span<double> values) = 0;
};

/// Bounds by Dijkstra's algorithm, on any body: the oracle of the other sources.
class DijkstraBounds : public BoundSource {
public:
  DijkstraBounds(const Scene& scene, const LinkLimits& limits) : scene_(scene), limits_(limits) {}
  void bounds_at(Side side, int component, std::span<const PathEnd> ends, std::span<const std::int64_t> nodes,
                 std::span<double> values) override;

private:
  const Scene& scene_;
  const LinkLimits& limits_;
};

/// min over ends h of (p_h + d(h, i)) for every grid node i; +infinity without a path.
List<double> upper_envelope(const Scene& scene, const LinkLimits& limits, int component,
                            std::span<const PathEnd> ends);
/// max over ends h of (p_h - d(i, h)) for every grid node i; -infinity without a path.
List<double> lower_envelope(const Scene& scene, const LinkLimits& limits, int component,
                            std::span<const PathEnd> ends);

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
