#pragma once
/// Random scenes of every kind that files can ask for.

#include "maille/checks/choices.hpp"
#include "maille/scene/scene.hpp"

#include <string>

namespace maille::studies {

/// A scene in one, two or three dimensions, mostly of a few dozen nodes: box or holed body with islands and
/// bridges, one to three materials of any valid symmetry and contrast, fibres in any direction, limits given,
/// of the materials or taut, some of no width and some far too wide, holds and moves of faces and of single
/// components of nodes, from a millionth of a spacing to a thousand bodies, at times loads. Every number is
/// finite and valid; nothing says that the question has an answer.
Scene random_scene(Choices& choices);

/// The scene as people can read it, some lines.
std::string in_words(const Scene& scene);

} // namespace maille::studies
