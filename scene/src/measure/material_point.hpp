#pragma once
/// What fields are at a material point.

#include "maille/scene/measure/measure.hpp"

namespace maille {

/// Multilinear in the cell that holds it, object's frame [m]. @pre some cell does
Vec3 displacement_at(const Specimen& specimen, const Displacement& displacement, const MaterialPoint& point);

} // namespace maille
