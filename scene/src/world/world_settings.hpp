#pragma once
/// Constants of a world that a hand has changed.

#include "maille/scene/world/trajectory.hpp"

#include <optional>
#include <string>

namespace maille::reader {

/// What the setting's value ought to be, or where it may stand; nothing where it is right.
std::optional<std::string> expected_of(const WorldSetting& setting, const WorldScene& world);

/// @pre expected_of(setting, world) is nothing
void apply(const WorldSetting& setting, WorldScene& world);

} // namespace maille::reader
