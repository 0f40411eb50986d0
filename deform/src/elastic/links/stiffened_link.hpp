#pragma once
/// A link that is stiffer than the matter about it.

#include <cstdint>
#include <vector>

namespace maille::deform {

/// Adds stiffness / 2 (u_far - u_near)^2 of one component to the energy.
struct StiffenedLink {
  int component = 0, axis = 0;
  std::int64_t node =
      0; ///< the near one: on a grid its dense number, on a level of a multigrid as that numbers nodes
  double stiffness = 0; ///< [N/m] or what a level counts in
};

/// Links that are there more than once become one; sorted.
std::vector<StiffenedLink> merged(std::vector<StiffenedLink> links);

} // namespace maille::deform
