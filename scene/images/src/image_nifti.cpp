// NIfTI-1 and NIfTI-2 in one file (.nii, .nii.gz).
//
// Source: NIfTI-1 Data Format, nifti1.h (Cox et al., 2004, NIfTI Data Format Working Group), and nifti2.h
// (2011). Departures: a sform with shear is refused unless there is a qform; ANALYZE without a magic, and
// types that are no plain numbers (complex, RGB, bits, 128-bit floats) are refused with a specific message;
// coordinate systems are RAS for any xform code.

#include "image_formats.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace maille::image_formats {
namespace {

/// Offsets and widths of the fields that are used.
struct Version {
  int number;
  std::int32_t header_bytes;
  std::size_t magic, dim, datatype, bitpix, pixdim, vox_offset, slope, intercept, units, qform, sform,
      quatern, qoffset, srow, intent;
};
constexpr Version version_1{1, 348, 344, 40, 70, 72, 76, 108, 112, 116, 123, 252, 254, 256, 268, 280, 68};
constexpr Version version_2{2, 540, 4, 16, 12, 14, 104, 168, 176, 184, 500, 344, 348, 352, 376, 400, 504};
constexpr std::int64_t extension_flag_bytes = 4;
constexpr std::int64_t largest_offset = std::int64_t{1} << 28; // limits the time to skip in a compressed file

class Header {
public:
  Header(std::vector<char> bytes, const Version& version, bool swap_bytes)
      : bytes_(std::move(bytes)), version_(version), swap_bytes_(swap_bytes) {}
  const Version& version() const { return version_; }
  bool swap_bytes() const { return swap_bytes_; }
  std::string_view text(std::size_t offset, std::size_t count) const {
    return {bytes_.data() + offset, count};
  }
  int byte(std::size_t offset) const { return static_cast<unsigned char>(bytes_[offset]); }
  int short_integer(std::size_t offset) const { return get<std::int16_t>(offset); }
  /// int16 in version 1, int32 in version 2
  int code(std::size_t offset) const {
    return is_1() ? get<std::int16_t>(offset) : get<std::int32_t>(offset);
  }
  /// float32 in version 1, float64 in version 2
  double real(std::size_t offset, std::size_t index = 0) const {
    return is_1() ? double{get<float>(offset + 4 * index)} : get<double>(offset + 8 * index);
  }
  std::int64_t dim(std::size_t index) const {
    return is_1() ? get<std::int16_t>(version_.dim + 2 * index) : get<std::int64_t>(version_.dim + 8 * index);
  }
  double pixdim(std::size_t index) const { return real(version_.pixdim, index); }
  int length_unit() const { return (is_1() ? byte(version_.units) : get<std::int32_t>(version_.units)) & 7; }
  double vox_offset() const {
    return is_1() ? double{get<float>(version_.vox_offset)}
                  : static_cast<double>(get<std::int64_t>(version_.vox_offset));
  }

private:
  bool is_1() const { return version_.number == 1; }
  template<class T>
  T get(std::size_t offset) const {
    return number_at<T>(bytes_.data() + offset, swap_bytes_);
  }
  std::vector<char> bytes_;
  Version version_;
  bool swap_bytes_;
};

/// The first bytes decide whether the file is compressed, for any name.
ByteSourcePtr open_bytes(const std::filesystem::path& file, Faults& faults) {
  std::array<char, 2> first{};
  open_file(file, 0, faults)->read(first);
  ByteSourcePtr source = open_file(file, 0, faults);
  const bool is_gzipped = first[0] == '\x1f' && first[1] == '\x8b';
  return is_gzipped ? inflated(std::move(source), Compression::gzip, faults) : source;
}

Header read_header(ByteSource& source, Faults& faults) {
  std::vector<char> bytes(sizeof(std::int32_t));
  std::size_t got = source.read(bytes);
  if (got < bytes.size())
    faults.fail("sizeof_hdr", "a NIfTI header of 348 or 540 bytes", fmt::format("{} bytes", got));
  for (const Version& version : {version_1, version_2})
    for (const bool swap_bytes : {false, true}) {
      if (number_at<std::int32_t>(bytes.data(), swap_bytes) != version.header_bytes)
        continue;
      bytes.resize(version.header_bytes);
      got += source.read(std::span(bytes).subspan(got));
      if (got < bytes.size())
        faults.fail("sizeof_hdr", fmt::format("a NIfTI header of {} bytes", version.header_bytes),
                    fmt::format("{} bytes", got));
      return Header(std::move(bytes), version, swap_bytes);
    }
  faults.fail("sizeof_hdr", "348 (NIfTI-1) or 540 (NIfTI-2), in either byte order",
              fmt::format("{}", number_at<std::int32_t>(bytes.data(), false)));
}

void check_magic(const Header& header, Faults& faults) {
  using namespace std::string_view_literals;
  const bool is_1 = header.version().number == 1;
  const std::string_view right = is_1 ? "n+1\0"sv : "n+2\0\r\n\x1a\n"sv;
  const std::string_view magic = header.text(header.version().magic, right.size());
  if (magic == right)
    return;
  const bool is_pair = magic.starts_with(is_1 ? "ni1"sv : "ni2"sv);
  faults.fail("magic", is_1 ? "\"n+1\"" : "\"n+2\" and its line ends",
              is_pair ? "a header whose data is in another file (.img)" : in_quotes(magic));
}

struct DataType {
  int code;
  const char* name;
  std::optional<ScalarType> scalar;
};
// clang-format off
const DataType data_types[] = {
    {2, "uint8", ScalarType::uint8},      {4, "int16", ScalarType::int16},      {8, "int32", ScalarType::int32},
    {256, "int8", ScalarType::int8},      {512, "uint16", ScalarType::uint16},  {768, "uint32", ScalarType::uint32},
    {1024, "int64", ScalarType::int64},   {1280, "uint64", ScalarType::uint64},
    {16, "float32", ScalarType::float32}, {64, "float64", ScalarType::float64},
    {1, "bits", {}},        {32, "complex64", {}},    {128, "rgb24", {}},       {1536, "float128", {}},
    {1792, "complex128", {}}, {2048, "complex256", {}}, {2304, "rgba32", {}},
};
// clang-format on

ValueLayout read_layout(const Header& header, Faults& faults) {
  ValueLayout layout;
  layout.swap_bytes = header.swap_bytes();
  const Version& version = header.version();
  const int code = header.short_integer(version.datatype);
  const auto* type = std::find_if(std::begin(data_types), std::end(data_types),
                                  [&](const DataType& candidate) { return candidate.code == code; });
  if (type == std::end(data_types) || !type->scalar) {
    faults.add("datatype", "integers of 8 to 64 bits, float32 or float64",
               type == std::end(data_types) ? fmt::format("{}", code)
                                            : fmt::format("{} ({})", code, type->name));
    return layout;
  }
  layout.type = *type->scalar;
  const std::int64_t bits = 8 * bytes_of(layout.type);
  if (header.short_integer(version.bitpix) != bits)
    faults.add("bitpix", fmt::format("{} for datatype {}", bits, type->name),
               fmt::format("{}", header.short_integer(version.bitpix)));
  // A slope of 0 means no scaling; some writers put NaN there for the same.
  const double slope = header.real(version.slope);
  if (std::isfinite(slope) && slope != 0) {
    layout.slope = slope;
    layout.intercept = header.real(version.intercept);
    if (!std::isfinite(layout.intercept))
      faults.add("scl_inter", "a finite number", fmt::format("{}", layout.intercept));
  }
  return layout;
}

void read_size(const Header& header, ImageInfo& info, Faults& faults) {
  const std::int64_t n_axes = header.dim(0);
  if (n_axes < 1 || n_axes > 7)
    faults.fail("dim[0]", "1 to 7 axes", fmt::format("{}", n_axes));
  std::array<std::int64_t, 8> size{1, 1, 1, 1, 1, 1, 1, 1};
  for (std::size_t axis = 1; axis <= static_cast<std::size_t>(n_axes); ++axis)
    size[axis] = header.dim(axis);
  for (const std::size_t axis : {6UL, 7UL})
    if (size[axis] != 1)
      faults.add(fmt::format("dim[{}]", axis), "1", fmt::format("{}", size[axis]));
  for (const std::size_t axis : {4UL, 5UL})
    if (size[axis] < 1)
      faults.add(fmt::format("dim[{}]", axis), "a number > 0", fmt::format("{}", size[axis]));
  faults.throw_if_any();
  std::int64_t components = 0;
  if (__builtin_mul_overflow(size[4], size[5], &components))
    components = std::numeric_limits<std::int64_t>::max();
  set_size(info, {size[1], size[2], size[3]}, {"dim[1]", "dim[2]", "dim[3]"}, components, "dim[4]", faults);
}

/// Method 3 of nifti1.h: the affine itself.
void read_sform(const Header& header, FileGeometry& geometry) {
  const std::size_t row_bytes = header.version().number == 1 ? 16 : 32;
  geometry.spacing_keys.fill("srow_x, srow_y, srow_z");
  geometry.origin_key = geometry.direction_key = geometry.spacing_keys[0];
  std::array<Vec3, 3> axes{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      axes[axis][row] = header.real(header.version().srow + row * row_bytes, axis);
    geometry.origin[row] = header.real(header.version().srow + row * row_bytes, 3);
  }
  geometry.set_axes(axes);
}

/// Spacing from pixdim; optional for axes that the image does not have.
void read_pixdim(const Header& header, FileGeometry& geometry) {
  geometry.spacing_keys = {"pixdim[1]", "pixdim[2]", "pixdim[3]"};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_left_out = static_cast<std::int64_t>(axis) >= header.dim(0) && header.pixdim(axis + 1) == 0;
    geometry.spacing[axis] = is_left_out ? 1 : header.pixdim(axis + 1);
  }
}

/// Method 2 of nifti1.h: a unit quaternion (a, b, c, d) with a >= 0 left out, and a sign for the third axis.
void read_qform(const Header& header, FileGeometry& geometry, Faults& faults) {
  const Version& version = header.version();
  const double b = header.real(version.quatern, 0);
  const double c = header.real(version.quatern, 1);
  const double d = header.real(version.quatern, 2);
  const double squares = b * b + c * c + d * d;
  constexpr double rounding = 1e-4; // of float32 squares, generously
  if (!(squares <= 1 + rounding)) {
    faults.add("quatern_b, quatern_c, quatern_d", "a sum of squares of at most 1",
               fmt::format("{}", squares));
    return;
  }
  // Rule of nifti1_io: this near to a half turn, the omitted component is only rounding error.
  const bool is_half_turn = 1 - squares < 1e-7;
  const double length = is_half_turn ? std::sqrt(squares) : 1;
  const double w = is_half_turn ? 0 : std::sqrt(1 - squares);
  const double x = b / length;
  const double y = c / length;
  const double z = d / length;
  const double third = header.pixdim(0) < 0 ? -1 : 1; // qfac; 0 counts as 1
  geometry.direction = {
      {{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), third * 2 * (x * z + w * y)},
       {2 * (x * y + w * z), w * w + y * y - x * x - z * z, third * 2 * (y * z - w * x)},
       {2 * (x * z - w * y), 2 * (y * z + w * x), third * (w * w + z * z - x * x - y * y)}}};
  geometry.direction_key = "quatern_b, quatern_c, quatern_d";
  geometry.origin_key = "qoffset_x, qoffset_y, qoffset_z";
  geometry.origin = {header.real(version.qoffset, 0), header.real(version.qoffset, 1),
                     header.real(version.qoffset, 2)};
}

/// Forms that position the voxels; the first is used (the sform, else the qform, else pixdim).
std::vector<FileGeometry> read_geometry(const Header& header, Faults& faults) {
  FileGeometry geometry;
  geometry.world = geometry.fallback = WorldAxes::ras;
  switch (header.length_unit()) {
  case 0: // unknown
  case 2:
    geometry.units_per_metre = 1e3;
    break;
  case 1:
    geometry.units_per_metre = 1;
    break;
  case 3:
    geometry.units_per_metre = 1e6;
    break;
  default:
    faults.add("xyzt_units", "0, 1 (m), 2 (mm) or 3 (micrometre) for lengths",
               fmt::format("{}", header.length_unit()));
  }
  std::vector<FileGeometry> stated;
  const bool has_sform = header.code(header.version().sform) > 0;
  if (has_sform) {
    stated.push_back(geometry);
    stated.back().name = "sform";
    read_sform(header, stated.back());
  }
  const bool is_empty = has_sform && std::ranges::max(stated.front().spacing) == 0;
  read_pixdim(header, geometry);
  if (header.code(header.version().qform) > 0) {
    Faults of_other("");
    geometry.name = "qform";
    read_qform(header, geometry, has_sform ? of_other : faults);
    if (of_other.all().empty())
      stated.push_back(geometry);
  } else if (!has_sform || is_empty) {
    geometry.name = "pixdim";
    geometry.world = WorldAxes::unknown;
    stated.push_back(geometry);
  }
  if (stated.empty())
    stated.push_back(geometry);
  return stated;
}

/// Reads the axes of vectors, and the order of a symmetric matrix.
void read_intent(const Header& header, OpenImage& image) {
  constexpr int symmetric_matrix = 1005, displacement = 1006, vector = 1007;
  const int intent = header.code(header.version().intent);
  image.layout.is_lower_triangle = intent == symmetric_matrix && image.info.components == 6;
  if (intent == displacement)
    image.info.vectors_to_world = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  else if (intent == vector) // ITK writes its own LPS here
    image.info.vectors_to_world = {{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}};
}

std::int64_t read_data_offset(const Header& header, Faults& faults) {
  const std::int64_t smallest = header.version().header_bytes + extension_flag_bytes;
  const double offset = header.vox_offset();
  if (offset == 0) // some writers omit it
    return smallest;
  if (!(offset >= static_cast<double>(smallest) && offset <= static_cast<double>(largest_offset)) ||
      offset != std::floor(offset)) {
    faults.add("vox_offset", fmt::format("a whole number from {} to {}", smallest, largest_offset),
               fmt::format("{}", offset));
    return smallest;
  }
  return static_cast<std::int64_t>(offset);
}

} // namespace

OpenImage open_nifti(const std::filesystem::path& file, Faults& faults) {
  const Header header = read_header(*open_bytes(file, faults), faults);
  check_magic(header, faults);
  OpenImage image;
  image.size_key = "dim";
  read_size(header, image.info, faults);
  image.layout = read_layout(header, faults);
  const std::vector<FileGeometry> stated = read_geometry(header, faults);
  set_geometry(image.info, stated.front(), faults, {stated.begin() + 1, stated.end()});
  read_intent(header, image);
  const std::int64_t offset = read_data_offset(header, faults);
  faults.throw_if_any();
  image.open_data = [file, offset, faults]() mutable {
    ByteSourcePtr source = open_bytes(file, faults);
    std::vector<char> skipped(4096);
    for (std::int64_t left = offset; left > 0;) {
      const auto count = static_cast<std::size_t>(std::min(left, std::int64_t{4096}));
      if (source->read(std::span(skipped).first(count)) < count)
        faults.fail("vox_offset", fmt::format("{} bytes before the data", offset), "the end of the file");
      left -= static_cast<std::int64_t>(count);
    }
    return source;
  };
  return image;
}

} // namespace maille::image_formats
