#pragma once
/// Voxel images: NIfTI-1 and NIfTI-2 (.nii, .nii.gz), MetaImage (.mha, .mhd), NRRD (.nrrd, .nhdr), VTK
/// (.vti) and series of DICOM files.
///
/// Every reader returns the same Image: float32 values and an affine map from voxel indices to one world, RAS
/// or LPS as the format defines. If a header is incomplete or contradicts itself, the documented fallback
/// applies, and warn_of_file reports it.

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

/// Header of an image. Values are converted to float32 on reading (exact for labels up to 2^24). Voxels are
/// numbered x fastest. Positions are those of voxel *centres*, in metres, in the world frame that the file
/// states (NIfTI: RAS; MetaImage, NRRD, vti: as in the file), with the orientation of the header: world =
/// origin + direction (spacing .* index), the columns of direction orthonormal.
struct ImageInfo {
  Index3 size{1, 1, 1};
  int components = 1;    ///< values per voxel (a fourth or fifth NIfTI axis counts as components)
  Vec3 spacing{1, 1, 1}; ///< [m]
  Vec3 origin{0, 0, 0};  ///< centre of voxel 0 [m]
  std::array<Vec3, 3> direction{
      {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows of the matrix image axes -> world
  /// NIfTI: ras; DICOM: lps; MetaImage with AnatomicalOrientation, as ITK writes it: lps; NRRD: from `space`
  /// (left-anterior-superior is read as ras, with x reversed). A file without a statement is lps, as in ITK.
  WorldAxes world = WorldAxes::unknown;
  bool states_world = true; ///< false: `world` is the fallback
  /// Rows of the matrix from the frame of the file's vectors and tensors to the world, if the header states
  /// it: NIfTI's intents 1006 (RAS) and 1007 (LPS, as ITK writes it), NRRD's space and measurement frame.
  std::optional<std::array<Vec3, 3>> vectors_to_world{};
  std::int64_t n_voxels() const { return std::int64_t{1} * size[0] * size[1] * size[2]; }
};

struct Image {
  ImageInfo info;
  /// n_voxels x components, component slowest (planar), scaled by NIfTI's slope and intercept. NaN and
  /// infinities are kept.
  std::vector<float> values;
};

/// The same image in another world: x and y change sign between lps and ras. An unknown world equals the
/// other.
ImageInfo in_world(ImageInfo info, WorldAxes world);
/// The same voxels with axes permuted and reversed to match the columns of `direction` (rows of a matrix):
/// exact copies. Unchanged if no such order exists.
ImageInfo along_axes(const ImageInfo& info, const std::array<Vec3, 3>& direction);
Image along_axes(Image image, const std::array<Vec3, 3>& direction);

/// Rounds values within 1e-5 of a whole number (relative, above 1). @return number of rounded values
std::int64_t round_labels(std::span<float> values);

/// Reports a doubtful property of a file and the fallback: `FILE: text`. Stored for the process, each once.
void warn_of_file(const std::filesystem::path& file, const std::string& text);
/// All warnings, in order. @param only_new only those that no call has returned yet
std::vector<std::string> file_warnings(bool only_new = false);

/// Limits of a reader, which protect against wrong headers and decompression bombs.
struct ImageLimits {
  std::int64_t largest_bytes = 0; ///< of the decoded image; 0: half of the machine's free memory
};

/// Reads the header only (and, for an .mhd, checks that its data file exists).
/// @throws InputError
ImageInfo read_image_info(const std::filesystem::path& file);

/// Reads the image. The file name ending decides the format: .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr or .vti.
/// Lengths are millimetres unless the header says otherwise: NIfTI's xyzt_units, MetaImage's DistanceUnits,
/// NRRD's space units, and in .vti a FieldData string array `Units` whose first word, or the word after
/// `length` or `lengths`, is `m`.
///
/// - NIfTI-1 and -2: both byte orders, 8 to 64 bits, float32, float64; sform, else qform, else pixdim.
/// - MetaImage: two or three axes; data after the header or in one file in its folder or below; zlib or not.
/// - NRRD: versions 1 to 5; raw or gzip; data after the header or in one file in its folder or below; an
///   axis of components before or after the spatial ones.
/// - vti: one piece; ascii, base64 or raw, inline or appended, zlib or not. The values are the active
///   Scalars, of cells or points, else the only array.
///
/// Cost        linear in the voxels; memory up to twice that of the values, allocated as the file fills it
/// @throws InputError: missing, unknown format, truncated, inconsistent, or larger than `limits` (checked
///         from the header before allocation; the message has the number of bytes); axes sheared by more
///         than 1e-3 without a qform, integers that float32 does not hold exactly. The key of a fault is the
///         header's field, its line 0. Extra bytes after the data cause a warning.
Image read_image(const std::filesystem::path& file, const ImageLimits& limits = {});

/// True if a file's name has the ending of an image.
bool has_image_ending(const std::filesystem::path& file);

/// Sets spacing, position and orientation from rows of a matrix [m], by the rules for files.
/// @return its faults, under `key`
std::vector<Fault> set_affine(ImageInfo& info, const std::array<std::array<double, 4>, 4>& affine,
                              const std::string& key);

/// The files that read_image would read: the file itself and the separate data file of a MetaImage, if any.
/// Only the header is read; for an invalid image the list has only the file itself.
std::vector<std::filesystem::path> files_of_image(const std::filesystem::path& file);

/// Name and label of a segment in a segmentation of 3D Slicer (.seg.nrrd).
struct NamedSegment {
  std::string name;
  std::int32_t label = 1;
  int layer = 0; ///< for overlapping segments: component of the image
};

/// Segments in file order; empty if the file is no NRRD, or names no segment.
/// @throws InputError  the NRRD header is faulty
std::vector<NamedSegment> named_segments(const std::filesystem::path& file);

/// Arrays of a file written by write_vtk (.vti, .vtu).
struct VtkArrays {
  std::int64_t points = 0;
  std::map<std::string, std::vector<double>> at_nodes; ///< by name; empty if the file lacks it
  std::vector<double> layers;                          ///< the array `Layers` beside the grid
  std::string units;                                   ///< the text `Units` beside it
};
/// Memory scales with the file and with `nodes`, the expected number of nodes.
/// @throws InputError: damaged, cut short
VtkArrays read_vtk_arrays(const std::filesystem::path& file, const std::vector<std::string>& names,
                          std::int64_t nodes);

} // namespace maille
