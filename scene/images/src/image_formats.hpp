#pragma once
/// Common code of the image readers: faults, sources of bytes, numbers, and grid geometry. Private to images.
/// All headers are untrusted: sizes are checked before allocation, and memory grows only as the file fills
/// it.

#include "maille/images/image.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace maille::image_formats {

/// The faults of one file, collected to report all at once.
class Faults {
public:
  explicit Faults(std::string file) : file_(std::move(file)) {}
  void add(std::string key, std::string expected, std::string found);
  /// Adds a fault that prevents further reading, and throws all.
  [[noreturn]] void fail(std::string key, std::string expected, std::string found);
  /// @throws InputError if there are any
  void throw_if_any() const;
  const std::vector<Fault>& all() const { return faults_; }
  const std::string& file() const { return file_; }

private:
  std::string file_;
  std::vector<Fault> faults_;
};

/// File name ending in lower case, e.g. `.nii.gz`; empty for a file that is no image.
std::string ending_of(const std::filesystem::path& file);

/// Text from a file for a message: quoted, truncated, without unprintable characters.
std::string in_quotes(std::string_view text);

// ---- bytes ------------------------------------------------------------------------------------------------

/// Bytes that are read once, sequentially.
class ByteSource {
public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;
  /// Fills `to`; returns fewer bytes at the end.
  /// @throws InputError: damaged encoding
  virtual std::size_t read(std::span<char> to) = 0;
  /// True if the data end earlier than the encoding states; valid after read() returned too few bytes.
  virtual bool is_cut_short() const { return false; }
  /// Lower bound of the remaining bytes that is known without reading; may be 0.
  virtual std::int64_t bytes_left() { return 0; }
};
using ByteSourcePtr = std::shared_ptr<ByteSource>;

/// Size of a regular file. @throws InputError: missing, or a folder, pipe or device
std::int64_t size_of_file(const std::filesystem::path& file, Faults& faults);
ByteSourcePtr open_file(const std::filesystem::path& file, std::int64_t from, Faults& faults);
/// gzip: one or more members, as in .gz files. zlib: one stream, zlib or gzip, and nothing after it.
enum class Compression { gzip, zlib };
ByteSourcePtr inflated(ByteSourcePtr source, Compression compression, const Faults& faults);

// ---- headers of text (MetaImage, NRRD) --------------------------------------------------------------------

/// Fields of a text header, and the start of the data if they follow in the same file.
struct TextHeader {
  std::map<std::string, std::string> fields, keys; ///< keys: NRRD's own, `key:=value`
  std::int64_t bytes = 0;
  std::optional<std::string> field(const std::string& name) const;
};
/// Calls take(line) for the lines of the first `largest` bytes until it returns false. @return true if it did
bool read_header_lines(TextHeader& header, const std::filesystem::path& file, std::size_t largest,
                       Faults& faults, const std::function<bool(std::string_view line)>& take);
std::string_view without_blanks(std::string_view text);
/// Sets a field; a fault if it already has another value.
void set_field(std::map<std::string, std::string>& fields, const std::string& name, std::string_view value,
               Faults& faults);
/// The data file that a header names: in its folder or below, else a fault.
std::filesystem::path data_beside(const std::filesystem::path& header, const std::string& key,
                                  const std::string& name, const char* expected, Faults& faults);
std::function<ByteSourcePtr()> data_in(const std::filesystem::path& file, std::int64_t from,
                                       std::optional<Compression> compression, const Faults& faults);

// ---- numbers ----------------------------------------------------------------------------------------------

enum class ScalarType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };
std::int64_t bytes_of(ScalarType type);
/// Type by its name in MetaImage or NRRD.
std::optional<ScalarType> scalar_type_named(std::string_view name);

/// True if numbers of that byte order must be swapped on this machine.
bool must_swap(bool is_big_endian);

/// The number at the start of `bytes`. @pre `bytes` is long enough
template<class T>
T number_at(const char* bytes, bool swap_bytes) {
  std::array<char, sizeof(T)> turned{};
  std::memcpy(turned.data(), bytes, sizeof(T));
  if (swap_bytes)
    std::reverse(turned.begin(), turned.end());
  return std::bit_cast<T>(turned);
}

/// Exactly `count` numbers separated by white space; nothing for more, fewer, or other text.
/// T: std::int64_t or double.
template<class T>
std::optional<std::vector<T>> parse_numbers(std::string_view text, std::size_t count);

/// Layout of the values in the bytes.
struct ValueLayout {
  ScalarType type = ScalarType::uint8;
  bool swap_bytes = false;
  bool component_fastest = false; ///< as in MetaImage and vti; NIfTI has the component slowest
  double slope = 1;
  double intercept = 0;
  bool is_lower_triangle =
      false; ///< six components xx xy yy xz yz zz (NIfTI 1005), given as xx yy zz xy xz yz
};

/// An image with a valid header.
struct OpenImage {
  ImageInfo info;
  ValueLayout layout;
  std::string size_key; ///< header field that states the size
  std::function<ByteSourcePtr()> open_data;
};

/// Largest decoded image [bytes] that the limits allow.
std::int64_t largest_bytes(const ImageLimits& limits);

/// Sets size and components. Each must be > 0, and the number of bytes representable.
void set_size(ImageInfo& info, const std::array<std::int64_t, 3>& size,
              const std::array<std::string, 3>& size_keys, std::int64_t components,
              const std::string& components_key, Faults& faults);

/// Reads an image's values in parts, in file order.
class ValueReader {
public:
  ValueReader(const OpenImage& image, Faults faults);
  /// Appends the next values; memory grows with the actual data. None may follow the last one.
  /// @throws InputError: too few or too many bytes, or values that float32 cannot hold
  void read(std::size_t count, std::vector<float>& values);

private:
  template<class T>
  void read_as(std::size_t count, std::vector<float>& values);

  ValueLayout layout_;
  Faults faults_;
  ByteSourcePtr source_;
  std::size_t wanted_, done_ = 0; ///< number of values of the image
  std::vector<char> buffer_;
};

/// All values, component slowest. @throws InputError, as ValueReader
std::vector<float> read_values(const OpenImage& image, const Faults& faults);

// ---- geometry ---------------------------------------------------------------------------------------------

/// The grid of an image in the file's unit of length.
struct FileGeometry {
  const char* name = ""; ///< name of the form, e.g. sform
  bool states_spacing = true;
  WorldAxes world = WorldAxes::unknown; ///< as the header states
  WorldAxes fallback = WorldAxes::lps;  ///< without a statement: that of ITK; ras for NIfTI
  Vec3 spacing{1, 1, 1};
  Vec3 origin{0, 0, 0};
  std::array<Vec3, 3> direction{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; ///< rows; columns are the image's axes
  double units_per_metre = 1000;
  std::array<std::string, 3> spacing_keys;
  std::string origin_key;
  std::string direction_key;

  /// Spacing and direction. @param axes from a voxel to the next one along each axis
  void set_axes(const std::array<Vec3, 3>& axes);
};

/// Sets position, direction (orthonormal to rounding) and world of an image, in metres, for all formats.
///
/// `stated` is used. If its columns deviate from unit length or a right angle by more than 1e-3 (a form of
/// zeros, too), the first valid form of `others` is used with a warning; without one: a fault. Warns of valid
/// others that differ by more than a hundredth of a voxel. If no world is stated, uses the fallback with a
/// warning.
void set_geometry(ImageInfo& info, const FileGeometry& stated, Faults& faults,
                  const std::vector<FileGeometry>& others = {});

// ---- formats ----------------------------------------------------------------------------------------------

OpenImage open_nifti(const std::filesystem::path& file, Faults& faults);
OpenImage open_meta_image(const std::filesystem::path& file, Faults& faults);
/// The data file of a MetaImage: itself, or the one that its header names. @throws InputError
std::filesystem::path data_file_of_meta_image(const std::filesystem::path& file, Faults& faults);
OpenImage open_nrrd(const std::filesystem::path& file, Faults& faults);
/// The same for an NRRD header.
std::filesystem::path data_file_of_nrrd(const std::filesystem::path& file, Faults& faults);
OpenImage open_vti(const std::filesystem::path& file, Faults& faults);
/// True for a folder, or a file that begins as DICOM files do.
bool is_dicom(const std::filesystem::path& place);
/// A series: the slices of a folder, or those of the series of a file, in its folder.
/// @throws InputError: no DICOM or several series, inconsistent, missing, duplicate or unaligned slices
OpenImage open_dicom(const std::filesystem::path& place, Faults& faults);
/// All files of the folder that contains the series.
std::vector<std::filesystem::path> files_of_dicom(const std::filesystem::path& place);

} // namespace maille::image_formats
