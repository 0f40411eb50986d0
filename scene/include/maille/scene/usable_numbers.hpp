#pragma once
/// Whether a scene asks with numbers that arithmetic can carry.

#include "maille/scene/scene.hpp"

#include <string>

namespace maille {

/// Numbers other than 0 outside of this range, in SI units, are refused: stiffness times the square of a
/// displacement, in any such units, must stay among the normal numbers of float64.
inline constexpr double least_usable = 1e-60, greatest_usable = 1e60;

/// The first number of a scene that no method can take, in words, e.g. `the spacing along y is nan`; empty
/// where there is none. Every number must be finite, the spacing and the elastic moduli positive, and sizes
/// (spacing, moduli, density, loads, the largest prescribed displacement) 0 or within the range above.
/// Readers let nothing through that is not finite.
/// Cost  O(prescribed + loads), and O(cells) where fibres differ or contract
std::string unusable_number(const Scene& scene);

} // namespace maille
