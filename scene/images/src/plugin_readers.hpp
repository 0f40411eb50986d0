#pragma once
/// Interface to the shared objects that read files with other libraries and are opened at first use: DICOM
/// series by GDCM, image data by VTK. Private to images and to these objects.

#include "image_formats.hpp"
#include "maille/plugins/open_plugin.hpp"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace maille::image_formats {

/// The header of a file. Lengths in mm, along left, posterior, superior.
struct DicomHeader {
  bool is_dicom = false;   ///< false: all else is empty
  bool is_damaged = false; ///< begins as DICOM, but is unreadable
  std::string series;      ///< SeriesInstanceUID
  std::string series_name, modality, transfer_syntax, image_type;
  int columns = 0, rows = 0, frames = 1, samples = 1; ///< x, y, slices, and values per pixel
  bool has_position = false, has_orientation = false, has_spacing = false;
  Vec3 position{};                 ///< ImagePositionPatient: centre of the first pixel
  std::array<Vec3, 2> along{};     ///< ImageOrientationPatient: direction of a row, of a column
  double row_spacing = 0;          ///< between rows, PixelSpacing's first
  double column_spacing = 0;       ///< between columns
  double thickness = 0;            ///< SpacingBetweenSlices, else SliceThickness; 0: not stated
  double slope = 1, intercept = 0; ///< RescaleSlope, RescaleIntercept
};

/// Functions of the shared object; none throws. Debian's GDCM aborts on a damaged file (assertions are
/// enabled), so files are read in a separate process; its abort becomes a fault.
struct DicomFunctions {
  /// Headers of the files; `is_dicom` is false for other files, `is_damaged` true if reading failed.
  std::vector<DicomHeader> (*headers)(const std::vector<std::string>& files);
  /// Stored values of one slice, row by row, not rescaled. @return error message, or empty
  std::string (*pixels)(const std::string& file, std::vector<double>& values);
};

inline constexpr std::size_t dicom_layout = layout_of<DicomFunctions, DicomHeader>();

/// Functions of the shared object with VTK; none throws. Files are read in a separate process.
struct VtkReaders {
  /// The element ImageData as XML, without data, and the text of the array `Units` beside the grid.
  /// @return VTK's error message, or empty
  std::string (*header)(const std::string& file, std::string& xml, std::string& units);
  /// The values of an array of CellData or PointData, which must have `n_values`: a function that fills a
  /// span with the next bytes, in this machine's byte order, and returns an error message, or empty.
  std::function<std::string(std::span<char>)> (*values)(const std::string& file, bool of_cells,
                                                        const std::string& name, std::int64_t n_values);
  /// As read_vtk_arrays. @return error message, or empty
  std::string (*arrays)(const std::string& file, const std::vector<std::string>& names, std::int64_t nodes,
                        VtkArrays& arrays);
};

inline constexpr std::size_t vtk_readers_layout = layout_of<VtkReaders, VtkArrays>();

/// The functions of a shared object. @throws InputError if it cannot be opened
template<class Functions>
const Functions& opened(const char* file, const char* what, const char* package, std::size_t layout,
                        Faults& faults) {
  static const Functions* functions = nullptr;
  static std::mutex opening;
  const std::scoped_lock lock(opening);
  try {
    if (functions == nullptr)
      functions = static_cast<const Functions*>(open_plugin(file, what, layout));
  } catch (const std::runtime_error& error) {
    faults.fail(
        "", fmt::format("a build that reads {} (Debian's {}, found as Maille was configured)", what, package),
        error.what());
  }
  return *functions;
}

} // namespace maille::image_formats
