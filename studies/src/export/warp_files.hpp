#pragma once
/// Images and labels where an answer has moved their matter, and the fields that other programs take, as
/// files.

#include "maille/scene/answer.hpp"
#include "maille/scene/warp/warp.hpp"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

struct WarpRequest {
  std::optional<std::filesystem::path> image; ///< of grey values
  /// Of labels; nothing: the image that the body was read from, where that is a segmentation.
  std::optional<std::filesystem::path> labels;
  /// Of warped images and the pull field, beside .nii.gz: `mha`, `nrrd`.
  std::vector<std::string> also;
  float background = 0;                     ///< of the warped image where there is no matter
  std::vector<std::string> surfaces;        ///< formats of the deformed parts' surfaces: `stl`, `ply`, `vtp`
  LengthUnit unit = LengthUnit::millimetre; ///< of those
};

/// Why a scene cannot be warped; empty where it can: it has three dimensions, and there is an image.
std::string why_no_warp(const Scene& scene, const WarpRequest& request);

struct WarpedFiles {
  std::vector<std::filesystem::path> files; ///< in the order of their making
  std::int64_t reached = 0, at_rest = 0, vacated = 0, reached_twice = 0, folded_cells = 0; ///< see Pull
  std::vector<WarpedLabel> labels;   ///< empty without an image of labels
  std::vector<std::string> warnings; ///< in words: what was folded, left out or reached twice
};

/// Writes `stem` and warped.nii.gz, labels_warped.nii.gz, pull.nii.gz (LPS [mm], 1007), push.nrrd
/// (`displacement field type:=modeling`), jacobian.nii.gz (det F of voxels of matter at rest), and
/// labels.csv. All are on the grid of the image; labels on another grid are warped on theirs. Surfaces are
/// surface.ply and .vtp, and an
/// .stl a part, surface_PART.stl.
///
/// A world that the file does not state is the one that ITK takes it for: LPS of MetaImage, else RAS.
/// @pre   why_no_warp is empty, and the answer has a displacement
/// @throws InputError for faulty images; as write_whole where a file cannot be written
WarpedFiles write_warp(const Scene& scene, const Answer& answer, const WarpRequest& request,
                       const std::filesystem::path& stem);

} // namespace maille::studies
