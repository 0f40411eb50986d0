#pragma once
/// Contents of a result page from the scene: the question in words, and pictures of bodies.

#include "maille/scene/answer.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace maille::studies {

/// A scene in one sentence: the body, its boundary conditions and loads, and their size.
std::string question_of(const Scene& scene);

/// Draws the bodies of SCENE_KIND_results.json of compare or run, from its files for ParaView.
///
/// Keys: `question`, `body` (at rest; interior strain), `pictures` (answers side by side), `maps` (by method,
/// local error): pictures have `source` (a data URI), `look`, `alt` and `caption`. `notes` list missing parts
/// with reasons. python/maille/_report.py makes the page.
/// @param folder  folder of the files for ParaView
/// Cost  about a second per picture: at most four per scene, and one per method
nlohmann::ordered_json drawn_bodies(const nlohmann::ordered_json& results,
                                    const std::filesystem::path& folder);

} // namespace maille::studies
