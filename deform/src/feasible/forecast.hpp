#pragma once
/// What `limits` and drags are going to hold, at most, before they allocate it.

#include "maille/deform/plan.hpp"

namespace maille::deform {

/// Of an answer by `limits`, at its peak.
Footprint forecast_of_limits(const Scene& scene, const LinkLimits& limits,
                             const std::array<Algorithm, 3>& algorithms, int threads);
/// Of a body that is made to be dragged, at rest.
Footprint forecast_of_drag(const Scene& scene, const LinkLimits& limits);
/// Of a body in tiles, at rest. Cost: O(cells) where the body does not fill its grid
Footprint forecast_of_tiles(const Scene& scene, const LinkLimits& limits);

} // namespace maille::deform
