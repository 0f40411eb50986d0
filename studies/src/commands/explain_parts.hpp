#pragma once
/// The parts of the model, and which of them a scene switches on; its fibres.

#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/scene.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace maille::studies {

/// One part of the model, switched on by the scene or not, and why.
struct ModelPart {
  std::string name;
  bool on = false;
  std::string why;
};

std::vector<ModelPart> parts_of(const Scene& scene, const LinkLimits& limits, const Frame& frame);

/// `1 cell`, `2 cells`
std::string plural(std::int64_t count, const std::string& thing);

/// How a body's fibres run, and where directions come from.
std::string fibre_words(const Specimen& body);
nlohmann::ordered_json in_json(const FibreReport& report);

/// Which fibres pull, and how hard.
std::string contraction_words(const Scene& scene);

} // namespace maille::studies
