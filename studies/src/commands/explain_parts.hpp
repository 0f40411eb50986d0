#pragma once
/// The parts of the model, and which of them a scene switches on; its fibres.

#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "results/scene_tables.hpp"

#include <string>
#include <vector>

namespace maille::studies {

std::vector<ModelPart> parts_of(const Scene& scene, const LinkLimits& limits, const Frame& frame);
/// What a world has and pays for.
std::vector<ModelPart> parts_of(const WorldScene& scene);

/// `1 cell`, `2 cells`
std::string plural(std::int64_t count, const std::string& thing);

/// How a body's fibres run, and where directions come from.
std::string fibre_words(const Specimen& body);
const ResultTable<FibreReport>& columns_of_fibres();

/// Which fibres pull, and how hard.
std::string contraction_words(const Scene& scene);

} // namespace maille::studies
