#pragma once
/// What the image readers share: faults, sources of bytes, the numbers in them, and the geometry of a grid.
/// Private to images. Every header is taken to be hostile: sizes are checked before anything is allocated,
/// and memory grows no faster than the file fills it.

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

/// The faults of one file, gathered so that all are told at once.
class Faults {
public:
  explicit Faults(std::string file) : file_(std::move(file)) {}
  void add(std::string key, std::string expected, std::string found);
  /// Adds a fault after which reading makes no sense, and throws all.
  [[noreturn]] void fail(std::string key, std::string expected, std::string found);
  /// @throws InputError if there are any
  void throw_if_any() const;
  const std::vector<Fault>& all() const { return faults_; }
  const std::string& file() const { return file_; }

private:
  std::string file_;
  std::vector<Fault> faults_;
};

/// `.nii.gz`, in small letters; empty for a file that is no image.
std::string ending_of(const std::filesystem::path& file);

/// Text from a file made fit for a message: quoted, cut, without unprintable characters.
std::string in_quotes(std::string_view text);

// ---- bytes ------------------------------------------------------------------------------------------------

/// Bytes that are read once, from first to last.
class ByteSource {
public:
  ByteSource() = default;
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;
  virtual ~ByteSource() = default;
  /// Fills `to`; fewer bytes than it holds mean the end.
  /// @throws InputError: damaged encoding
  virtual std::size_t read(std::span<char> to) = 0;
  /// Whether the end came earlier than the encoding itself announces; known once read() gave too few.
  virtual bool is_cut_short() const { return false; }
  /// How many are surely left, as far as that is known without reading: 0 where it is not.
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

/// What a header of lines states, and where its data begin if they follow in the same file.
struct TextHeader {
  std::map<std::string, std::string> fields, keys; ///< keys: NRRD's own, `key:=value`
  std::int64_t bytes = 0;
  std::optional<std::string> field(const std::string& name) const;
};
/// Calls take(line) for the lines of the first `largest` bytes until it is false. @return whether it was
bool read_header_lines(TextHeader& header, const std::filesystem::path& file, std::size_t largest,
                       Faults& faults, const std::function<bool(std::string_view line)>& take);
std::string_view without_blanks(std::string_view text);
/// A fault where the field has another value already.
void set_field(std::map<std::string, std::string>& fields, const std::string& name, std::string_view value,
               Faults& faults);
/// The file that a header names for its data: in its folder or below, else a fault.
std::filesystem::path data_beside(const std::filesystem::path& header, const std::string& key,
                                  const std::string& name, const char* expected, Faults& faults);
std::function<ByteSourcePtr()> data_in(const std::filesystem::path& file, std::int64_t from,
                                       std::optional<Compression> compression, const Faults& faults);

// ---- numbers ----------------------------------------------------------------------------------------------

enum class ScalarType { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };
std::int64_t bytes_of(ScalarType type);
/// By its name in MetaImage or NRRD.
std::optional<ScalarType> scalar_type_named(std::string_view name);

/// Whether numbers of that byte order have to be turned round on this machine.
bool must_swap(bool is_big_endian);

/// The number at the start of `bytes`, which has to hold it.
template<class T>
T number_at(const char* bytes, bool swap_bytes) {
  std::array<char, sizeof(T)> turned{};
  std::memcpy(turned.data(), bytes, sizeof(T));
  if (swap_bytes)
    std::reverse(turned.begin(), turned.end());
  return std::bit_cast<T>(turned);
}

/// Exactly `count` numbers parted by white space; nothing if there are more, fewer, or others.
/// T: std::int64_t or double.
template<class T>
std::optional<std::vector<T>> parse_numbers(std::string_view text, std::size_t count);

/// How the values lie in the bytes.
struct ValueLayout {
  ScalarType type = ScalarType::uint8;
  bool swap_bytes = false;
  bool component_fastest = false; ///< as in MetaImage and vti; NIfTI has the component slowest
  double slope = 1;
  double intercept = 0;
  bool is_lower_triangle =
      false; ///< six components xx xy yy xz yz zz (NIfTI 1005), given as xx yy zz xy xz yz
};

/// An image whose header is read and found sound.
struct OpenImage {
  ImageInfo info;
  ValueLayout layout;
  std::string size_key; ///< header field that states the size
  std::function<ByteSourcePtr()> open_data;
};

/// Largest decoded image [bytes] that the limits allow.
std::int64_t largest_bytes(const ImageLimits& limits);

/// Sets size and components. Each has to be > 0, and the decoded image countable in bytes.
void set_size(ImageInfo& info, const std::array<std::int64_t, 3>& size,
              const std::array<std::string, 3>& size_keys, std::int64_t components,
              const std::string& components_key, Faults& faults);

/// Reads an image's values, part after part, in the order of its file.
class ValueReader {
public:
  ValueReader(const OpenImage& image, Faults faults);
  /// Appends the next values, in memory that grows with what the source really has. Behind the last one there
  /// must be no more.
  /// @throws InputError: too few or too many bytes, or values that float32 cannot hold
  void read(std::size_t count, std::vector<float>& values);

private:
  template<class T>
  void read_as(std::size_t count, std::vector<float>& values);

  ValueLayout layout_;
  Faults faults_;
  ByteSourcePtr source_;
  std::size_t wanted_, done_ = 0; ///< values of the image
  std::vector<char> buffer_;
};

/// All values, component slowest. @throws InputError, as ValueReader
std::vector<float> read_values(const OpenImage& image, const Faults& faults);

// ---- geometry ---------------------------------------------------------------------------------------------

/// The grid of an image in the file's unit of length.
struct FileGeometry {
  const char* name = ""; ///< of what states it, e.g. sform
  bool states_spacing = true;
  WorldAxes world = WorldAxes::unknown; ///< as the header states
  WorldAxes fallback = WorldAxes::lps;  ///< where it does not: that of ITK, of NIfTI ras
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

/// The one rule for where an image lies, in metres, the direction orthonormal to rounding, and in which
/// world.
///
/// `stated` counts. Columns that are off unit length or a right angle by more than 1e-3 span no grid of boxes
/// (a form of zeros, too): then the first of `others` that spans one counts, with a warning, else a fault.
/// Others that lie elsewhere by more than a hundredth of a voxel are warned of. A world that is not stated is
/// the fallback, with a warning.
void set_geometry(ImageInfo& info, const FileGeometry& stated, Faults& faults,
                  const std::vector<FileGeometry>& others = {});

// ---- formats ----------------------------------------------------------------------------------------------

OpenImage open_nifti(const std::filesystem::path& file, Faults& faults);
OpenImage open_meta_image(const std::filesystem::path& file, Faults& faults);
/// The file that holds the data of a MetaImage: itself, or the one that its header names. @throws InputError
std::filesystem::path data_file_of_meta_image(const std::filesystem::path& file, Faults& faults);
OpenImage open_nrrd(const std::filesystem::path& file, Faults& faults);
/// Likewise of a NRRD header.
std::filesystem::path data_file_of_nrrd(const std::filesystem::path& file, Faults& faults);
OpenImage open_vti(const std::filesystem::path& file, Faults& faults);
/// Whether it is a folder, or a file that begins as DICOM files do.
bool is_dicom(const std::filesystem::path& place);
/// A series: the slices of a folder, or those beside a file that are of its series.
/// @throws InputError: no DICOM or several series, slices that are unlike, missing, twice there, not in a row
OpenImage open_dicom(const std::filesystem::path& place, Faults& faults);
/// All files beside each other among which the series is.
std::vector<std::filesystem::path> files_of_dicom(const std::filesystem::path& place);

} // namespace maille::image_formats
