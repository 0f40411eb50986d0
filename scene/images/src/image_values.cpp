// Converts bytes to float32 values, and a header's grid to ours.

#include "image_formats.hpp"
#include "maille/images/layers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <tuple>
#include <type_traits>

namespace maille::image_formats {
namespace {

constexpr std::int64_t largest_exact_integer = std::int64_t{1} << 24; // float32 has 24 binary digits
constexpr double largest_float = std::numeric_limits<float>::max();
constexpr std::size_t chunk_values = std::size_t{1} << 17;

/// True if float32 represents an integer exactly.
template<class T>
bool survives_float32(T value) {
  if constexpr (sizeof(T) <= 2) {
    return true;
  } else {
    std::uint64_t magnitude = static_cast<std::uint64_t>(value);
    if (std::is_signed_v<T> && value < T{0})
      magnitude = std::uint64_t{0} - magnitude;
    return magnitude == 0 || magnitude >> std::countr_zero(magnitude) <= largest_exact_integer;
  }
}

template<class T>
class Decoder {
public:
  Decoder(const ValueLayout& layout, Faults& faults)
      : layout_(layout), is_scaled_(layout.slope != 1 || layout.intercept != 0), faults_(faults) {}

  /// True if values in the file need no conversion other than to float32, which is exact.
  bool is_plain() const {
    return (std::is_same_v<T, float> || sizeof(T) <= 2) && !is_scaled_ && !layout_.swap_bytes;
  }
  float operator()(const char* bytes) const {
    const T value = number_at<T>(bytes, layout_.swap_bytes);
    if constexpr (std::is_integral_v<T>) {
      if (!is_scaled_ && !survives_float32(value))
        faults_.fail("data", "integers that float32 holds exactly (all up to 2^24)",
                     fmt::format("{}", value));
    }
    if (!is_scaled_ && !std::is_same_v<T, double>)
      return static_cast<float>(value);
    const double scaled = layout_.slope * static_cast<double>(value) + layout_.intercept;
    // Keeps infinities and NaN of the file; a finite value must not overflow.
    if (std::abs(scaled) > largest_float && !is_infinite(value))
      faults_.fail("data", "values within float32", fmt::format("{}", scaled));
    return static_cast<float>(scaled);
  }

private:
  static bool is_infinite(T value) {
    if constexpr (std::is_floating_point_v<T>)
      return std::isinf(value);
    else
      return false;
  }
  ValueLayout layout_;
  bool is_scaled_;
  Faults& faults_;
};

/// In the order of ScalarType.
using ScalarTypes = std::tuple<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t,
                               std::uint32_t, std::int64_t, std::uint64_t, float, double>;

/// Calls use(T{}) for the named type T.
template<std::size_t n = 0, class Use>
auto with_type(ScalarType type, const Use& use) {
  if constexpr (n + 1 < std::tuple_size_v<ScalarTypes>)
    if (static_cast<std::size_t>(type) != n)
      return with_type<n + 1>(type, use);
  return use(std::tuple_element_t<n, ScalarTypes>{});
}

std::int64_t n_values(const ImageInfo& info) {
  return info.n_voxels() * info.components;
}

/// Grows geometrically, up to the final size.
void grow(std::vector<float>& values, std::size_t to, std::size_t in_the_end) {
  if (to > values.capacity())
    values.reserve(std::min(std::max(to, 2 * values.capacity()), in_the_end));
  values.resize(to);
}

std::vector<float> planar(const std::vector<float>& interleaved, std::size_t components) {
  std::vector<float> values(interleaved.size());
  const std::size_t n_voxels = interleaved.size() / components;
  for (std::size_t component = 0; component < components; ++component)
    for (std::size_t voxel = 0; voxel < n_voxels; ++voxel)
      values[component * n_voxels + voxel] = interleaved[voxel * components + component];
  return values;
}

} // namespace

std::int64_t bytes_of(ScalarType type) {
  return with_type(type, []<class T>(T) { return std::int64_t{sizeof(T)}; });
}

std::optional<ScalarType> scalar_type_named(std::string_view name) {
  // MetaIO's long has 32 bits on every machine (its metaTypes.h).
  static constexpr std::array<std::pair<ScalarType, std::string_view>, 10> types{{
      {ScalarType::int8, "|MET_CHAR|signed char|int8|int8_t|"},
      {ScalarType::uint8, "|MET_UCHAR|uchar|unsigned char|uint8|uint8_t|"},
      {ScalarType::int16, "|MET_SHORT|short|short int|signed short|signed short int|int16|int16_t|"},
      {ScalarType::uint16, "|MET_USHORT|ushort|unsigned short|unsigned short int|uint16|uint16_t|"},
      {ScalarType::int32, "|MET_INT|MET_LONG|int|signed int|int32|int32_t|"},
      {ScalarType::uint32, "|MET_UINT|MET_ULONG|uint|unsigned int|uint32|uint32_t|"},
      {ScalarType::int64, "|MET_LONG_LONG|longlong|long long|long long int|signed long long|signed long long "
                          "int|int64|int64_t|"},
      {ScalarType::uint64,
       "|MET_ULONG_LONG|ulonglong|unsigned long long|unsigned long long int|uint64|uint64_t|"},
      {ScalarType::float32, "|MET_FLOAT|float|"},
      {ScalarType::float64, "|MET_DOUBLE|double|"},
  }};
  const std::string quoted = fmt::format("|{}|", name);
  const auto found = std::ranges::find_if(
      types, [&](const auto& type) { return type.second.find(quoted) != std::string::npos; });
  return found == types.end() ? std::nullopt : std::optional(found->first);
}

bool must_swap(bool is_big_endian) {
  return is_big_endian != (std::endian::native == std::endian::big);
}

template<class T>
std::optional<std::vector<T>> parse_numbers(std::string_view text, std::size_t count) {
  std::vector<T> numbers;
  while (true) {
    const std::size_t start = text.find_first_not_of(" \t\r\n");
    if (start == std::string_view::npos)
      break;
    text.remove_prefix(start);
    const std::string_view token = text.substr(0, text.find_first_of(" \t\r\n"));
    const char* from = token.data() + (token.front() == '+' && token.size() > 1 ? 1 : 0);
    T number{};
    const auto [end, error] = std::from_chars(from, token.data() + token.size(), number);
    if (error != std::errc{} || end != token.data() + token.size() || numbers.size() == count)
      return std::nullopt;
    numbers.push_back(number);
    text.remove_prefix(token.size());
  }
  if (numbers.size() != count)
    return std::nullopt;
  return numbers;
}
template std::optional<std::vector<std::int64_t>> parse_numbers(std::string_view, std::size_t);
template std::optional<std::vector<double>> parse_numbers(std::string_view, std::size_t);

void set_size(ImageInfo& info, const std::array<std::int64_t, 3>& size,
              const std::array<std::string, 3>& size_keys, std::int64_t components,
              const std::string& components_key, Faults& faults) {
  constexpr std::int64_t largest = std::numeric_limits<int>::max();
  const std::string expected = fmt::format("1 to {}", largest);
  std::int64_t bytes = 8; // as float64, so that neither the file's nor our size overflows
  bool is_countable = true;
  const auto check = [&](std::int64_t count, const std::string& key) {
    if (count < 1 || count > largest) {
      faults.add(key, expected, fmt::format("{}", count));
      return 1;
    }
    is_countable = is_countable && !__builtin_mul_overflow(bytes, count, &bytes);
    return static_cast<int>(count);
  };
  for (std::size_t axis = 0; axis < 3; ++axis)
    info.size[axis] = check(size[axis], size_keys[axis]);
  info.components = check(components, components_key);
  if (!is_countable)
    faults.add(size_keys[0], "a size that can be counted in bytes",
               fmt::format("{} x {} x {} voxels of {} components", size[0], size[1], size[2], components));
}

template<class T>
void ValueReader::read_as(std::size_t count, std::vector<float>& values) {
  const Decoder<T> decode(layout_, faults_);
  const std::size_t end = values.size() + count;
  if (values.capacity() < end && static_cast<std::size_t>(source_->bytes_left()) / sizeof(T) >= count)
    values.reserve(end);
  buffer_.resize(std::max(buffer_.size(), std::min(chunk_values, count) * sizeof(T)));
  while (values.size() < end) {
    const std::size_t first = values.size();
    const std::size_t n = std::min(chunk_values, end - first);
    const std::size_t got = source_->read(std::span(buffer_).first(n * sizeof(T)));
    if (got < n * sizeof(T))
      faults_.fail("data", fmt::format("{} bytes", wanted_ * sizeof(T)),
                   fmt::format("{} bytes{}", done_ * sizeof(T) + got,
                               source_->is_cut_short() ? "; the encoded data ends early" : ""));
    grow(values, first + n, end);
    if (decode.is_plain())
      for (std::size_t i = 0; i < n; ++i)
        values[first + i] = static_cast<float>(number_at<T>(buffer_.data() + i * sizeof(T), false));
    else
      for (std::size_t i = 0; i < n; ++i)
        values[first + i] = decode(buffer_.data() + i * sizeof(T));
    done_ += n;
  }
  if (done_ < wanted_)
    return;
  // Reads further, so that compressed data verify their checksum, and to detect sizes that are too small.
  constexpr std::size_t most_surplus = 1 << 20; // more is another image or a decompression bomb
  buffer_.resize(std::max(buffer_.size(), std::size_t{1} << 16));
  std::size_t surplus = 0;
  while (const std::size_t got = surplus > most_surplus ? 0 : source_->read(buffer_))
    surplus += got;
  if (surplus > most_surplus)
    faults_.fail("data", fmt::format("{} bytes", wanted_ * sizeof(T)), "more");
  if (surplus > 0)
    warn_of_file(faults_.file(), fmt::format("has {} bytes behind the {} of its data: they are left", surplus,
                                             wanted_ * sizeof(T)));
  if (source_->is_cut_short())
    faults_.fail("data", "complete encoded data", "data that ends early, before its check sum");
}

ValueReader::ValueReader(const OpenImage& image, Faults faults)
    : layout_(image.layout), faults_(std::move(faults)), source_(image.open_data()),
      wanted_(static_cast<std::size_t>(n_values(image.info))) {}

void ValueReader::read(std::size_t count, std::vector<float>& values) {
  with_type(layout_.type, [&]<class T>(T) { read_as<T>(count, values); });
}

std::vector<float> read_values(const OpenImage& image, const Faults& faults) {
  std::vector<float> values;
  ValueReader(image, faults).read(static_cast<std::size_t>(n_values(image.info)), values);
  if (image.layout.component_fastest && image.info.components > 1)
    values = planar(values, static_cast<std::size_t>(image.info.components));
  if (!image.layout.is_lower_triangle)
    return values;
  std::vector<float> ordered;
  ordered.reserve(values.size());
  const auto n = static_cast<std::ptrdiff_t>(image.info.n_voxels());
  for (const std::ptrdiff_t component : {0, 2, 5, 1, 3, 4})
    ordered.insert(ordered.end(), values.begin() + component * n, values.begin() + (component + 1) * n);
  return ordered;
}

} // namespace maille::image_formats

namespace maille {

void LayerWindow::move_to(int low, int high) {
  high = std::min(high, info_.size[2]);
  if (end_ >= high)
    return;
  for (; end_ < high; ++end_) {
    const int gone = std::min(low, end_) - first_;
    if (gone > 0 && gone >= end_ - first_ - gone) {
      values_.erase(values_.begin(), values_.begin() + static_cast<std::ptrdiff_t>(
                                                           static_cast<std::size_t>(gone) * layer_size()));
      first_ += gone;
    }
    next_(end_, values_);
  }
  data_ = values_.data();
  first_voxel_ = static_cast<std::size_t>(first_) * layer_size();
}

} // namespace maille
