#pragma once
/// What the wavefront is measured against: a good Dijkstra, and the chain mail of the literature.

#include "maille/scene/link_limits.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::lab {

/// The links of a body for one displacement component in flat arrays, in whole quanta, bounds rounded
/// outward.
struct FlatLinks {
  FlatLinks(const Scene& scene, const LinkLimits& limits, int component, double quantum);

  /// A link from a node: how far the neighbour may stay below it (drop) and above it (climb), both >= 0;
  /// `none` where there is no link.
  static constexpr std::int32_t none = -1;
  struct Step {
    std::array<std::int32_t, 6> length; ///< to -x +x -y +y -z +z
  };
  std::vector<Step> drop, climb;        ///< per grid node
  std::array<std::int64_t, 6> stride{}; ///< of the neighbours
};

struct FlatSeed {
  std::int64_t node = 0;
  std::int32_t value = 0;
};

/// x_i = max(x_i, max over seeds of value - length of the shortest path from seed to node), in place:
/// Dijkstra 1959 by Johnson's potentials, with a binary heap of 64-bit keys, in the same 32-bit numbers as
/// the wavefront. With `links.climb` and negated values the same for min.
/// @param values a feasible state; @return the nodes settled
std::int64_t dijkstra_flat(const std::vector<FlatLinks::Step>& steps,
                           const std::array<std::int64_t, 6>& stride, std::vector<std::int32_t>& values,
                           std::span<const FlatSeed> seeds);

/// What is left of the limits.
struct ChainMailOutcome {
  std::int64_t visited = 0;
  std::int64_t links = 0;          ///< of the body, times components
  std::int64_t violated_links = 0; ///< by more than one quantum
  double largest_violation = 0;    ///< [m]
};

/// Enhanced chain mail (Schill, Gibson, Bader, Manner 1998): one list of nodes for all components, the
/// largest violation of any component first, every node moved once, as far as the link to the node that
/// offered it asks.
/// @param state       in quanta, [component][node]; changed in place
/// @param handle      node put at `target` first
/// Wrong unless the paths of all components are the same; see docs/theory.md, section 1
ChainMailOutcome enhanced_chain_mail(const std::vector<FlatLinks>& links, double quantum,
                                     std::vector<std::vector<std::int32_t>>& state, std::int64_t handle,
                                     std::span<const std::int32_t> target);

} // namespace maille::lab
