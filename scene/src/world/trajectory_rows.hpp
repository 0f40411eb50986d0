#pragma once
/// Trajectories as tables: one row per object and frame, as a device records them; and constants of the world
/// that the user changed.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace maille::reader {

/// Largest number of frames: nine hours at 30 frames per second; stored data then take about 360 MB.
inline constexpr std::int64_t most_frames = 1'000'000;

/// @return the valid rows; a fault for each of the others
Trajectory read_trajectory_rows(std::string_view text, const WorldScene& world, FaultList& faults);

std::optional<std::size_t> object_named(const std::string& name, const WorldScene& world);
/// The names of objects that can be driven, for messages.
std::string movable_names(const WorldScene& world);

/// Expected value or place of a setting; nothing if it is valid.
std::optional<std::string> expected_of(const WorldSetting& setting, const WorldScene& world);

/// @pre expected_of(setting, world) is nothing
void apply(const WorldSetting& setting, WorldScene& world);

} // namespace maille::reader
