#pragma once
/// Forces and moments on what holds, moves and loads the body.

#include "maille/scene/mechanics/mechanics.hpp"

namespace maille {

/// Holds, moves and loads alone.
Mechanics resultants_of(const Scene& scene, const Answer& answer);

} // namespace maille
