#pragma once
/// The nodes of a region, for programs that drive a body by hand.

#include "maille/scene/scene.hpp"

#include <string_view>
#include <vector>

namespace maille {

/// @param where  as scene files have it: `x-`, `superior`, or a table in TOML, `{ label = 17, touching = 30
///         }`; numbers without a unit in SI
/// @return nodes of the body, ascending; empty where none is in it
/// @throws InputError  what is no region
std::vector<std::int64_t> nodes_in(const Scene& scene, std::string_view where);

} // namespace maille
