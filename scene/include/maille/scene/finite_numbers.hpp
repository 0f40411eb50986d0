#pragma once
/// Whether a scene that no reader has seen asks with numbers at all.

#include "maille/scene/scene.hpp"

#include <string>

namespace maille {

/// The first number of a scene that no method can answer, in words, e.g. `the spacing along y is nan`; empty where there is
/// none. Every number must be finite, and the spacing positive. Readers let nothing else through; this is for scenes that a
/// program has put together.
/// Cost  O(prescribed + loads), and O(cells) where fibres differ or contract
std::string number_not_finite(const Scene& scene);

} // namespace maille
