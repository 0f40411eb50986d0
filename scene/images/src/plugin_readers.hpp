#pragma once
/// What is asked of files that other libraries read, in shared objects that are opened when the first such
/// file is read: DICOM series by GDCM, image data by VTK. Private to images and to these objects.

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

/// The other shared object, on VTK. None of it throws; files are read in a process of their own.
struct VtkReaders {
  /// The element ImageData as XML, without data, and the text of the array `Units` beside the grid.
  /// @return what VTK says is wrong, or nothing
  std::string (*header)(const std::string& file, std::string& xml, std::string& units);
  /// The values of an array of CellData or PointData, which must have `n_values`: a function that fills a
  /// span with the next bytes, as this machine has them, and says what is wrong, or nothing.
  std::function<std::string(std::span<char>)> (*values)(const std::string& file, bool of_cells,
                                                        const std::string& name, std::int64_t n_values);
  /// As read_vtk_arrays. @return what is wrong, or nothing
  std::string (*arrays)(const std::string& file, const std::vector<std::string>& names, std::int64_t nodes,
                        VtkArrays& arrays);
};

inline constexpr std::size_t vtk_readers_layout = layout_of<VtkReaders, VtkArrays>();

/// The functions of a shared object. @throws InputError where it cannot be opened
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
