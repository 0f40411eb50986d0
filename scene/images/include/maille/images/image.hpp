#pragma once
/// Voxel images: NIfTI-1 and NIfTI-2 (.nii, .nii.gz), MetaImage (.mha, .mhd), NRRD (.nrrd, .nhdr), VTK
/// (.vti) and series of DICOM files.
///
/// Every reader returns the same Image: float32 values and an affine map from voxel indices to one world,
/// RAS or LPS as the format defines. Where a header says too little or contradicts itself, the documented
/// fallback applies, and warn_of_file reports it.

#include "maille/base/grid.hpp"
#include "maille/materials/fault.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace maille {

/// What an image's header says. Values are converted to float32 on the way in (exact for labels up to 2^24).
/// Voxels are numbered x fastest. Positions are of voxel *centres*, in metres, in the world frame that the
/// file states (NIfTI: RAS; MetaImage, NRRD, vti: as in the file), from its own header, orientation included:
/// world = origin + direction (spacing .* index), the columns of direction orthonormal.
struct ImageInfo {
  Index3 size{1, 1, 1};
  int components = 1;    ///< values a voxel (a fourth or fifth NIfTI axis counts as components)
  Vec3 spacing{1, 1, 1}; ///< [m]
  Vec3 origin{0, 0, 0};  ///< centre of voxel 0 [m]
  std::array<Vec3, 3> direction{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows of the matrix image axes -> world
  /// NIfTI: ras; DICOM: lps; MetaImage with AnatomicalOrientation, as ITK writes it: lps; NRRD: what `space`
  /// says (of left-anterior-superior, ras, x turned round). A file that does not say is lps, as for ITK.
  WorldAxes world = WorldAxes::unknown;
  bool states_world = true; ///< false: `world` is the fallback
  /// Rows of the matrix from the frame of the file's vectors and tensors to the world, where the header
  /// states it: NIfTI's intents 1006 (RAS) and 1007 (LPS, as ITK writes it), NRRD's space and measurement
  /// frame.
  std::optional<std::array<Vec3, 3>> vectors_to_world{};
  std::int64_t n_voxels() const { return std::int64_t{1} * size[0] * size[1] * size[2]; }
};

struct Image {
  ImageInfo info;
  /// n_voxels x components, component slowest (planar), scaled by NIfTI's slope and intercept. NaN and
  /// infinities are as in the file.
  std::vector<float> values;
};

/// The same place seen from another world: x and y turned over between lps and ras. An unknown world is that
/// of the other.
ImageInfo in_world(ImageInfo info, WorldAxes world);
/// The same voxels with their axes as the columns of `direction` (rows of a matrix), in another order and
/// direction: exact copies. As it is where no such order exists.
ImageInfo along_axes(const ImageInfo& info, const std::array<Vec3, 3>& direction);
Image along_axes(Image image, const std::array<Vec3, 3>& direction);

/// Values within 1e-5 of a whole number (of its size, above 1) become that number. @return how many did
std::int64_t round_labels(std::span<float> values);

/// What a reader found doubtful in a file, and what it took: `FILE: text`. Kept for the process, each once.
void warn_of_file(const std::filesystem::path& file, const std::string& text);
/// All of them, in their order. @param only_new those that no call has returned yet
std::vector<std::string> file_warnings(bool only_new = false);

/// Limits that a reader keeps to, so that a lying header or a decompression bomb costs nothing.
struct ImageLimits {
  std::int64_t largest_bytes = 0; ///< of the decoded image; 0: half of the memory that the machine has free
};

/// Reads the header only (and, of an .mhd, looks whether its data file is there).
/// @throws InputError
ImageInfo read_image_info(const std::filesystem::path& file);

/// Reads the image. What counts is the ending of its name: .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr or .vti.
/// Lengths are millimetres unless the header says otherwise: NIfTI's xyzt_units, MetaImage's DistanceUnits,
/// NRRD's space units, and in .vti a FieldData string array `Units` whose first word, or the word after
/// `length` or `lengths`, is `m`.
///
/// - NIfTI-1 and -2: both byte orders, 8 to 64 bits, float32, float64; sform, else qform, else pixdim.
/// - MetaImage: two or three axes; data behind the header or in one file in its folder or below; zlib or not.
/// - NRRD: versions 1 to 5; raw or gzip; data behind the header or in one file in its folder or below; an
///   axis of components before or behind those of space.
/// - vti: one piece; ascii, base64 or raw, inline or appended, zlib or not. The values are the active
///   Scalars, of cells or points, else the only array.
///
/// Cost        linear in the voxels; memory up to twice that of the values, no faster than the file fills it
/// @throws InputError: missing, unknown format, truncated, inconsistent, or larger than `limits` (checked
///         from the header, before anything is allocated; the message has the number of bytes); axes sheared
///         by more than 1e-3 without a qform beside them, integers that float32 does not hold exactly. A
///         fault's key is the header's field, its line 0. Bytes behind the data are left with a warning.
Image read_image(const std::filesystem::path& file, const ImageLimits& limits = {});

/// Whether a file's name ends as an image's does.
bool has_image_ending(const std::filesystem::path& file);

/// Spacing, place and orientation of an array's voxels by rows of a matrix [m], by the rules for files.
/// @return its faults, under `key`
std::vector<Fault> set_affine(ImageInfo& info, const std::array<std::array<double, 4>, 4>& affine,
                              const std::string& key);

/// The files whose bytes read_image would read: the file itself and, where a MetaImage's header names another
/// one for its data, that one. Only the header is read; of a file that is no sound image the list holds the
/// file alone.
std::vector<std::filesystem::path> files_of_image(const std::filesystem::path& file);

/// What a segmentation of 3D Slicer (.seg.nrrd) calls its labels.
struct NamedSegment {
  std::string name;
  std::int32_t label = 1;
  int layer = 0; ///< of several that overlap; the image has a component each
};

/// In the file's order; empty if the file is no NRRD, or names no segment.
/// @throws InputError  the NRRD header is faulty
std::vector<NamedSegment> named_segments(const std::filesystem::path& file);

/// Arrays of a file that write_vtk wrote (.vti, .vtu).
struct VtkArrays {
  std::int64_t points = 0;
  std::map<std::string, std::vector<double>> at_nodes; ///< by name; empty where the file has none
  std::vector<double> layers;                          ///< the array `Layers` beside the grid
  std::string units;                                   ///< the text `Units` beside it
};
/// Memory follows the file and `nodes`, as many as its grid is to have.
/// @throws InputError: damaged, cut short
VtkArrays read_vtk_arrays(const std::filesystem::path& file, const std::vector<std::string>& names,
                          std::int64_t nodes);

} // namespace maille
