// Selects the reader of a file, limits its memory, and sets the geometry for all readers.

#include "maille/images/image.hpp"
#include "maille/base/arena.hpp"
#include "maille/base/vectors.hpp"
#include "maille/images/write_image.hpp"

#include "image_formats.hpp"
#include "maille/images/layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {
namespace image_formats {
namespace {

constexpr double largest_shear = 1e-3;
constexpr double farthest_origin = 1e11; ///< [spacings]; doubles still resolve 1e-4 spacings there

/// Dot product of two columns.
double dot(const std::array<Vec3, 3>& rows, std::size_t a, std::size_t b) {
  return rows[0][a] * rows[0][b] + rows[1][a] * rows[1][b] + rows[2][a] * rows[2][b];
}

/// The rotation (or rotary reflection) nearest to a nearly orthonormal matrix, by A <- A (3 I - A^T A) / 2.
/// Source: Björck and Bowie 1971, SIAM J. Numer. Anal. 8, second-order iteration. Unlike Gram-Schmidt it
/// treats all axes equally, and it does not change an orthonormal matrix.
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

/// True if the axes of a form are orthonormal to the tolerance; a form of zeros has NaN axes.
bool is_grid(const FileGeometry& geometry) {
  bool is_good = true;
  for (std::size_t a = 0; a < 3; ++a) {
    is_good = is_good && std::abs(std::sqrt(dot(geometry.direction, a, a)) - 1) <= largest_shear &&
              std::isfinite(geometry.spacing[a]) && geometry.spacing[a] > 0 &&
              std::isfinite(geometry.origin[a]);
    for (std::size_t b = 0; b < a; ++b)
      is_good = is_good && std::abs(dot(geometry.direction, a, b)) <= largest_shear;
  }
  return is_good;
}

/// Largest distance between two forms over the corner voxels [mm]; NaN for non-finite forms.
double distance_mm(const FileGeometry& one, const FileGeometry& other, const Index3& size) {
  double most = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    double squared = 0;
    for (std::size_t row = 0; row < 3; ++row) {
      double x = one.origin[row] - other.origin[row];
      for (std::size_t a = 0; a < 3; ++a)
        x += (corner >> a & 1U ? size[a] - 1.0 : 0.0) *
             (one.direction[row][a] * one.spacing[a] - other.direction[row][a] * other.spacing[a]);
      squared += x * x;
    }
    most = squared <= most * most ? most : std::sqrt(squared);
  }
  return 1e3 * most / one.units_per_metre;
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

OpenImage open_image(const std::filesystem::path& file, Faults& faults) {
  const std::string ending = ending_of(file);
  if (ending.empty() && is_dicom(file))
    return open_dicom(file, faults);
  if (ending.empty())
    faults.fail("",
                "a file that ends in .nii, .nii.gz, .mha, .mhd, .nrrd, .nhdr or .vti, or a folder of DICOM "
                "files",
                !std::filesystem::exists(file) ? "nothing of that name"
                : file.extension() == ".hdr" || file.extension() == ".img"
                    ? in_quotes(file.filename().string()) +
                          ", NIfTI or ANALYZE in two files: fslchfiletype or "
                          "nibabel make it one"
                    : in_quotes(file.filename().string()));
  if (ending == ".vti")
    return open_vti(file, faults);
  if (ending == ".mha" || ending == ".mhd")
    return open_meta_image(file, faults);
  if (ending == ".nrrd" || ending == ".nhdr")
    return open_nrrd(file, faults);
  return open_nifti(file, faults);
}

/// A fault if this number of layers of the decoded image exceeds the limits.
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

std::string ending_of(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char character) { return static_cast<char>(std::tolower(character)); });
  for (const char* ending : {".nii.gz", ".nii", ".mha", ".mhd", ".nrrd", ".nhdr", ".vti"})
    if (name.ends_with(ending))
      return ending;
  return {};
}

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

void FileGeometry::set_axes(const std::array<Vec3, 3>& axes) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    spacing[axis] = norm(axes[axis]);
    for (std::size_t row = 0; row < 3; ++row)
      direction[row][axis] = axes[axis][row] / spacing[axis];
  }
}

std::int64_t largest_bytes(const ImageLimits& limits) {
  return limits.largest_bytes > 0 ? limits.largest_bytes : available_memory() / 2;
}

void set_geometry(ImageInfo& info, const FileGeometry& stated, Faults& faults,
                  const std::vector<FileGeometry>& others) {
  const auto good = std::ranges::find_if(others, is_grid);
  const bool is_replaced = !is_grid(stated) && good != others.end();
  const FileGeometry& geometry = is_replaced ? *good : stated;
  if (is_replaced) {
    const double apart = distance_mm(stated, geometry, info.size);
    warn_of_file(
        faults.file(),
        std::isfinite(apart)
            ? fmt::format("the {} is sheared and spans no grid: the {} counts, up to {:.3g} mm from it",
                          stated.name, geometry.name, apart)
            : fmt::format("the {} is empty: the {} counts, voxel 0 at ({:.4g}, {:.4g}, {:.4g}) mm",
                          stated.name, geometry.name, 1e3 / geometry.units_per_metre * geometry.origin[0],
                          1e3 / geometry.units_per_metre * geometry.origin[1],
                          1e3 / geometry.units_per_metre * geometry.origin[2]));
  }
  for (const FileGeometry& other : others)
    if (const double apart = distance_mm(geometry, other, info.size);
        !is_replaced && is_grid(other) &&
        apart > 10 / geometry.units_per_metre * std::ranges::min(geometry.spacing))
      warn_of_file(faults.file(),
                   fmt::format("{} and {} place the voxels up to {:.4g} mm apart: the {} counts, while ITK "
                               "(3D Slicer, ANTs, plastimatch) may take the {}",
                               geometry.name, other.name, apart, geometry.name, other.name));
  const double units = geometry.units_per_metre;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    info.spacing[axis] = geometry.spacing[axis] / units;
    info.origin[axis] = geometry.origin[axis] / units;
    if (!(std::isfinite(geometry.spacing[axis]) && info.spacing[axis] > 0))
      faults.add(geometry.spacing_keys[axis], "a finite spacing > 0",
                 fmt::format("{}", geometry.spacing[axis]));
    if (!(std::abs(geometry.origin[axis]) <= farthest_origin * std::ranges::max(geometry.spacing)))
      faults.add(geometry.origin_key, fmt::format("finite numbers of at most {:g} spacings", farthest_origin),
                 fmt::format("{}", geometry.origin[axis]));
  }
  if (is_direction(geometry, faults))
    info.direction = nearest_orthonormal(geometry.direction);
  if (!geometry.states_spacing)
    warn_of_file(faults.file(), "states no spacing of its voxels: taken as 1 mm");
  info.states_world = geometry.world != WorldAxes::unknown;
  info.world = info.states_world ? geometry.world : geometry.fallback;
  if (!info.states_world && info.world != WorldAxes::unknown && info.size[2] > 1)
    warn_of_file(faults.file(),
                 fmt::format("states no orientation: taken as {}, voxel 0 at ({:.4g}, {:.4g}, "
                             "{:.4g}) mm",
                             info.world == WorldAxes::lps ? "LPS, as ITK does" : "RAS", 1e3 * info.origin[0],
                             1e3 * info.origin[1], 1e3 * info.origin[2]));
}

} // namespace image_formats

namespace {

struct FileWarnings {
  std::mutex mutex;
  std::vector<std::string> all;
  std::size_t n_returned = 0;
};
FileWarnings& warnings() {
  static FileWarnings of_process;
  return of_process;
}

/// The image axis along each column of `direction`, and its sign.
struct AxisOrder {
  std::array<std::size_t, 3> axis{0, 1, 2};
  std::array<bool, 3> is_reversed{};
  bool is_same() const { return axis == AxisOrder{}.axis && is_reversed == AxisOrder{}.is_reversed; }
};
AxisOrder order_along(const ImageInfo& info, const std::array<Vec3, 3>& direction) {
  AxisOrder order;
  for (std::size_t b = 0; b < 3; ++b) {
    bool is_found = false;
    for (std::size_t a = 0; a < 3 && !is_found; ++a) {
      double cosine = 0;
      for (std::size_t row = 0; row < 3; ++row)
        cosine += info.direction[row][a] * direction[row][b];
      constexpr double rounding = 1e-6; // a turn by some 1e-3
      is_found = std::abs(cosine) > 1 - rounding;
      if (is_found) {
        order.axis[b] = a;
        order.is_reversed[b] = cosine < 0;
      }
    }
    if (!is_found)
      return {};
  }
  return order;
}

ImageInfo ordered(const ImageInfo& info, const AxisOrder& order) {
  ImageInfo out = info;
  for (std::size_t b = 0; b < 3; ++b) {
    const std::size_t a = order.axis[b];
    out.size[b] = info.size[a];
    out.spacing[b] = info.spacing[a];
    for (std::size_t row = 0; row < 3; ++row) {
      out.direction[row][b] = order.is_reversed[b] ? -info.direction[row][a] : info.direction[row][a];
      if (order.is_reversed[b])
        out.origin[row] += info.direction[row][a] * info.spacing[a] * (info.size[a] - 1);
    }
  }
  return out;
}

/// Rounds labels to whole numbers, and collects values that are not whole.
class LabelRounding {
public:
  explicit LabelRounding(std::vector<float> labels) : labels_(std::move(labels)) {}
  void round(std::span<float> values) {
    for (float& value : values) {
      if (value == std::round(value) || !std::isfinite(value))
        continue;
      float whole = value;
      round_labels({&whole, 1});
      if (std::ranges::find(labels_, value) != labels_.end())
        continue;
      if (whole != value && std::ranges::find(labels_, whole) != labels_.end()) {
        ++n_rounded_;
        first_rounded_ = n_rounded_ == 1 ? value : first_rounded_;
        value = whole;
      } else if (whole == value) {
        ++n_other_;
        first_other_ = n_other_ == 1 ? value : first_other_;
      }
    }
  }
  void warn(const std::filesystem::path& file) const {
    if (n_rounded_ > 0)
      warn_of_file(file,
                   fmt::format("{} voxels are a label but for rounding, the first {:.9g}: they count for it",
                               n_rounded_, first_rounded_));
    if (n_other_ > 0)
      warn_of_file(file, fmt::format("{} voxels are no whole number, the first {:.9g}: they are no label's",
                                     n_other_, first_other_));
  }

private:
  std::vector<float> labels_;
  std::int64_t n_rounded_ = 0, n_other_ = 0;
  float first_rounded_ = 0, first_other_ = 0;
};

} // namespace

ImageInfo in_world(ImageInfo info, WorldAxes world) {
  const bool is_other =
      info.world != WorldAxes::unknown && world != WorldAxes::unknown && info.world != world;
  for (std::size_t row = 0; row < 2 && is_other; ++row) {
    info.origin[row] = -info.origin[row];
    for (std::size_t a = 0; a < 3; ++a) {
      info.direction[row][a] = -info.direction[row][a];
      if (info.vectors_to_world)
        (*info.vectors_to_world)[row][a] = -(*info.vectors_to_world)[row][a];
    }
  }
  info.world = world == WorldAxes::unknown ? info.world : world;
  return info;
}

ImageInfo along_axes(const ImageInfo& info, const std::array<Vec3, 3>& direction) {
  return ordered(info, order_along(info, direction));
}

Image along_axes(Image image, const std::array<Vec3, 3>& direction) {
  const AxisOrder order = order_along(image.info, direction);
  if (order.is_same())
    return image;
  Image out{ordered(image.info, order), std::vector<float>(image.values.size())};
  const std::array<std::int64_t, 3> stride{1, image.info.size[0],
                                           std::int64_t{image.info.size[0]} * image.info.size[1]};
  std::int64_t first = 0;
  std::array<std::int64_t, 3> step{};
  for (std::size_t b = 0; b < 3; ++b) {
    step[b] = order.is_reversed[b] ? -stride[order.axis[b]] : stride[order.axis[b]];
    first += order.is_reversed[b] ? stride[order.axis[b]] * (out.info.size[b] - 1) : 0;
  }
  std::size_t to = 0;
  for (int c = 0; c < out.info.components; ++c)
    for (int k = 0; k < out.info.size[2]; ++k)
      for (int j = 0; j < out.info.size[1]; ++j)
        for (int i = 0; i < out.info.size[0]; ++i)
          out.values[to++] =
              image.values[c * out.info.n_voxels() + first + i * step[0] + j * step[1] + k * step[2]];
  return out;
}

std::int64_t round_labels(std::span<float> values) {
  std::int64_t n = 0;
  for (float& value : values) {
    const float whole = std::round(value);
    constexpr float rounding = 1e-5F;
    if (value != whole && std::abs(value - whole) <= rounding * std::max(1.0F, std::abs(whole))) {
      value = whole;
      ++n;
    }
  }
  return n;
}

void warn_of_file(const std::filesystem::path& file, const std::string& text) {
  FileWarnings& found = warnings();
  const std::scoped_lock lock(found.mutex);
  std::string warning = file.string() + ": " + text;
  constexpr std::size_t most = 1000; // not returned yet
  const std::size_t n = found.all.size() - found.n_returned;
  if (n < most && std::ranges::find(found.all, warning) == found.all.end())
    found.all.push_back(n + 1 < most ? std::move(warning)
                                     : "files: more than 1000 warnings, the others are left out");
}

std::vector<std::string> file_warnings(bool only_new) {
  FileWarnings& found = warnings();
  const std::scoped_lock lock(found.mutex);
  const std::size_t first = only_new ? found.n_returned : 0;
  found.n_returned = found.all.size();
  return {found.all.begin() + static_cast<std::ptrdiff_t>(first), found.all.end()};
}

ImageInfo read_image_info(const std::filesystem::path& file) {
  image_formats::Faults faults(file.string());
  return image_formats::open_image(file, faults).info;
}

StoredAs stored_form(const std::filesystem::path& file) {
  image_formats::Faults faults(file.string());
  const auto layout = image_formats::open_image(file, faults).layout;
  return layout.is_lower_triangle ? StoredAs::tensors : StoredAs::float32;
}

Image read_image(const std::filesystem::path& file, const ImageLimits& limits) {
  image_formats::Faults faults(file.string());
  const image_formats::OpenImage image = image_formats::open_image(file, faults);
  image_formats::check_memory(image, image.info.size[2], limits, faults);
  return {image.info, image_formats::read_values(image, faults)};
}

LayeredImage::LayeredImage(const std::filesystem::path& file) : path_(file) {
  image_formats::Faults faults(file.string());
  file_ = std::make_shared<const image_formats::OpenImage>(image_formats::open_image(file, faults));
  info_ = file_->info;
}

void LayeredImage::place(const ImageInfo& there, const std::array<Vec3, 3>& direction) {
  info_ = along_axes(there, direction);
  if (order_along(there, direction).is_same() || info_.components != 1)
    return;
  Image image = read_image(path_);
  image.info = there;
  turned_ = std::make_shared<const Image>(along_axes(std::move(image), direction));
  whole_ = turned_.get();
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
  if (whole_ && labels_.empty())
    return LayerWindow(*whole_);
  const std::size_t n = static_cast<std::size_t>(info_.size[0]) * static_cast<std::size_t>(info_.size[1]);
  std::function<void(int, std::vector<float>&)> next;
  if (whole_) {
    next = [image = whole_, kept = turned_, n](int layer, std::vector<float>& values) {
      const auto from = image->values.begin() + static_cast<std::ptrdiff_t>(n) * layer;
      values.insert(values.end(), from, from + static_cast<std::ptrdiff_t>(n));
    };
  } else {
    image_formats::Faults faults(path_.string());
    image_formats::check_memory(*file_, std::min(layers, info_.size[2]), {}, faults);
    auto reader = std::make_shared<image_formats::ValueReader>(*file_, faults);
    next = [reader, n](int, std::vector<float>& values) { reader->read(n, values); };
  }
  if (labels_.empty())
    return {info_, std::move(next)};
  return {info_, [next = std::move(next), rounding = std::make_shared<LabelRounding>(labels_), path = path_,
                  last = info_.size[2] - 1](int layer, std::vector<float>& values) {
            const std::size_t first = values.size();
            next(layer, values);
            rounding->round(std::span(values).subspan(first));
            if (layer == last && !path.empty())
              rounding->warn(path);
          }};
}

bool has_image_ending(const std::filesystem::path& file) {
  return !image_formats::ending_of(file).empty();
}

std::vector<Fault> set_affine(ImageInfo& info, const std::array<std::array<double, 4>, 4>& affine,
                              const std::string& key) {
  image_formats::FileGeometry geometry;
  geometry.fallback = WorldAxes::unknown; // no file
  geometry.units_per_metre = 1;
  geometry.spacing_keys.fill(key);
  geometry.origin_key = geometry.direction_key = key;
  std::array<Vec3, 3> axes{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      axes[axis][row] = affine[row][axis];
    geometry.origin[row] = affine[row][3];
  }
  geometry.set_axes(axes);
  image_formats::Faults found("");
  image_formats::set_geometry(info, geometry, found);
  return found.all();
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
  } catch (const InputError&) { // the reader reports the error
  }
  return files;
}

} // namespace maille
