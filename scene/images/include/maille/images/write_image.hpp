#pragma once
/// Writes images in formats of medical programs: NIfTI-1, MetaImage and NRRD.

#include "maille/images/image.hpp"

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace maille {

/// Type of the values in a file.
enum class StoredAs {
  float32,
  labels,  ///< whole numbers, in the smallest of uint8, int16 and int32 that holds them all
  tensors, ///< float32, six components per voxel of a symmetric matrix, xx yy zz xy xz yz
};

struct ImageFileOptions {
  StoredAs stored_as = StoredAs::float32;
  /// `key:=value` lines, for NRRD only: `{"displacement field type", "modeling"}`.
  std::vector<std::pair<std::string, std::string>> nrrd_keys;
};

/// Writes the format of the file name ending: .nii, .nii.gz, .mha or .nrrd; lengths in millimetres.
///
/// The world is a patient's. NIfTI states it as RAS, MetaImage and NRRD as LPS, so that all three show the
/// same voxels in the same place; an unknown world (WorldAxes::unknown) is taken as RAS. Values are
/// unchanged: vectors along LPS must be converted before. Three components are a vector (NIfTI: if info
/// states its axes; interleaved in the other two).
///
/// @throws std::runtime_error  the file cannot be written; std::invalid_argument  another ending, values
///         that do not fit the grid, labels that are no whole numbers, or more than NIfTI-1 holds
void write_image(const Image& image, const std::filesystem::path& file, const ImageFileOptions& options = {});

/// Type of the values in a file: tensors if its header states them, else float32.
StoredAs stored_form(const std::filesystem::path& file);

/// @brief Writes NIfTI-1, gzipped if the name ends in .gz, with sform and qform in millimetres.
///
/// The world is a patient's, right, anterior, superior: for an image in the world of ITK (lps) x and y change
/// sign. Three components along RAS or LPS are a vector (intent 1006, 1007), tensors a symmetric matrix
/// (intent 1005) in the order of NIfTI, xx xy yy xz yz zz; others are plain.
///
/// @throws std::runtime_error  the file cannot be written; std::invalid_argument  more than 32767 voxels
///         along an axis, or values that do not fit the grid
void write_nifti(const Image& image, const std::filesystem::path& file,
                 StoredAs stored_as = StoredAs::float32);

} // namespace maille
