#pragma once
/// Trajectories as tables: a row an object and frame, as a device records them.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <cstdint>
#include <string>
#include <string_view>

namespace maille::reader {

/// A trajectory has no more: nine hours at 30 a second, of which what is kept fills some 360 MB.
inline constexpr std::int64_t most_frames = 1'000'000;

/// @return the rows that are good; a fault for each of the others
Trajectory read_trajectory_rows(std::string_view text, const WorldScene& world, FaultList& faults);

std::optional<std::size_t> object_named(const std::string& name, const WorldScene& world);
/// The names of objects that can be driven, for messages.
std::string movable_names(const WorldScene& world);

} // namespace maille::reader
