// Writes MetaImage and NRRD, and selects the writer for a file.
//
// Source: MetaIO documentation (ITK wiki) as in image_meta.cpp; "Definition of NRRD File Format"
// (Kindlmann, Teem), version 5. Both world frames are LPS.

#include "maille/images/written_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace maille {

namespace image_formats {

StoredType stored_type(std::span<const float> values, StoredAs stored_as) {
  if (stored_as != StoredAs::labels)
    return StoredType::float32;
  float least = 0, most = 0;
  for (const float value : values) {
    constexpr float largest = 1 << 24; // float32 skips whole numbers beyond
    if (!(std::abs(value) <= largest) || value != std::floor(value))
      throw std::invalid_argument(
          fmt::format("expected labels, whole numbers of at most 2^24, found {}", value));
    least = std::min(least, value);
    most = std::max(most, value);
  }
  if (least >= 0 && most <= 255)
    return StoredType::uint8;
  return least >= -32768 && most <= 32767 ? StoredType::int16 : StoredType::int32;
}

std::size_t bytes_of(StoredType type) {
  constexpr std::array<std::size_t, 4> bytes{4, 1, 2, 4};
  return bytes[static_cast<std::size_t>(type)];
}

namespace {

template<class T>
void write_as(WrittenFile& file, std::span<const float> values) {
  constexpr std::size_t most = std::size_t{1} << 16;
  std::vector<T> part;
  while (!values.empty()) {
    const auto now = values.first(std::min(most, values.size()));
    part.clear();
    for (const float value : now)
      part.push_back(static_cast<T>(value));
    file.write(part.data(), part.size() * sizeof(T));
    values = values.subspan(now.size());
  }
}

} // namespace

void write_values(WrittenFile& file, std::span<const float> values, StoredType type) {
  switch (type) {
  case StoredType::float32:
    return file.write(values.data(), values.size_bytes());
  case StoredType::uint8:
    return write_as<std::uint8_t>(file, values);
  case StoredType::int16:
    return write_as<std::int16_t>(file, values);
  case StoredType::int32:
    return write_as<std::int32_t>(file, values);
  }
}

namespace {

namespace fs = std::filesystem;

constexpr double millimetres = 1e3;

/// Axes and origin in ITK's world [mm].
struct LpsGrid {
  std::array<Vec3, 3> axes{}; ///< of length 1
  Vec3 spacing{}, origin{};

  explicit LpsGrid(const ImageInfo& info) {
    for (std::size_t row = 0; row < 3; ++row) {
      const double sign = info.world != WorldAxes::lps && row < 2 ? -1 : 1;
      origin[row] = sign * millimetres * info.origin[row] + 0.0; // no -0
      for (std::size_t a = 0; a < 3; ++a)
        axes[a][row] = sign * info.direction[row][a] + 0.0;
      spacing[row] = millimetres * info.spacing[row];
    }
  }
};

/// Writes the components of each voxel together, some planes at a time.
void write_interleaved(WrittenFile& file, const Image& image, StoredType type) {
  const auto components = static_cast<std::size_t>(image.info.components);
  if (components == 1)
    return write_values(file, image.values, type);
  const auto n = static_cast<std::size_t>(image.info.n_voxels());
  constexpr std::size_t most = std::size_t{1} << 14; // while caches have them
  std::vector<float> part;
  for (std::size_t first = 0; first < n; first += most) {
    const std::size_t count = std::min(most, n - first);
    part.resize(components * count);
    for (std::size_t c = 0; c < components; ++c)
      for (std::size_t i = 0; i < count; ++i)
        part[components * i + c] = image.values[c * n + first + i];
    write_values(file, part, type);
  }
}

std::string in_blanks(const Vec3& v) {
  return fmt::format("{} {} {}", v[0], v[1], v[2]);
}

void write_meta_image(const Image& image, const fs::path& file, StoredType type) {
  constexpr std::array<const char*, 4> names{"MET_FLOAT", "MET_UCHAR", "MET_SHORT", "MET_INT"};
  const ImageInfo& info = image.info;
  const LpsGrid grid(info);
  const std::string header = fmt::format(
      "ObjectType = Image\nComment = maille\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = {}\n"
      "CompressedData = False\nTransformMatrix = {} {} {}\nOffset = {}\nCenterOfRotation = 0 0 0\n"
      "AnatomicalOrientation = LPS\nElementSpacing = {}\nDimSize = {} {} {}\nElementNumberOfChannels = {}\n"
      "ElementType = {}\nElementDataFile = LOCAL\n",
      std::endian::native == std::endian::big ? "True" : "False", in_blanks(grid.axes[0]),
      in_blanks(grid.axes[1]), in_blanks(grid.axes[2]), in_blanks(grid.origin), in_blanks(grid.spacing),
      info.size[0], info.size[1], info.size[2], info.components, names[static_cast<std::size_t>(type)]);
  WrittenFile output(file, WrittenFile::Packing::none);
  output.write(header.data(), header.size());
  write_interleaved(output, image, type);
  output.close();
}

std::string in_brackets(const Vec3& v, double factor = 1) {
  return fmt::format("({},{},{})", factor * v[0], factor * v[1], factor * v[2]);
}

void write_nrrd(const Image& image, const fs::path& file, StoredType type, const ImageFileOptions& options) {
  constexpr std::array<const char*, 4> names{"float", "unsigned char", "short", "int"};
  const ImageInfo& info = image.info;
  const LpsGrid grid(info);
  const bool has_components = info.components > 1;
  std::string header = fmt::format(
      "NRRD0005\n# {}\n# maille\ntype: {}\ndimension: {}\nspace: left-posterior-superior\nsizes: {}{} {} {}\n"
      "space directions:{}",
      "http://teem.sourceforge.net/nrrd/format.html", names[static_cast<std::size_t>(type)],
      has_components ? 4 : 3, has_components ? fmt::format("{} ", info.components) : "", info.size[0],
      info.size[1], info.size[2], has_components ? " none" : "");
  for (std::size_t a = 0; a < 3; ++a)
    header += " " + in_brackets(grid.axes[a], grid.spacing[a]);
  header +=
      fmt::format("\nkinds:{} domain domain domain\nendian: {}\nencoding: gzip\nspace origin: {}\n",
                  !has_components        ? ""
                  : info.components == 3 ? " vector"
                                         : " list",
                  std::endian::native == std::endian::little ? "little" : "big", in_brackets(grid.origin));
  for (const auto& [key, value] : options.nrrd_keys)
    header += fmt::format("{}:={}\n", key, value);
  header += "\n";
  std::ofstream text(file, std::ios::binary | std::ios::trunc);
  text << header;
  text.close();
  if (!text)
    throw std::runtime_error("cannot write " + file.string());
  WrittenFile output(file, WrittenFile::Packing::gzip_appended);
  write_interleaved(output, image, type);
  output.close();
}

std::string writable_ending(const fs::path& file) {
  const std::string name = file.filename().string();
  for (const char* ending : {".gz", ".nii", ".mha", ".nrrd"}) // .gz covers .nii.gz
    if (name.ends_with(ending))
      return ending;
  return {};
}

} // namespace
} // namespace image_formats

void write_image(const Image& image, const std::filesystem::path& file, const ImageFileOptions& options) {
  using namespace image_formats;
  const std::string ending = writable_ending(file);
  if (ending.empty())
    throw std::invalid_argument("expected a name that ends in .nii, .nii.gz, .mha or .nrrd, found " +
                                file.string());
  if (image.info.components < 1 || image.values.size() != static_cast<std::size_t>(image.info.n_voxels()) *
                                                              static_cast<std::size_t>(image.info.components))
    throw std::invalid_argument("an image whose values do not fit its grid");
  if (ending == ".nii" || ending == ".gz")
    return write_nifti(image, file, options.stored_as);
  const StoredType type = stored_type(image.values, options.stored_as);
  if (ending == ".mha")
    return write_meta_image(image, file, type);
  write_nrrd(image, file, type, options);
}

} // namespace maille
