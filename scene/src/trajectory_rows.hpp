#pragma once
/// Trajectories as tables: a row an object and frame, as a device records them.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/trajectory.hpp"

#include <string>
#include <string_view>

namespace maille::reader {

/// @return the rows that are good; a fault for each of the others
Trajectory read_trajectory_rows(std::string_view text, const WorldScene& world, FaultList& faults);

std::optional<std::size_t> object_named(const std::string& name, const WorldScene& world);
/// The names of objects that can be driven, for messages.
std::string movable_names(const WorldScene& world);

} // namespace maille::reader
