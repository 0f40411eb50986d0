#pragma once
/// Common parts of the JSON of several commands.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {

/// Description of the question: scene, size, version, threads.
nlohmann::ordered_json question_json(const Scene& scene, int threads);

/// relative_l2, relative_max and rms [m]
nlohmann::ordered_json norms_json(const ErrorNorms& error);

/// Origin of results: version, commit, machine and time (UTC).
nlohmann::ordered_json made_by();

/// Provenance of a file: version and commit, then `facts`, on one line.
std::string provenance_with(const nlohmann::ordered_json& facts);

} // namespace maille::studies
