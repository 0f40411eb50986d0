#pragma once
/// Answers as NIfTI images on the voxels of the image that a body was read from.

#include "maille/scene/answer.hpp"

#include <filesystem>
#include <vector>

namespace maille::studies {

/// Why a scene has no maps; empty where it has: its body is from an image and three-dimensional.
std::string why_no_maps(const Scene& scene);

/// @brief Writes `stem_strain.nii.gz` (symmetric matrix), `stem_displacement.nii.gz` (vector, of middles of
///        voxels [mm]), where there are fibres `stem_fibre_strain.nii.gz`, and of answers with stress
///        `stem_stress`, `stem_von_mises` and `stem_fibre_stress` [Pa].
///
/// Vectors and tensors are in the world's frame (RAS) of the body at rest, as the voxels are; voxels without
/// matter are 0. A cell of several voxels gives each its strain and stress; displacements are linear
/// between its corners.
///
/// @pre   why_no_maps is empty, and the answer has a displacement
/// @return the files, in that order
/// @throws InputError where the image is there no more; as write_whole where a file cannot be written
std::vector<std::filesystem::path> write_voxel_maps(const Scene& scene, const Answer& answer, bool has_stress,
                                                    const std::filesystem::path& stem);

} // namespace maille::studies
