// Reads a series of DICOM files, one slice each: groups and orders the slices, and detects missing ones.
//
// Source: DICOM PS3.3, C.7.6.2 Image Plane Module: ImagePositionPatient is the middle of the first pixel,
// ImageOrientationPatient the directions of a row and of a column, in mm along left, posterior, superior;
// PixelSpacing is between rows, then between columns. File names, InstanceNumber and SliceLocation are not
// used: slices are ordered by position. Departures: several slices in one file (enhanced multi-frame),
// colours and tilted gantries are refused with a specific message.

#include "maille/base/vectors.hpp"
#include "maille/materials/text_file.hpp"
#include "plugin_readers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <string_view>
#include <system_error>

namespace maille::image_formats {
namespace {

namespace fs = std::filesystem;

constexpr double largest_turn = 1e-4;   ///< of directions, between slices of a series
constexpr double largest_uneven = 0.01; ///< of distances, over the distance
constexpr int most_named = 4;           ///< files that a message names

struct Slice {
  fs::path file;
  DicomHeader header;
  double along_normal = 0; ///< [mm]
};

std::string name_of(const Slice& slice) {
  return slice.file.filename().string();
}

std::vector<fs::path> regular_files(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none))
    if (entry.is_regular_file(none))
      files.push_back(entry.path());
  std::ranges::sort(files);
  return files;
}

/// Content of a folder without a series, for a message.
std::string found_instead(const fs::path& folder) {
  std::error_code none;
  std::size_t n_images = 0;
  constexpr int deepest = 3, most_entries = 10'000;
  int n_entries = 0;
  for (fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, none), end;
       at != end && ++n_entries <= most_entries; at.increment(none)) {
    if (at.depth() >= deepest)
      at.disable_recursion_pending();
    const std::string name = at->path().filename().string();
    n_images += name.ends_with(".nii.gz") || name.ends_with(".nii") || name.ends_with(".nrrd") ? 1 : 0;
    if (at->is_regular_file(none) && is_dicom(at->path()))
      return "none in it, but in " + in_quotes(at->path().parent_path().string());
  }
  return n_images == 0 ? "no DICOM image in it"
                       : fmt::format("{} image{} of another format: give one image that holds all labels, "
                                     "not a mask for each structure",
                                     n_images, n_images == 1 ? "" : "s");
}

/// The slices of one series: all of a folder, which must be one series; or the series of a file, in its
/// folder.
std::vector<Slice> slices_of(const fs::path& place, const DicomFunctions& gdcm, Faults& faults) {
  std::error_code none;
  const bool is_folder = fs::is_directory(place, none);
  const std::vector<fs::path> files = files_of_dicom(place);
  std::vector<std::string> names;
  for (const fs::path& file : files)
    names.push_back(file.string());
  std::vector<DicomHeader> headers = gdcm.headers(names);
  for (std::size_t n = 0; n < files.size(); ++n)
    if (headers[n].is_damaged)
      faults.add("", "DICOM files that can be read",
                 files[n].filename().string() + ", which is damaged or cut short");
  faults.throw_if_any();
  for (std::size_t n = 0; n < files.size(); ++n)
    if (headers[n].is_dicom) // other files in the folder are ignored
      note_opened(files[n]);
  std::string wanted;
  for (std::size_t n = 0; n < files.size(); ++n)
    if (!is_folder && files[n].filename() == place.filename())
      wanted = headers[n].series;
  std::map<std::string, std::vector<Slice>> series;
  for (std::size_t n = 0; n < files.size(); ++n)
    if (headers[n].is_dicom && headers[n].rows > 0 && (is_folder || headers[n].series == wanted))
      series[headers[n].series].push_back({files[n], std::move(headers[n])});
  if (series.empty())
    faults.fail("", "a folder with the DICOM files of a series",
                is_folder ? found_instead(place) : "no DICOM image in it");
  if (series.size() > 1) {
    std::string found;
    for (const auto& [uid, slices] : series)
      found += fmt::format("{}{} of {} ({}{}), as {} is", found.empty() ? "" : "; ", slices.size(),
                           in_quotes(uid), slices.front().header.modality,
                           slices.front().header.series_name.empty()
                               ? ""
                               : ", " + in_quotes(slices.front().header.series_name),
                           name_of(slices.front()));
    faults.fail("SeriesInstanceUID", "one series; of several name a file of the one that is meant", found);
  }
  return std::move(series.begin()->second);
}

/// Checks each slice, and that all are consistent.
void check_slices(const std::vector<Slice>& slices, Faults& faults) {
  const auto refuse = [&](const char* key, const std::string& expected, const auto& is_wrong,
                          const auto& found) {
    int n_wrong = 0;
    std::string names;
    for (const Slice& slice : slices)
      if (is_wrong(slice.header) && ++n_wrong <= most_named)
        names += fmt::format("{}{}{}", names.empty() ? "" : ", ", name_of(slice), found(slice.header));
    if (n_wrong > 0)
      faults.add(key, expected,
                 names + (n_wrong > most_named ? fmt::format(" and {} more", n_wrong - most_named) : ""));
  };
  const DicomHeader& first = slices.front().header;
  if (first.modality == "SEG")
    faults.fail(
        "Modality", "slices of an image",
        "SEG, a segmentation object: dcmqi's segimage2itkimage or 3D Slicer make it an image of labels");
  if (first.image_type.find("MOSAIC") != std::string::npos)
    faults.fail("ImageType", "a slice a file",
                "MOSAIC, many slices as tiles of one: dcm2niix makes it NIfTI");
  refuse(
      "NumberOfFrames", "one slice a file (of enhanced files dcm2niix makes NIfTI)",
      [](const DicomHeader& h) { return h.frames != 1; },
      [](const DicomHeader& h) { return fmt::format(": {}", h.frames); });
  refuse(
      "SamplesPerPixel", "1, grey values", [](const DicomHeader& h) { return h.samples != 1; },
      [](const DicomHeader& h) { return fmt::format(": {}", h.samples); });
  refuse(
      "ImagePositionPatient", "three finite numbers",
      [](const DicomHeader& h) {
        return !h.has_position || !std::ranges::all_of(h.position, [](double x) { return std::isfinite(x); });
      },
      [](const DicomHeader&) { return ""; });
  refuse(
      "ImageOrientationPatient", fmt::format("that of {}", name_of(slices.front())),
      [&](const DicomHeader& h) {
        return !h.has_orientation || !(distance(h.along[0], first.along[0]) <= largest_turn) ||
               !(distance(h.along[1], first.along[1]) <= largest_turn);
      },
      [](const DicomHeader&) { return ""; });
  refuse(
      "PixelSpacing",
      fmt::format("{} {} mm, as of {}", first.row_spacing, first.column_spacing, name_of(slices.front())),
      [&](const DicomHeader& h) {
        return !h.has_spacing || !(std::abs(h.row_spacing - first.row_spacing) <= 1e-4 * first.row_spacing) ||
               !(std::abs(h.column_spacing - first.column_spacing) <= 1e-4 * first.column_spacing);
      },
      [](const DicomHeader& h) { return fmt::format(": {} {}", h.row_spacing, h.column_spacing); });
  refuse(
      "Rows", fmt::format("{} x {} pixels, as of {}", first.columns, first.rows, name_of(slices.front())),
      [&](const DicomHeader& h) { return h.rows != first.rows || h.columns != first.columns; },
      [](const DicomHeader& h) { return fmt::format(": {} x {}", h.columns, h.rows); });
  refuse(
      "RescaleSlope", "a finite slope and intercept",
      [](const DicomHeader& h) { return !std::isfinite(h.slope) || !std::isfinite(h.intercept); },
      [](const DicomHeader&) { return ""; });
  faults.throw_if_any();
}

/// Distance of successive slices [mm]; reports missing, duplicate and shifted ones.
double slice_distance(const std::vector<Slice>& slices, const Vec3& normal, Faults& faults) {
  if (slices.size() == 1) {
    const double thickness = slices.front().header.thickness;
    if (!(std::isfinite(thickness) && thickness > 0))
      faults.fail("SliceThickness", "that of a single slice, > 0", fmt::format("{}", thickness));
    return thickness;
  }
  std::vector<double> steps;
  for (std::size_t n = 1; n < slices.size(); ++n)
    steps.push_back(slices[n].along_normal - slices[n - 1].along_normal);
  std::vector<double> sorted = steps;
  std::ranges::sort(sorted);
  const double usual = sorted[sorted.size() / 2];
  for (std::size_t n = 1; n < slices.size(); ++n) {
    const double step = steps[n - 1];
    const auto between = [&] { return fmt::format("{} and {}", name_of(slices[n - 1]), name_of(slices[n])); };
    if (!(step > 1e-3)) {
      faults.add("ImagePositionPatient", "one slice at every place", between() + " at the same");
      continue;
    }
    if (!(std::abs(step - usual) <= largest_uneven * usual)) {
      const double missing = step / usual - 1;
      const bool are_missing =
          missing > 0.5 && std::abs(missing - std::round(missing)) <= largest_uneven * step / usual;
      faults.add("ImagePositionPatient", fmt::format("slices {:.4g} mm apart", usual),
                 fmt::format("{:.4g} mm between {}{}", step, between(),
                             are_missing ? fmt::format(": {:.0f} missing", missing) : ""));
    }
    const Vec3 straight = plus(slices[n - 1].header.position, times(step, normal));
    if (const double aside = distance(straight, slices[n].header.position); !(aside <= 1e-3 * step + 1e-2))
      faults.add("ImagePositionPatient", "slices straight behind each other (no tilted gantry)",
                 fmt::format("{} {:.3g} mm aside", between(), aside));
  }
  faults.throw_if_any();
  return (slices.back().along_normal - slices.front().along_normal) / static_cast<double>(slices.size() - 1);
}

/// Values of slices, one file after the other, as float32.
class SliceSource : public ByteSource {
public:
  SliceSource(std::vector<Slice> slices, const DicomFunctions& gdcm, Faults faults)
      : slices_(std::move(slices)), gdcm_(gdcm), faults_(std::move(faults)) {}
  std::size_t read(std::span<char> to) override {
    std::size_t done = 0;
    while (done < to.size() && (at_ < bytes_.size() || next())) {
      const std::size_t count = std::min(to.size() - done, bytes_.size() - at_);
      std::memcpy(to.data() + done, bytes_.data() + at_, count);
      done += count;
      at_ += count;
    }
    return done;
  }

private:
  bool next() {
    if (slice_ == slices_.size())
      return false;
    const auto& [file, header, place] = slices_[slice_++];
    std::vector<double> values;
    const std::string fault = gdcm_.pixels(file.string(), values);
    if (!fault.empty())
      faults_.fail("PixelData", "pixels that can be read, in " + file.filename().string(),
                   fmt::format("{} ({})", fault, header.transfer_syntax));
    const std::size_t n = static_cast<std::size_t>(header.rows) * static_cast<std::size_t>(header.columns);
    if (values.size() != n)
      faults_.fail("PixelData", fmt::format("{} pixels in {}", n, file.filename().string()),
                   fmt::format("{}", values.size()));
    std::vector<float> scaled(n);
    for (std::size_t i = 0; i < n; ++i)
      scaled[i] = static_cast<float>(values[i] * header.slope + header.intercept);
    bytes_.resize(n * sizeof(float));
    std::memcpy(bytes_.data(), scaled.data(), bytes_.size());
    at_ = 0;
    return n > 0;
  }

  std::vector<Slice> slices_;
  const DicomFunctions& gdcm_;
  Faults faults_;
  std::size_t slice_ = 0, at_ = 0;
  std::vector<char> bytes_;
};

} // namespace

bool is_dicom(const fs::path& place) {
  std::error_code none;
  if (fs::is_directory(place, none))
    return true;
  if (!fs::is_regular_file(place, none))
    return false;
  std::array<char, 132> bytes{};
  std::ifstream stream(place, std::ios::binary);
  return stream.read(bytes.data(), bytes.size()) && std::string_view(bytes.data() + 128, 4) == "DICM";
}

OpenImage open_dicom(const fs::path& place, Faults& faults) {
  const auto* const gdcm =
      &opened<DicomFunctions>("maille-dicom.so", "DICOM series (GDCM)", "libgdcm-dev", dicom_layout, faults);
  std::vector<Slice> slices = slices_of(place, *gdcm, faults);
  check_slices(slices, faults);
  const DicomHeader& first = slices.front().header;
  const Vec3 normal = cross(first.along[0], first.along[1]);
  for (Slice& slice : slices)
    slice.along_normal = dot(slice.header.position, normal);
  std::ranges::stable_sort(slices, {}, &Slice::along_normal);

  OpenImage image;
  image.size_key = "Rows";
  FileGeometry geometry;
  geometry.spacing = {first.column_spacing, first.row_spacing, slice_distance(slices, normal, faults)};
  geometry.origin = slices.front().header.position;
  for (std::size_t row = 0; row < 3; ++row)
    geometry.direction[row] = {first.along[0][row], first.along[1][row], normal[row]};
  geometry.spacing_keys = {"PixelSpacing", "PixelSpacing", "ImagePositionPatient"};
  geometry.origin_key = "ImagePositionPatient";
  geometry.direction_key = "ImageOrientationPatient";
  set_size(image.info, {first.columns, first.rows, static_cast<std::int64_t>(slices.size())},
           {"Columns", "Rows", "Rows"}, 1, "SamplesPerPixel", faults);
  geometry.world = WorldAxes::lps;
  set_geometry(image.info, geometry, faults);
  faults.throw_if_any();
  image.layout.type = ScalarType::float32;
  image.open_data = [slices = std::move(slices), gdcm, faults] {
    return std::make_shared<SliceSource>(slices, *gdcm, faults);
  };
  return image;
}

std::vector<fs::path> files_of_dicom(const fs::path& place) {
  std::error_code none;
  const bool is_folder = fs::is_directory(place, none);
  std::vector<fs::path> files = regular_files(is_folder                     ? place
                                              : place.parent_path().empty() ? "."
                                                                            : place.parent_path());
  if (files.empty())
    files.push_back(place);
  return files;
}

} // namespace maille::image_formats
