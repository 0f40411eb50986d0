#pragma once
/// Actors of a question picture: coloured parts, fibres, and boundary conditions.

#include "drawing.hpp"
#include "picture/question_arrows.hpp"
#include "picture/question_picture.hpp"

#include <cstddef>
#include <vector>

namespace maille::studies {

/// Colour of one part: distinct also for colour-blind readers if there are few parts.
Vec3 part_colour(std::size_t part, std::size_t n_parts);

/// The body's surface, and cell edges if they are wide enough apart.
Props part_actors(const Scene& scene, const BodyParts& parts, const View& view, double pixels_per_metre);

/// Some hundred evenly spaced strokes along the fibres at visible faces, in another colour for contracting
/// fibres; none for materials without a direction.
Props fibre_actors(const Scene& scene, const View& view, double pixels_per_metre);

/// Dots at held, moved, loaded and spring-supported parts, and the arrows.
Props condition_actors(const Scene& scene, const std::vector<Arrow>& arrows, const View& view,
                       double pixels_per_metre);

} // namespace maille::studies
