#pragma once
/// Small writers of image files, so that the tests know every byte that the readers are given.

#include "maille/images/image.hpp"
#include "support/kit.hpp"

#include <unistd.h>
#include <zlib.h>

#include <bit>

namespace maille::image_tests {

using test::TemporaryFolder;

template<class T>
std::string bytes_of(T value, bool is_big_endian) {
  auto bytes = std::bit_cast<std::array<char, sizeof(T)>>(value);
  if (is_big_endian != (std::endian::native == std::endian::big))
    std::reverse(bytes.begin(), bytes.end());
  return {bytes.data(), bytes.size()};
}

template<class T>
std::string bytes_of(const std::vector<T>& values, bool is_big_endian) {
  std::string bytes{};
  for (const T value : values)
    bytes += bytes_of(value, is_big_endian);
  return bytes;
}

inline std::string deflated(const std::string& bytes, bool is_gzip) {
  z_stream state{};
  deflateInit2(&state, 6, Z_DEFLATED, is_gzip ? 31 : 15, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&state, bytes.size()), '\0');
  state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  state.avail_in = static_cast<uInt>(bytes.size());
  state.next_out = reinterpret_cast<Bytef*>(out.data());
  state.avail_out = static_cast<uInt>(out.size());
  deflate(&state, Z_FINISH);
  out.resize(state.total_out);
  deflateEnd(&state);
  return out;
}

inline std::string base64(const std::string& bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text{};
  for (std::size_t at = 0; at < bytes.size(); at += 3) {
    unsigned bits = 0;
    for (std::size_t i = 0; i < 3; ++i)
      bits = bits << 8 | (at + i < bytes.size() ? static_cast<unsigned char>(bytes[at + i]) : 0U);
    for (std::size_t i = 0; i < 4; ++i)
      text += at + i > bytes.size() ? '=' : digits[bits >> (18 - 6 * i) & 63U];
  }
  return text;
}

/// A NIfTI file; what is not set is 0.
struct NiftiFile {
  int version = 1;
  bool is_big_endian = false;
  std::vector<std::int64_t> dim{3, 1, 1, 1};
  int datatype = 2;
  int bitpix = 8;
  std::vector<double> pixdim{1, 1, 1, 1};
  double vox_offset = -1; ///< -1: right behind the header
  double slope = 0;
  double intercept = 0;
  int units = 2;
  int qform = 0;
  int sform = 0;
  std::array<double, 6> quatern{}; ///< b, c, d, and the offset
  std::array<double, 12> srow{};
  std::string magic{}; ///< empty: the right one
  std::string data{};

  std::string bytes() const {
    const bool is_1 = version == 1;
    std::string header(is_1 ? 352 : 544, '\0');
    const auto put = [&](std::size_t at, const std::string& field) {
      header.replace(at, field.size(), field);
    };
    const auto integer = [&](std::size_t at, std::int64_t value) {
      put(at, is_1 ? bytes_of(static_cast<std::int16_t>(value), is_big_endian)
                   : bytes_of(static_cast<std::int32_t>(value), is_big_endian));
    };
    const auto real = [&](std::size_t at, std::size_t index, double value) {
      put(at + index * (is_1 ? 4 : 8),
          is_1 ? bytes_of(static_cast<float>(value), is_big_endian) : bytes_of(value, is_big_endian));
    };
    put(0, bytes_of(std::int32_t{is_1 ? 348 : 540}, is_big_endian));
    for (std::size_t i = 0; i < dim.size(); ++i)
      put(is_1 ? 40 + 2 * i : 16 + 8 * i, is_1 ? bytes_of(static_cast<std::int16_t>(dim[i]), is_big_endian)
                                               : bytes_of(dim[i], is_big_endian));
    put(is_1 ? 70 : 12, bytes_of(static_cast<std::int16_t>(datatype), is_big_endian));
    put(is_1 ? 72 : 14, bytes_of(static_cast<std::int16_t>(bitpix), is_big_endian));
    for (std::size_t i = 0; i < pixdim.size(); ++i)
      real(is_1 ? 76 : 104, i, pixdim[i]);
    const double offset = vox_offset == -1 ? static_cast<double>(header.size()) : vox_offset;
    put(is_1 ? 108 : 168, is_1 ? bytes_of(static_cast<float>(offset), is_big_endian)
                               : bytes_of(static_cast<std::int64_t>(offset), is_big_endian));
    real(is_1 ? 112 : 176, 0, slope);
    real(is_1 ? 116 : 184, 0, intercept);
    if (is_1)
      header[123] = static_cast<char>(units);
    else
      integer(500, units);
    integer(is_1 ? 252 : 344, qform);
    integer(is_1 ? 254 : 348, sform);
    for (std::size_t i = 0; i < 6; ++i)
      real(is_1 ? 256 : 352, i, quatern[i]);
    for (std::size_t i = 0; i < 12; ++i)
      real(is_1 ? 280 : 400, i, srow[i]);
    using namespace std::string_literals;
    put(is_1 ? 344 : 4, !magic.empty() ? magic : is_1 ? "n+1\0"s : "n+2\0\r\n\x1a\n"s);
    return header + data;
  }
};

/// The faults of a file that must not be read.
inline std::vector<Fault> faults_of(const std::filesystem::path& file, const ImageLimits& limits = {}) {
  std::vector<Fault> faults = test::faults_found_by([&] { read_image(file, limits); });
  EXPECT_FALSE(faults.empty()) << "was read without a complaint";
  for (const Fault& fault : faults)
    EXPECT_EQ(fault.file, file.string());
  return faults.empty() ? std::vector{Fault{}} : faults;
}

inline std::string keys_of(const std::vector<Fault>& faults) {
  std::string keys;
  for (const Fault& fault : faults)
    keys += (keys.empty() ? "" : "; ") + fault.key;
  return keys;
}

inline void expect_near(const Vec3& found, const Vec3& expected, double tolerance) {
  for (std::size_t axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(found[axis], expected[axis], tolerance) << "axis " << axis;
}

inline void expect_near(const std::array<Vec3, 3>& found, const std::array<Vec3, 3>& expected,
                        double tolerance) {
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(found[row][axis], expected[row][axis], tolerance) << "row " << row << ", axis " << axis;
}

} // namespace maille::image_tests
