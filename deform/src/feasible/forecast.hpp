#pragma once
/// Upper bound of the memory of `limits` and drags, before they allocate it.

#include "maille/deform/plan.hpp"

namespace maille::deform {

/// Memory of an answer by `limits`, at its peak.
Footprint forecast_of_limits(const Scene& scene, const LinkLimits& limits,
                             const std::array<Algorithm, 3>& algorithms, int threads);
/// Memory of a body prepared for dragging, at rest.
Footprint forecast_of_drag(const Scene& scene, const LinkLimits& limits);
/// Memory of a body in tiles, at rest. Cost: O(cells) where the body does not fill its grid
Footprint forecast_of_tiles(const Scene& scene, const LinkLimits& limits);

} // namespace maille::deform
