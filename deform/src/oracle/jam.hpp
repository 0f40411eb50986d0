#pragma once
/// Finds nodes that hold each other back although all of them would move on together.

#include "oracle/component_sweep.hpp"

namespace maille::deform {

struct Jams {
  std::int64_t groups = 0;
  double farthest = 0; ///< the most that a group would move before its outer links stop it [m]
};

/// Looks at a state in which no single node can come nearer to the mean of its neighbours.
///
/// Nodes of a group are joined by links that stop one of their ends. A group is jammed if its links to other
/// nodes pull it on as a whole, and let it. At the least energy within the limits there are none; that there
/// are none does not prove the least energy (only shifts of whole groups are tried).
///
/// @param rounding how near to its limit a link counts as stopped [m]
/// @param smallest shorter moves of a group are not reported [m]
/// Cost O(links)
Jams find_jams(const LinkTable& table, const ComponentSweep& component, double rounding, double smallest);

} // namespace maille::deform
