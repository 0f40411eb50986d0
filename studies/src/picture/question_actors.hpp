#pragma once
/// What is drawn of a question: cells in the colours of their parts, fibres, and what is done to the body.

#include "layout.hpp"
#include "maille/studies/picture/question_picture.hpp"

#include <vtkProp.h>
#include <vtkSmartPointer.h>

#include <array>
#include <string>
#include <vector>

namespace maille::studies {

using Props = std::vector<vtkSmartPointer<vtkProp>>;

inline constexpr Vec3 held_colour{0.10, 0.12, 0.16}, moved_colour{0.82, 0.10, 0.12},
    loaded_colour{0.45, 0.15, 0.65};

/// One of so many parts: apart for the colour-blind while there are few.
Vec3 part_colour(std::size_t part, std::size_t n_parts);

/// The body's surface, and its cells' edges where those can be told apart.
Props part_actors(const Scene& scene, const BodyParts& parts, const View& view, double pixels_per_metre);

/// Strokes along the fibres of cells whose faces are seen, some hundred of them, in even distances; none
/// where the matter has no direction.
Props fibre_actors(const Scene& scene, const View& view, double pixels_per_metre);

/// An arrow of the picture's plane: from a point of the body [m], or to it.
struct Arrow {
  Vec3 from{}, to{}; ///< object's frame [m]
  Vec3 colour{};
};
/// Of moves, tractions and gravity, all of that length [m].
std::vector<Arrow> arrows_of(const Scene& scene, double length);

/// Dots at what is held and moved, and the arrows.
Props condition_actors(const Scene& scene, const std::vector<Arrow>& arrows, const View& view,
                       double pixels_per_metre);

} // namespace maille::studies
