#pragma once
/// What the JSON of several commands has in common.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {

/// Which question was asked, of what size, by which version, on how many threads.
nlohmann::ordered_json question_json(const Scene& scene, int threads);

/// relative_l2, relative_max and rms [m]
nlohmann::ordered_json norms_json(const ErrorNorms& error);

/// Which version made results, at which commit, on which machine, and when (UTC).
nlohmann::ordered_json made_by();

/// Provenance of a file: version and commit, then `facts`, in one line.
std::string provenance_with(const nlohmann::ordered_json& facts);

} // namespace maille::studies
