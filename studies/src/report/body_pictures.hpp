#pragma once
/// What a page of results needs of the scene itself: the question in words, and pictures of bodies.

#include "maille/scene/answer.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace maille::studies {

/// What a scene asks, in a sentence: the body, what is done to it, and what that comes to.
std::string question_of(const Scene& scene);

/// Draws the bodies of SCENE_KIND_results.json of compare or run, from the files for ParaView.
///
/// `question`, `body` (at rest; strain inside), `pictures` (answers beside each other), `maps` (by method,
/// the place of its error): pictures are `source` (a data URI), `look`, `alt` and `caption`. `notes` say what
/// is missing, and why. python/maille/_report.py makes the page.
/// @param folder  where the files for ParaView are
/// Cost  about a second a picture: four a scene at most, and one a method
nlohmann::ordered_json drawn_bodies(const nlohmann::ordered_json& results,
                                    const std::filesystem::path& folder);

} // namespace maille::studies
