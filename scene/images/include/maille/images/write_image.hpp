#pragma once
/// Images in files that medical programs read: NIfTI-1, MetaImage and NRRD.

#include "maille/images/image.hpp"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace maille {

/// How values stand in a file.
enum class StoredAs {
  float32,
  labels,  ///< whole numbers, in the smallest of uint8, int16 and int32 that holds them all
  tensors, ///< float32, six components a voxel of a symmetric matrix, xx yy zz xy xz yz
};

struct ImageFileOptions {
  StoredAs stored_as = StoredAs::float32;
  /// `key:=value` lines, of NRRD alone: `{"displacement field type", "modeling"}`.
  std::vector<std::pair<std::string, std::string>> nrrd_keys;
};

/// Writes what the ending of the name says: .nii, .nii.gz, .mha or .nrrd; lengths in millimetres.
///
/// The world is a patient's. NIfTI states it as RAS, MetaImage and NRRD as LPS, so that all three show the
/// same voxels in the same place; where an image does not say (WorldAxes::unknown) it is taken as RAS. Values
/// are as they are: vectors that are to stand along LPS must be so before. Three components are a vector
/// (NIfTI: where info says along what; interleaved in the other two).
///
/// @throws std::runtime_error  the file cannot be written; std::invalid_argument  another ending, values
///         that do not fit the grid, labels that are no whole numbers, or more than NIfTI-1 holds
void write_image(const Image& image, const std::filesystem::path& file, const ImageFileOptions& options = {});

/// Values as a file has them: tensors where its header states them, else float32.
StoredAs stored_form(const std::filesystem::path& file);

/// @brief Writes NIfTI-1, gzipped where the name ends in .gz, with sform and qform in millimetres.
///
/// The world is a patient's, right, anterior, superior: of an image whose world is that of ITK (lps) x and y
/// are turned round. Three components along RAS or LPS are a vector (intent 1006, 1007), tensors a symmetric
/// matrix (intent 1005) in the order that NIfTI has, xx xy yy xz yz zz; others are plain.
///
/// @throws std::runtime_error  the file cannot be written; std::invalid_argument  more than 32767 voxels
///         along an axis, or values that do not fit the grid
void write_nifti(const Image& image, const std::filesystem::path& file,
                 StoredAs stored_as = StoredAs::float32);

} // namespace maille
