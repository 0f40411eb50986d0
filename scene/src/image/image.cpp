// Which reader takes a file, what it may cost, and the geometry that all readers share.

#include "maille/scene/image.hpp"
#include "maille/scene/memory.hpp"

#include "image/image_formats.hpp"
#include "image/layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {
namespace image_formats {
namespace {

constexpr double largest_shear = 1e-3;

/// Dot product of two columns.
double dot(const std::array<Vec3, 3>& rows, std::size_t a, std::size_t b) {
  return rows[0][a] * rows[0][b] + rows[1][a] * rows[1][b] + rows[2][a] * rows[2][b];
}

/// The rotation (or rotary reflection) next to a nearly orthonormal matrix, by A <- A (3 I - A^T A) / 2.
/// Source: Björck and Bowie 1971, SIAM J. Numer. Anal. 8, the iteration of order two. It treats all axes
/// alike, unlike Gram-Schmidt, and leaves an orthonormal matrix as it is.
std::array<Vec3, 3> nearest_orthonormal(std::array<Vec3, 3> rows) {
  for (int step = 0; step < 4; ++step) { // 1e-3 off -> 1e-6 -> 1e-12 -> rounding
    const std::array<Vec3, 3> before = rows;
    for (std::size_t row = 0; row < 3; ++row)
      for (std::size_t column = 0; column < 3; ++column) {
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k)
          sum += before[row][k] * dot(before, k, column);
        rows[row][column] = 1.5 * before[row][column] - 0.5 * sum;
      }
  }
  return rows;
}

std::string text_of(const std::array<Vec3, 3>& rows) {
  std::string text;
  for (const Vec3& row : rows)
    text += fmt::format("{}{} {} {}", text.empty() ? "" : "; ", row[0], row[1], row[2]);
  return text;
}

bool is_direction(const FileGeometry& geometry, Faults& faults) {
  const auto& rows = geometry.direction;
  const std::string& key = geometry.direction_key;
  double largest_cosine = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const double length = std::sqrt(dot(rows, a, a));
    if (!(std::abs(length - 1) <= largest_shear)) {
      faults.add(key, "axes of length 1 (finite, not singular)", "rows " + text_of(rows));
      return false;
    }
    for (std::size_t b = 0; b < a; ++b)
      largest_cosine = std::max(largest_cosine, std::abs(dot(rows, a, b)));
  }
  if (largest_cosine > largest_shear)
    faults.add(key,
               fmt::format("perpendicular axes: sheared ones span no grid (cosines up to {})", largest_shear),
               fmt::format("a cosine of {:.6g} in rows {}", largest_cosine, text_of(rows)));
  return largest_cosine <= largest_shear;
}

std::string ending_of(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char character) { return static_cast<char>(std::tolower(character)); });
  for (const char* ending : {".nii.gz", ".nii", ".mha", ".mhd", ".nrrd", ".nhdr", ".vti"})
    if (name.ends_with(ending))
      return ending;
  return {};
}

OpenImage open_image(const std::filesystem::path& file, std::int64_t largest, Faults& faults) {
  const std::string ending = ending_of(file);
  if (ending.empty() && is_dicom(file))
    return open_dicom(file, faults);
  if (ending.empty())
    faults.fail("",
                "a file that ends in .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr or .vti, or a folder of DICOM "
                "files",
                std::filesystem::exists(file) ? in_quotes(file.filename().string()) : "nothing of that name");
  if (ending == ".vti")
    return open_vti(file, largest, faults);
  if (ending == ".mha" || ending == ".mhd")
    return open_meta_image(file, faults);
  if (ending == ".nrrd" || ending == ".nhdr")
    return open_nrrd(file, faults);
  return open_nifti(file, ending == ".nii.gz", faults);
}

/// A fault where so many layers of the decoded image are more than the limits allow.
void check_memory(const OpenImage& image, int layers, const ImageLimits& limits, Faults& faults) {
  const ImageInfo& info = image.info;
  const std::int64_t largest = largest_bytes(limits);
  const std::int64_t bytes =
      std::int64_t{info.size[0]} * info.size[1] * layers * info.components * std::int64_t{sizeof(float)};
  if (bytes > largest)
    faults.fail(image.size_key,
                fmt::format("at most {} bytes in memory{}", largest,
                            limits.largest_bytes > 0 ? "" : " (half of what is free)"),
                fmt::format("{} bytes ({} x {} x {} voxels, {} values each, as float32)", bytes, info.size[0],
                            info.size[1], layers, info.components));
}

} // namespace

void Faults::add(std::string key, std::string expected, std::string found) {
  faults_.push_back({file_, 0, std::move(key), std::move(expected), std::move(found)});
}

void Faults::fail(std::string key, std::string expected, std::string found) {
  add(std::move(key), std::move(expected), std::move(found));
  throw InputError(faults_);
}

void Faults::throw_if_any() const {
  if (!faults_.empty())
    throw InputError(faults_);
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 80;
  std::string kept(text.substr(0, longest));
  std::replace_if(
      kept.begin(), kept.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return '"' + kept + (text.size() > longest ? "..." : "") + '"';
}

std::int64_t largest_bytes(const ImageLimits& limits) {
  return limits.largest_bytes > 0 ? limits.largest_bytes : available_memory() / 2;
}

void set_geometry(ImageInfo& info, const FileGeometry& geometry, Faults& faults) {
  const double units = geometry.units_per_metre;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    info.spacing[axis] = geometry.spacing[axis] / units;
    info.origin[axis] = geometry.origin[axis] / units;
    if (!(std::isfinite(geometry.spacing[axis]) && info.spacing[axis] > 0))
      faults.add(geometry.spacing_keys[axis], "a finite spacing > 0",
                 fmt::format("{}", geometry.spacing[axis]));
    if (!std::isfinite(info.origin[axis]))
      faults.add(geometry.origin_key, "finite numbers", fmt::format("{}", geometry.origin[axis]));
  }
  if (is_direction(geometry, faults))
    info.direction = nearest_orthonormal(geometry.direction);
}

} // namespace image_formats

ImageInfo read_image_info(const std::filesystem::path& file) {
  image_formats::Faults faults(file.string());
  return image_formats::open_image(file, image_formats::largest_bytes({}), faults).info;
}

Image read_image(const std::filesystem::path& file, const ImageLimits& limits) {
  image_formats::Faults faults(file.string());
  const image_formats::OpenImage image =
      image_formats::open_image(file, image_formats::largest_bytes(limits), faults);
  image_formats::check_memory(image, image.info.size[2], limits, faults);
  return {image.info, image_formats::read_values(image, faults)};
}

LayeredImage::LayeredImage(const std::filesystem::path& file) : path_(file) {
  image_formats::Faults faults(file.string());
  file_ = std::make_shared<const image_formats::OpenImage>(
      image_formats::open_image(file, image_formats::largest_bytes({}), faults));
  info_ = file_->info;
}

LayeredImage LayeredImage::padded(const Index3& voids) const {
  LayeredImage around = *this;
  around.voids_ = voids;
  for (std::size_t a = 0; a < 3; ++a) {
    around.info_.size[a] += 2 * voids[a];
    for (std::size_t r = 0; r < 3; ++r)
      around.info_.origin[r] -= voids[a] * info_.spacing[a] * info_.direction[r][a];
  }
  return around;
}

LayerWindow LayeredImage::open(int layers) const {
  if (voids_ != Index3{}) {
    LayeredImage bare = *this;
    bare.voids_ = {};
    bare.info_ = whole_ ? whole_->info : file_->info;
    const auto inside = std::make_shared<LayerWindow>(bare.open(layers));
    return {
        info_, [inside, voids = voids_, width = info_.size[0],
                n = info_.size[0] * std::ptrdiff_t{info_.size[1]}](int layer, std::vector<float>& values) {
          values.insert(values.end(), static_cast<std::size_t>(n), NAN);
          const Index3& size = inside->info().size;
          const int k = layer - voids[2];
          if (k < 0 || k >= size[2])
            return;
          inside->move_to(k, k + 1);
          auto from = inside->layer(k).begin();
          for (int j = 0; j < size[1]; ++j, from += size[0])
            std::copy_n(from, size[0], values.end() - n + voids[0] + std::ptrdiff_t{width} * (j + voids[1]));
        }};
  }
  if (whole_)
    return LayerWindow(*whole_);
  image_formats::Faults faults(path_.string());
  image_formats::check_memory(*file_, std::min(layers, info_.size[2]), {}, faults);
  auto reader = std::make_shared<image_formats::ValueReader>(*file_, faults);
  const std::size_t n = static_cast<std::size_t>(info_.size[0]) * static_cast<std::size_t>(info_.size[1]);
  return {info_, [reader, n](int, std::vector<float>& values) { reader->read(n, values); }};
}

std::vector<std::filesystem::path> files_of_image(const std::filesystem::path& file) {
  const std::string ending = image_formats::ending_of(file);
  std::vector<std::filesystem::path> files{file};
  if (ending.empty() && image_formats::is_dicom(file))
    return image_formats::files_of_dicom(file);
  const bool is_nrrd = ending == ".nrrd" || ending == ".nhdr";
  if (ending != ".mha" && ending != ".mhd" && !is_nrrd)
    return files;
  image_formats::Faults faults(file.string());
  try {
    if (auto data = is_nrrd ? image_formats::data_file_of_nrrd(file, faults)
                            : image_formats::data_file_of_meta_image(file, faults);
        data != file)
      files.push_back(std::move(data));
  } catch (const InputError&) { // whoever reads it will say so
  }
  return files;
}

} // namespace maille
