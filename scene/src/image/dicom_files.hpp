#pragma once
/// What is asked of a DICOM file, and how it is got: by a shared object that stands on GDCM, opened when the
/// first series is read. Private to scene and to that object.

#include "maille/plugins/open_plugin.hpp"
#include "maille/scene/grid.hpp"

#include <array>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace maille::image_formats {

/// The header of a file. Lengths in mm, along left, posterior, superior.
struct DicomHeader {
  bool is_dicom = false;   ///< all else is empty where not
  bool is_damaged = false; ///< begins as DICOM does, and cannot be read
  std::string series;      ///< SeriesInstanceUID
  std::string series_name, modality, transfer_syntax, image_type;
  int columns = 0, rows = 0, frames = 1, samples = 1; ///< x, y, slices and values a pixel
  bool has_position = false, has_orientation = false, has_spacing = false;
  Vec3 position{};                 ///< ImagePositionPatient: of the first pixel's middle
  std::array<Vec3, 2> along{};     ///< ImageOrientationPatient: of a row, of a column
  double row_spacing = 0;          ///< between rows, PixelSpacing's first
  double column_spacing = 0;       ///< between columns
  double thickness = 0;            ///< SpacingBetweenSlices, else SliceThickness; 0: not said
  double slope = 1, intercept = 0; ///< RescaleSlope, RescaleIntercept
};

/// What the shared object offers. None of it throws. GDCM of Debian ends the process at a damaged file (its
/// assertions are on), so that files are read in a process of their own: what ends that one is a fault.
struct DicomFunctions {
  /// Headers of the files; `is_dicom` is false for other files, `is_damaged` true where reading failed.
  std::vector<DicomHeader> (*headers)(const std::vector<std::string>& files);
  /// Stored values of one slice, row by row, not rescaled. @return what is wrong, or nothing
  std::string (*pixels)(const std::string& file, std::vector<double>& values);
};

inline constexpr std::size_t dicom_layout = layout_of<DicomFunctions, DicomHeader>();

} // namespace maille::image_formats
