#pragma once
/// The parts of the model, and which of them a scene switches on.

#include "maille/scene/frame.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/scene.hpp"

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

} // namespace maille::studies
