// How VTK encodes an array: as text, or as a header of counts and then bytes, deflated in blocks or not, raw
// or in base64, in the XML or appended behind it.
//
//   not compressed   [n_bytes] bytes
//   compressed       [n_blocks] [block_bytes] [last_block_bytes, 0 if full] [compressed_bytes] x n_blocks,
//   blocks
//
// Source: VTK File Formats (Kitware), section on XML formats.

#include "image/image_vti_data.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <limits>
#include <map>

namespace maille::image_formats {
namespace {

constexpr std::int64_t largest_count = std::numeric_limits<std::int64_t>::max();

/// Reads the counts before an array.
class CountReader {
public:
  CountReader(ByteSource& source, const VtiFile& vti, std::string key, Faults& faults)
      : source_(source), vti_(vti), key_(std::move(key)), faults_(faults) {}

  std::int64_t next() {
    std::array<char, 8> word{};
    const std::size_t bytes = vti_.has_wide_header ? 8 : 4;
    if (source_.read(std::span(word).first(bytes)) < bytes)
      faults_.fail(key_, fmt::format("a header of {}-byte counts", bytes), "the end of the data");
    const std::uint64_t count = vti_.has_wide_header ? number_at<std::uint64_t>(word.data(), vti_.swap_bytes)
                                                     : number_at<std::uint32_t>(word.data(), vti_.swap_bytes);
    if (count > static_cast<std::uint64_t>(largest_count))
      faults_.fail(key_, "counts that are possible", fmt::format("{}", count));
    return static_cast<std::int64_t>(count);
  }

private:
  ByteSource& source_;
  const VtiFile& vti_;
  std::string key_;
  Faults& faults_;
};

void check_bytes(const std::string& key, std::optional<std::int64_t> expected, std::int64_t found,
                 Faults& faults) {
  if (expected && *expected != found)
    faults.fail(key, fmt::format("{} bytes", *expected), fmt::format("{} bytes", found));
}

/// A block of LZ4, in memory that grows no faster than 255 times what it is made of.
///
/// Source: LZ4 block format. A token holds two lengths of four bits, 15 of which go on in bytes up to one
/// below 255: literals, then a match at least 4 long, some bytes back.
std::string lz4_expanded(std::string_view from, std::int64_t size, const std::string& key, Faults& faults) {
  std::string to;
  const auto damaged = [&] { faults.fail(key, "a block of LZ4", "one that is damaged"); };
  const auto byte = [&] {
    if (from.empty())
      damaged();
    const auto value = static_cast<unsigned char>(from.front());
    from.remove_prefix(1);
    return std::int64_t{value};
  };
  const auto length = [&](std::int64_t nibble) {
    for (std::int64_t more = nibble == 15 ? 255 : 0; more == 255; nibble += more)
      more = byte();
    return nibble;
  };
  while (!from.empty()) {
    const std::int64_t token = byte(), literals = length(token >> 4);
    if (literals > std::ssize(from) || literals > size - std::ssize(to))
      damaged();
    to.append(from.begin(), from.begin() + literals);
    from = {from.begin() + literals, from.end()};
    if (from.empty())
      break;
    const std::int64_t low = byte(), back = low | byte() << 8, match = length(token & 15) + 4;
    if (back == 0 || back > std::ssize(to) || match > size - std::ssize(to))
      damaged();
    for (std::int64_t i = 0; i < match; ++i)
      to.push_back(*(to.end() - back));
  }
  if (std::ssize(to) != size)
    damaged();
  return to;
}

/// Blocks that are compressed one by one.
class BlockSource final : public ByteSource {
public:
  BlockSource(ByteSourcePtr source, const VtiFile& vti, const std::string& key,
              std::optional<std::int64_t> expected, Faults& faults)
      : source_(std::move(source)), key_(key), faults_(faults), is_lz4_(vti.is_lz4) {
    CountReader counts(*source_, vti, key, faults);
    const std::int64_t n_blocks = counts.next();
    block_bytes_ = counts.next();
    last_bytes_ = counts.next();
    if (last_bytes_ == 0)
      last_bytes_ = block_bytes_;
    std::int64_t bytes = 0;
    const bool is_countable =
        !__builtin_mul_overflow(std::max(n_blocks - 1, std::int64_t{0}), block_bytes_, &bytes) &&
        !__builtin_add_overflow(bytes, n_blocks > 0 ? last_bytes_ : 0, &bytes);
    if (!is_countable || (n_blocks > 0 && (block_bytes_ == 0 || last_bytes_ > block_bytes_)))
      faults.fail(key, "blocks of possible sizes",
                  fmt::format("{} of {} bytes, the last of {}", n_blocks, block_bytes_, last_bytes_));
    check_bytes(key, expected, bytes, faults);
    // One by one: the list grows only as far as the file has counts in it.
    for (std::int64_t block = 0; block < n_blocks; ++block)
      compressed_bytes_.push_back(counts.next());
  }

  std::size_t read(std::span<char> to) override {
    std::size_t done = 0;
    while (done < to.size() && open_block()) {
      const auto count = std::min(static_cast<std::int64_t>(to.size() - done), block_left_);
      const std::size_t got = block_->read(to.subspan(done, static_cast<std::size_t>(count)));
      done += got;
      block_left_ -= static_cast<std::int64_t>(got);
      if (static_cast<std::int64_t>(got) < count)
        return fall_short(done);
      if (block_left_ == 0)
        close_block();
    }
    return done;
  }
  bool is_cut_short() const override { return is_cut_short_; }

private:
  bool open_block() {
    if (block_)
      return true;
    if (is_cut_short_ || n_opened_ == compressed_bytes_.size())
      return false;
    const ByteSourcePtr compressed = first_bytes(source_, compressed_bytes_[n_opened_++]);
    block_left_ = n_opened_ == compressed_bytes_.size() ? last_bytes_ : block_bytes_;
    if (is_lz4_) {
      std::array<char, 1 << 14> part{};
      std::string bytes;
      for (std::size_t got = part.size(); got == part.size();)
        bytes.append(part.data(), got = compressed->read(part));
      expanded_ = lz4_expanded(bytes, block_left_, key_, faults_);
      block_ = open_text(expanded_);
    } else {
      block_ = inflated(compressed, Compression::zlib, faults_);
    }
    return true;
  }
  /// A block has to end where its header says, with its check sum.
  void close_block() {
    char surplus = 0;
    const bool has_more = block_->read(std::span(&surplus, 1)) > 0;
    if (has_more || block_->is_cut_short())
      faults_.fail(key_, "blocks as long as their header says",
                   fmt::format("block {} {}", n_opened_, has_more ? "longer" : "cut short"));
    block_.reset();
  }
  std::size_t fall_short(std::size_t done) {
    is_cut_short_ = true;
    block_.reset();
    return done;
  }

  ByteSourcePtr source_;
  std::string key_;
  Faults faults_;
  std::vector<std::int64_t> compressed_bytes_;
  std::int64_t block_bytes_ = 0;
  std::int64_t last_bytes_ = 0;
  std::size_t n_opened_ = 0;
  ByteSourcePtr block_;
  bool is_lz4_;
  std::string expanded_; ///< of LZ4
  std::int64_t block_left_ = 0;
  bool is_cut_short_ = false;
};

/// Numbers as text, handed out as the bytes that they would have in this machine's memory.
template<class T>
class AsciiSource final : public ByteSource {
public:
  AsciiSource(std::string_view text, std::string key, const Faults& faults)
      : text_(text), key_(std::move(key)), faults_(faults) {}
  std::size_t read(std::span<char> to) override {
    std::size_t done = 0;
    while (done < to.size()) {
      if (next_ == sizeof(T) && !decode_number())
        break;
      to[done++] = bytes_[next_++];
    }
    return done;
  }

private:
  bool decode_number() {
    constexpr const char* space = " \t\r\n";
    text_.remove_prefix(std::min(text_.find_first_not_of(space), text_.size()));
    if (text_.empty())
      return false;
    const std::string_view token = text_.substr(0, text_.find_first_of(space));
    T number{};
    const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), number);
    if (error != std::errc{} || end != token.data() + token.size())
      faults_.fail(key_, "numbers within the array's type", in_quotes(token));
    std::memcpy(bytes_.data(), &number, sizeof(T));
    next_ = 0;
    text_.remove_prefix(token.size());
    return true;
  }
  std::string_view text_;
  std::string key_;
  Faults faults_;
  std::array<char, sizeof(T)> bytes_{};
  std::size_t next_ = sizeof(T);
};

ByteSourcePtr open_ascii(std::string_view text, ScalarType type, const std::string& key,
                         const Faults& faults) {
  switch (type) {
  case ScalarType::int8:
    return std::make_shared<AsciiSource<std::int8_t>>(text, key, faults);
  case ScalarType::uint8:
    return std::make_shared<AsciiSource<std::uint8_t>>(text, key, faults);
  case ScalarType::int16:
    return std::make_shared<AsciiSource<std::int16_t>>(text, key, faults);
  case ScalarType::uint16:
    return std::make_shared<AsciiSource<std::uint16_t>>(text, key, faults);
  case ScalarType::int32:
    return std::make_shared<AsciiSource<std::int32_t>>(text, key, faults);
  case ScalarType::uint32:
    return std::make_shared<AsciiSource<std::uint32_t>>(text, key, faults);
  case ScalarType::int64:
    return std::make_shared<AsciiSource<std::int64_t>>(text, key, faults);
  case ScalarType::uint64:
    return std::make_shared<AsciiSource<std::uint64_t>>(text, key, faults);
  case ScalarType::float32:
    return std::make_shared<AsciiSource<float>>(text, key, faults);
  case ScalarType::float64:
    return std::make_shared<AsciiSource<double>>(text, key, faults);
  }
  return nullptr;
}

/// Offset of an appended array within the file, or nothing if it has no possible one.
std::optional<std::int64_t> position(const VtiFile& vti, pugi::xml_node array) {
  const auto offset = parse_numbers<std::int64_t>(array.attribute("offset").value(), 1);
  std::int64_t from = 0;
  if (vti.appended_from == 0 || !offset || offset->front() < 0 ||
      __builtin_add_overflow(vti.appended_from, offset->front(), &from))
    return std::nullopt;
  return from;
}

ByteSourcePtr open_encoded(const std::shared_ptr<VtiFile>& vti, pugi::xml_node array, Faults& faults) {
  if (std::string_view(array.attribute("format").value()) == "binary")
    return base64_decoded(open_text(array.child_value()), faults);
  ByteSourcePtr source = open_file(vti->file, position(*vti, array).value_or(0), faults);
  return vti->is_appended_raw ? source : base64_decoded(std::move(source), faults);
}

} // namespace

std::optional<ScalarType> vti_scalar_type(std::string_view name) {
  static const std::map<std::string_view, ScalarType> types = {
      {"Int8", ScalarType::int8},       {"UInt8", ScalarType::uint8},   {"Int16", ScalarType::int16},
      {"UInt16", ScalarType::uint16},   {"Int32", ScalarType::int32},   {"UInt32", ScalarType::uint32},
      {"Int64", ScalarType::int64},     {"UInt64", ScalarType::uint64}, {"Float32", ScalarType::float32},
      {"Float64", ScalarType::float64},
  };
  const auto found = types.find(name);
  return found == types.end() ? std::nullopt : std::optional(found->second);
}

std::string vti_array_name(pugi::xml_node array) {
  return fmt::format("{} {}", array.name(), in_quotes(array.attribute("Name").value()));
}

void check_vti_array(const VtiFile& vti, pugi::xml_node array, Faults& faults) {
  const std::string_view format = array.attribute("format").value();
  if (format != "ascii" && format != "binary" && format != "appended")
    faults.add(vti_array_name(array) + " format", "ascii, binary or appended", in_quotes(format));
  if (format == "appended" && !position(vti, array))
    faults.add(vti_array_name(array) + " offset", "an offset into AppendedData",
               in_quotes(array.attribute("offset").value()));
}

ByteSourcePtr open_vti_array(const std::shared_ptr<VtiFile>& vti, pugi::xml_node array, ScalarType type,
                             std::optional<std::int64_t> bytes, Faults& faults) {
  check_vti_array(*vti, array, faults);
  faults.throw_if_any();
  const std::string name = vti_array_name(array);
  if (std::string_view(array.attribute("format").value()) == "ascii")
    return open_ascii(array.child_value(), type, name, faults);
  ByteSourcePtr source = open_encoded(vti, array, faults);
  if (vti->is_compressed)
    return std::make_shared<BlockSource>(std::move(source), *vti, name, bytes, faults);
  const std::int64_t n_bytes = CountReader(*source, *vti, name, faults).next();
  check_bytes(name, bytes, n_bytes, faults);
  return first_bytes(std::move(source), n_bytes);
}

} // namespace maille::image_formats
