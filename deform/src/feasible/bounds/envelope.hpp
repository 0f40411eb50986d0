#pragma once
/// The highest and the lowest state that prescribed values allow: both are one multi-source search.

#include "maille/scene/shortest_paths.hpp"

#include <concepts>
#include <span>
#include <vector>

namespace maille::deform {

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
