#pragma once
/// What is drawn of a question: cells in the colours of their parts, fibres, and what is done to the body.

#include "drawing.hpp"
#include "picture/question_arrows.hpp"
#include "picture/question_picture.hpp"

#include <cstddef>
#include <vector>

namespace maille::studies {

/// Colour of one part: distinct for the colour-blind while there are few.
Vec3 part_colour(std::size_t part, std::size_t n_parts);

/// The body's surface, and its cells' edges where those can be told apart.
Props part_actors(const Scene& scene, const BodyParts& parts, const View& view, double pixels_per_metre);

/// Strokes along the fibres of cells whose faces are seen, some hundred of them, in even distances, in
/// another colour where they contract; none where the matter has no direction.
Props fibre_actors(const Scene& scene, const View& view, double pixels_per_metre);

/// Dots at what is held, moved, loaded and on springs, and the arrows.
Props condition_actors(const Scene& scene, const std::vector<Arrow>& arrows, const View& view,
                       double pixels_per_metre);

} // namespace maille::studies
