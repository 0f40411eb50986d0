#pragma once
/// Voxel images: NIfTI-1 and NIfTI-2 (.nii, .nii.gz), MetaImage (.mha, .mhd) and VTK (.vti).

#include "maille/materials/fault.hpp"
#include "maille/scene/grid.hpp"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace maille {

/// What an image's header says. Values are converted to float32 on the way in (exact for labels up to 2^24).
/// Voxels are numbered x fastest. Positions are of voxel *centres*, in metres, in the
/// world frame that the file states (NIfTI: RAS; MetaImage and vti: as in the file), from its own header,
/// orientation included.
struct ImageInfo {
  Index3 size{1, 1, 1};
  int components = 1;    ///< values a voxel (a fourth or fifth NIfTI axis counts as components)
  Vec3 spacing{1, 1, 1}; ///< [m]
  Vec3 origin{0, 0, 0};  ///< centre of voxel 0 [m]
  std::array<Vec3, 3> direction{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows of the matrix image axes -> world
  std::int64_t n_voxels() const { return std::int64_t{1} * size[0] * size[1] * size[2]; }
};

struct Image {
  ImageInfo info;
  std::vector<float>
      values; ///< n_voxels x components, component slowest (planar), scaled by the header's slope
};

/// Limits that a reader keeps to, so that a lying header or a decompression bomb costs nothing.
struct ImageLimits {
  std::int64_t largest_bytes = 0; ///< of the decoded image; 0: half of the memory that the machine has free
};

/// Reads the header only.
/// @throws InputError
ImageInfo read_image_info(const std::filesystem::path& file);

/// Reads the image.
/// Lengths are taken to be millimetres unless the header says otherwise (NIfTI's xyzt_units).
/// @throws InputError: missing, unknown format, truncated, inconsistent, or larger than `limits` (checked
/// from
///         the header, before anything is allocated; the message has the number of bytes)
Image read_image(const std::filesystem::path& file, const ImageLimits& limits = {});

} // namespace maille
