#pragma once
/// Answers as NIfTI images on the voxels of the body's source image.

#include "maille/scene/answer.hpp"

#include <filesystem>
#include <vector>

namespace maille::studies {

/// Reason that a scene has no maps; empty if it has: a three-dimensional body from an image.
std::string why_no_maps(const Scene& scene);

/// @brief Writes `stem_strain.nii.gz` (symmetric matrix), `stem_displacement.nii.gz` (vector, at voxel
///        centres [mm]), with fibres `stem_fibre_strain.nii.gz`, and with stress `stem_stress`,
///        `stem_von_mises` and `stem_fibre_stress` [Pa].
///
/// Vectors and tensors are in the world's frame (RAS) of the body at rest, like the voxels; voxels outside
/// the body are 0. All voxels of a cell get its strain and stress; displacements are interpolated linearly
/// between its corners.
///
/// @pre   why_no_maps is empty, and the answer has a displacement
/// @return the files, in that order
/// @throws InputError if the image no longer exists; as write_whole if a file cannot be written
std::vector<std::filesystem::path> write_voxel_maps(const Scene& scene, const Answer& answer, bool has_stress,
                                                    const std::filesystem::path& stem);

} // namespace maille::studies
