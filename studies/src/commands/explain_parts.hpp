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

/// Estimated time on one thread of a Zen 4 EPYC to the tolerance of the scene, within a factor of three for
/// the bodies of docs/speed.md; 0 if limits, borders or frames need an unknown number of iterations.
double seconds_of_coupled(const Scene& scene);

/// Description of contracting fibres and their tension.
std::string contraction_words(const Scene& scene);

} // namespace maille::studies
