#pragma once
/// What commands read and show: inputs that no option can overwrite, fields of pictures, worlds in words.

#include "maille/scene/answer.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace maille::studies {

/// Keeps (keep_input) the files that a command line names; those that they name are kept as they are opened.
void keep_inputs(const std::vector<std::filesystem::path>& files);

/// The text of a scene file; nothing where it can no longer be read: part of it would be another scene.
std::string scene_text_of(const std::filesystem::path& file);

/// Strain or stress as pictures take it: at every node a vector whose length is the mean over its cells of
/// matter, of the principal strain of largest size [1], or of von Mises' stress [Pa].
Displacement nodal_sizes(const Scene& scene, const Displacement& displacement, bool of_stress);

/// True if the scene's body is from a NIfTI image: its world is right, anterior, superior of a patient.
bool is_of_a_patient(const std::filesystem::path& scene);

/// One line: `2D world of 64 x 48 cells, 1 fixed, 1 rigid, 0 deformable objects`.
std::string in_words(const WorldScene& scene);

} // namespace maille::studies
