#pragma once
/// How far one answer is from another.

#include "maille/scene/answer.hpp"

namespace maille {

/// Norms of u - r over the nodes that are neither held nor moved in any component; all 0 where there is none.
/// The relative ones are infinite where r is zero and u is not.
struct ErrorNorms {
  double relative_l2 = 0;  ///< |u-r|_2 / |r|_2
  double relative_max = 0; ///< max |u-r| / max |r|, Euclidean length per node
  double rms = 0;          ///< sqrt(mean |u-r|^2 per node) [m]
};

/// @pre both hold a displacement on the scene's grid
ErrorNorms compare(const Scene& scene, const Displacement& answer, const Displacement& reference);

} // namespace maille
