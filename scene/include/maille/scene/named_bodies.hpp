#pragma once
/// Bodies on which propagation is hard, by name: tests, studies and benchmarks ask about the same ones.

#include "maille/scene/scene.hpp"

#include <string_view>
#include <vector>

namespace maille {

/// random   every cell's slack is scaled by its own random number from 0.05 to 1
/// checker  blocks of 8 cells a side, slack scaled by 1 and by 0.1 in turn
/// bore     one material; a bore through three quarters of the height, joined to a slot from one side
/// smooth   slack scaled by a smooth function of the position, 0.05 to 0.55
const std::vector<std::string_view>& named_bodies();

/// A cube of n x n x n nodes, 1 m apart, with limits of the materials: unscaled, stretch 1.4, compress 0.75,
/// shear 0.15, so no component's paths are those of another. The node at (n / 5, n / 5, 0) is moved by
/// (0.13, -0.07, -0.25) n m, far enough to set every node in motion.
///
/// @param name one of named_bodies(); @param n >= 8
/// Repeatable: same arguments, same bits
Scene named_body(std::string_view name, int n);

} // namespace maille
