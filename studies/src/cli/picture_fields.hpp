#pragma once
/// What pictures show beside displacements.

#include "maille/scene/answer.hpp"

#include <filesystem>

namespace maille::studies {

/// Strain or stress as pictures take it: at every node a vector whose length is the mean over its cells of
/// matter, of the principal strain of largest size [1], or of von Mises' stress [Pa].
Displacement nodal_sizes(const Scene& scene, const Displacement& displacement, bool of_stress);

/// True if the scene's body is from a NIfTI image: its world is right, anterior, superior of a patient.
bool is_of_a_patient(const std::filesystem::path& scene);

} // namespace maille::studies
