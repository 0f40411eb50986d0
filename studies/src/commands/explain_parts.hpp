#pragma once
/// Model features and their use in a scene; fibres.

#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/scene.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "results/scene_tables.hpp"

#include <string>
#include <vector>

namespace maille::studies {

std::vector<ModelPart> parts_of(const Scene& scene, const LinkLimits& limits, const Frame& frame);
/// Model features of a world and their costs.
std::vector<ModelPart> parts_of(const WorldScene& scene);

/// `1 cell`, `2 cells`
std::string plural(std::int64_t count, const std::string& thing);

/// Description of a body's fibres and of the source of their directions.
std::string fibre_words(const Specimen& body);
const ResultTable<FibreReport>& columns_of_fibres();

/// Description of contracting fibres and their tension.
std::string contraction_words(const Scene& scene);

} // namespace maille::studies
