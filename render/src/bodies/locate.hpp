#pragma once
/// A single point carried back to rest, in double precision. Private to render.

#include "cast/cast_task.hpp"

#include <optional>

namespace maille::render {

/// Where the matter that a ray meets at `depth` was at rest, in the object's frame.
/// @param ray   in the object's frame @param stretch the part of the ray inside the body that holds `depth`
/// @param stride of the walk from where the stretch begins [m]
/// @return nothing where the walk is lost: cells that are folded
std::optional<Vec3> rest_on_ray(const Deformation& deformation, const Ray& ray, const Stretch& stretch,
                                double depth, double stride);

} // namespace maille::render
