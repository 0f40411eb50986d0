#pragma once
/// What `check` and `explain` say about a scene of several objects.

#include "maille/deform/world/world.hpp"

#include <nlohmann/json_fwd.hpp>

#include <filesystem>
#include <string>

namespace maille::studies {

/// One line: `2D world of 64 x 48 cells, 1 fixed, 1 rigid, 0 deformable objects`.
std::string in_words(const WorldScene& scene);
/// The world as it begins. @param file of the scene, for messages
/// @throws InputError where objects share cells or leave the world, which only shows when they are placed
deform::World world_of(const WorldScene& scene, const std::filesystem::path& file);
/// What the scene switches on, and what that costs.
std::string explanation(const WorldScene& scene, const deform::World& world);
nlohmann::ordered_json explanation_in_json(const WorldScene& scene, const deform::World& world);

} // namespace maille::studies
