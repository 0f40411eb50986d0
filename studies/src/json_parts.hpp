#pragma once
/// What the JSON of several commands has in common.

#include "maille/materials/fault.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/scene.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {

/// Which question was asked, of what size, by which version, on how many threads.
nlohmann::ordered_json question_json(const Scene& scene, int threads);

/// relative_l2, relative_max and rms [m]
nlohmann::ordered_json norms_json(const ErrorNorms& error);

/// setup, solve and total [s]
nlohmann::ordered_json seconds_json(const Seconds& seconds);

/// size_m, largest_move_m, move_over_length, mean_strain, strain_of_loads, warnings
nlohmann::ordered_json in_json(const Plausibility& found);

/// A list of file, line, key, expected, found.
nlohmann::ordered_json faults_json(const std::vector<Fault>& faults);

} // namespace maille::studies
