#pragma once
/// Several passes over the planes of a grid, each of which looks one plane around, as one walk.

#include "parallel/thread_team.hpp"

#include <algorithm>

namespace maille::deform {

/// Calls stage(s, z) for all stages s = 0 ... n_stages - 1 and planes z = 0 ... n_planes - 1. Stage s of a
/// plane comes after stage s - 1 of the plane and its two neighbours, and before stage s + 1 of any of them;
/// so whatever a stage reads within one plane of its own is the same in any order and on any number of
/// threads. A plane goes through its stages while it is in the cache.
///
/// With more threads than one the grid is cut into slabs. Each goes through what it can do alone, a stage
/// less deep with every stage; what is left at the cuts comes second (Frigo and Strumpen 2005, trapezoids).
///
/// @param stage callable as stage(int s, int z), must not throw
template<class Stage>
void run_stages(ThreadTeam& team, int n_planes, int n_stages, Stage&& stage) {
  const int thinnest = 2 * n_stages + 4; // two cuts must not touch, nor the last planes, that look farther
  const int slabs = std::max(1, std::min(team.threads(), n_planes / thinnest));
  const auto cut = [&](int slab) { return static_cast<int>(std::int64_t{1} * n_planes * slab / slabs); };
  team.run(slabs, [&](int slab, int) {
    const int begin = cut(slab), end = cut(slab + 1);
    for (int z = begin; z < end + n_stages; ++z)
      for (int s = 0; s < n_stages; ++s) {
        const int first = slab == 0 ? begin : begin + s, last = slab == slabs - 1 ? end : end - s;
        if (z - s >= first && z - s < last)
          stage(s, z - s);
      }
  });
  if (slabs > 1)
    team.run(slabs - 1, [&](int slab, int) {
      const int at = cut(slab + 1);
      for (int s = 1; s < n_stages; ++s)
        for (int z = at - s; z < at + s; ++z)
          stage(s, z);
    });
}

} // namespace maille::deform
