#pragma once
/// What `explain` says about fibres.

#include "maille/scene/scene.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace maille::studies {

/// How a body's fibres run, and where directions come from.
std::string fibre_words(const Specimen& body);
nlohmann::ordered_json in_json(const FibreReport& report);

/// Which fibres pull, and how hard.
std::string contraction_words(const Scene& scene);

} // namespace maille::studies
