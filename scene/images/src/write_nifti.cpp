// NIfTI-1 in one file.
//
// Source: NIfTI-1 Data Format, nifti1.h (Cox et al., 2004, NIfTI Data Format Working Group).

#include "maille/images/written_file.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>

namespace maille {

namespace {

using namespace image_formats;

constexpr std::size_t header_bytes = 352; // 348, plus four that mean no extensions

/// A NIfTI-1 header in this machine's byte order, which readers detect by its first number.
class Header {
public:
  template<class T>
  void put(std::size_t at, T value) {
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void put(std::size_t at, const char* text) { bytes_.replace(at, std::strlen(text), text); }
  const std::string& bytes() const { return bytes_; }

private:
  std::string bytes_ = std::string(header_bytes, '\0');
};

Header header_of(const ImageInfo& info, StoredType type, StoredAs stored_as) {
  constexpr std::int16_t displacement = 1006, vector = 1007, symmetric_matrix = 1005, scanner = 1;
  constexpr std::array<Vec3, 3> ras{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
      lps{{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
  constexpr double millimetres = 1e3;
  constexpr char unit_is_millimetre = 2;
  Header header;
  header.put(0, std::int32_t{348});
  const bool has_components = info.components > 1;
  header.put(40, static_cast<std::int16_t>(has_components ? 5 : 3));
  for (std::size_t a = 0; a < 3; ++a)
    header.put(42 + 2 * a, static_cast<std::int16_t>(info.size[a]));
  header.put(48, std::int16_t{1});
  header.put(50, static_cast<std::int16_t>(info.components));
  header.put(52, std::int16_t{1});
  header.put(54, std::int16_t{1});
  const auto along = in_world(info, WorldAxes::ras).vectors_to_world;
  if (info.components == 3 && (along == ras || along == lps))
    header.put(68, along == ras ? displacement : vector);
  if (stored_as == StoredAs::tensors) {
    header.put(56, 3.0F); // intent_p1: of a 3 x 3 matrix
    header.put(68, symmetric_matrix);
  }
  constexpr std::array<std::int16_t, 4> codes{16, 2, 4, 8}; // of StoredType
  header.put(70, codes[static_cast<std::size_t>(type)]);
  header.put(72, static_cast<std::int16_t>(8 * bytes_of(type)));
  header.put(108, static_cast<float>(header_bytes));
  header.put(112, 1.0F);
  header.put(123, unit_is_millimetre);
  header.put(148, "maille"); // descrip: program that wrote the file
  header.put(252, scanner);
  header.put(254, scanner);
  Eigen::Matrix3d direction;
  Eigen::Vector3d origin;
  for (std::size_t row = 0; row < 3; ++row) {
    const double sign = info.world == WorldAxes::lps && row < 2 ? -1 : 1;
    origin[static_cast<Eigen::Index>(row)] = sign * millimetres * info.origin[row];
    for (std::size_t a = 0; a < 3; ++a)
      direction(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(a)) = sign * info.direction[row][a];
  }
  for (std::size_t row = 0; row < 3; ++row) {
    const auto r = static_cast<Eigen::Index>(row);
    for (std::size_t a = 0; a < 3; ++a)
      header.put(280 + 16 * row + 4 * a, static_cast<float>(direction(r, static_cast<Eigen::Index>(a)) *
                                                            millimetres * info.spacing[a]));
    header.put(280 + 16 * row + 12, static_cast<float>(origin[r]));
    header.put(268 + 4 * row, static_cast<float>(origin[r]));
  }
  const bool is_mirrored = direction.determinant() < 0;
  if (is_mirrored)
    direction.col(2) = -direction.col(2);
  Eigen::Quaterniond turn(direction);
  turn.normalize();
  if (turn.w() < 0)
    turn.coeffs() = -turn.coeffs();
  header.put(76, is_mirrored ? -1.0F : 1.0F);
  for (std::size_t a = 0; a < 3; ++a)
    header.put(80 + 4 * a, static_cast<float>(millimetres * info.spacing[a]));
  header.put(256, static_cast<float>(turn.x()));
  header.put(260, static_cast<float>(turn.y()));
  header.put(264, static_cast<float>(turn.z()));
  header.put(344, "n+1");
  return header;
}
} // namespace

void write_nifti(const Image& image, const std::filesystem::path& file, StoredAs stored_as) {
  constexpr int longest_axis = 32767;
  const auto n = static_cast<std::size_t>(image.info.n_voxels());
  if (*std::ranges::max_element(image.info.size) > longest_axis)
    throw std::invalid_argument(fmt::format("NIfTI-1 holds at most {} voxels along an axis", longest_axis));
  if (image.values.size() != n * static_cast<std::size_t>(image.info.components) ||
      (stored_as == StoredAs::tensors && image.info.components != 6))
    throw std::invalid_argument("an image whose values do not fit its grid");
  const StoredType type = stored_type(image.values, stored_as);
  const Header header = header_of(image.info, type, stored_as);
  using Packing = WrittenFile::Packing;
  WrittenFile output(file, file.extension() != ".gz"   ? Packing::none
                           : image.info.components > 1 ? Packing::gzip_fast
                                                       : Packing::gzip);
  output.write(header.bytes().data(), header_bytes);
  constexpr std::array<std::size_t, 6> lower_triangle{0, 3, 1, 4, 5, 2};
  for (std::size_t c = 0; c < static_cast<std::size_t>(image.info.components); ++c)
    write_values(
        output,
        std::span(image.values).subspan(n * (stored_as == StoredAs::tensors ? lower_triangle[c] : c), n),
        type);
  output.close();
}

} // namespace maille
