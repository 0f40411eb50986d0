#pragma once
/// Images and labels deformed by an answer, and deformation fields for other programs, as files.

#include "maille/scene/answer.hpp"
#include "maille/scene/warp/warp.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

struct WarpRequest {
  std::optional<std::filesystem::path> image; ///< grey-value image
  /// Label image; nothing: the body's source image, if it is a segmentation.
  std::optional<std::filesystem::path> labels;
  /// Formats of warped images and the pull field, in addition to .nii.gz: `mha`, `nrrd`.
  std::vector<std::string> also;
  float background = 0;                     ///< value of the warped image outside the body
  std::vector<std::string> surfaces;        ///< formats of the deformed parts' surfaces: `stl`, `ply`, `vtp`
  LengthUnit unit = LengthUnit::millimetre; ///< of surfaces
};

/// Reason that a scene cannot be warped; empty if it can: three dimensions and an image.
std::string why_no_warp(const Scene& scene, const WarpRequest& request);

struct WarpedFiles {
  std::vector<std::filesystem::path> files; ///< in the order of creation
  std::int64_t reached = 0, at_rest = 0, vacated = 0, reached_twice = 0, folded_cells = 0; ///< see Pull
  std::vector<WarpedLabel> labels;   ///< empty without an image of labels
  std::vector<std::string> warnings; ///< about folded, omitted or doubly reached voxels
};

/// Writes `stem` and warped.nii.gz, labels_warped.nii.gz, pull.nii.gz (LPS [mm], 1007), push.nrrd
/// (`displacement field type:=modeling`), jacobian.nii.gz (det F of voxels of matter at rest), and
/// labels.csv. All are on the grid of the image; labels on another grid are warped on theirs. Surfaces are
/// surface.ply and .vtp, and an
/// .stl a part, surface_PART.stl.
///
/// If a file does not state its world, ITK's default applies: LPS for MetaImage, else RAS.
/// @pre   why_no_warp is empty, and the answer has a displacement
/// @throws InputError for invalid images; as write_whole if a file cannot be written
WarpedFiles write_warp(const Scene& scene, const Answer& answer, const WarpRequest& request,
                       const std::filesystem::path& stem);

} // namespace maille::studies
