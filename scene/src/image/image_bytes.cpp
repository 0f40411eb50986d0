// Sources of bytes: files, parts of them, deflated and base64-encoded ones.

#include "image/image_formats.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>

namespace maille::image_formats {
namespace {

constexpr std::size_t chunk_bytes = 1 << 16;

class FileSource final : public ByteSource {
public:
  FileSource(std::ifstream stream, const Faults& faults) : stream_(std::move(stream)), faults_(faults) {}
  std::size_t read(std::span<char> to) override {
    stream_.read(to.data(), static_cast<std::streamsize>(to.size()));
    if (stream_.bad())
      faults_.fail("", "a readable file", "an error of the device");
    return static_cast<std::size_t>(stream_.gcount());
  }
  std::int64_t bytes_left() override {
    const auto here = stream_.tellg();
    stream_.seekg(0, std::ios::end);
    const auto end = stream_.tellg();
    stream_.seekg(here);
    return here < 0 ? 0 : std::max<std::int64_t>(0, end - here);
  }

private:
  std::ifstream stream_;
  Faults faults_;
};

class TextSource final : public ByteSource {
public:
  explicit TextSource(std::string_view text) : text_(text) {}
  std::size_t read(std::span<char> to) override {
    const std::size_t count = text_.copy(to.data(), to.size());
    text_.remove_prefix(count);
    return count;
  }

private:
  std::string_view text_;
};

class FirstBytes final : public ByteSource {
public:
  FirstBytes(ByteSourcePtr source, std::int64_t count) : source_(std::move(source)), left_(count) {}
  std::size_t read(std::span<char> to) override {
    const auto wanted = static_cast<std::size_t>(std::min(static_cast<std::int64_t>(to.size()), left_));
    const std::size_t count = source_->read(to.first(wanted));
    left_ -= static_cast<std::int64_t>(count);
    is_cut_short_ = is_cut_short_ || count < wanted;
    return count;
  }
  bool is_cut_short() const override { return is_cut_short_; }

private:
  ByteSourcePtr source_;
  std::int64_t left_;
  bool is_cut_short_ = false;
};

class InflateSource final : public ByteSource {
public:
  InflateSource(ByteSourcePtr source, Compression compression, const Faults& faults)
      : source_(std::move(source)), compression_(compression), faults_(faults) {
    constexpr int gzip_only = 15 + 16;
    constexpr int zlib_or_gzip = 15 + 32;
    if (inflateInit2(&state_, compression == Compression::gzip ? gzip_only : zlib_or_gzip) != Z_OK)
      throw std::bad_alloc();
  }
  ~InflateSource() override { inflateEnd(&state_); }

  std::size_t read(std::span<char> to) override {
    std::size_t done = 0;
    while (done < to.size() && !is_at_end_) {
      if (state_.avail_in == 0 && !refill()) {
        is_cut_short_ = true;
        break;
      }
      const std::size_t room = std::min(to.size() - done, std::size_t{1} << 30);
      state_.next_out = reinterpret_cast<Bytef*>(to.data() + done);
      state_.avail_out = static_cast<uInt>(room);
      const int outcome = inflate(&state_, Z_NO_FLUSH);
      done += room - state_.avail_out;
      produced_ += static_cast<std::int64_t>(room - state_.avail_out);
      if (outcome == Z_STREAM_END)
        end_of_stream();
      else if (outcome != Z_OK && outcome != Z_BUF_ERROR)
        damaged(state_.msg != nullptr ? state_.msg : "damaged");
    }
    return done;
  }
  bool is_cut_short() const override { return is_cut_short_; }

private:
  bool refill() {
    state_.next_in = reinterpret_cast<Bytef*>(input_.data());
    state_.avail_in = static_cast<uInt>(source_->read(input_));
    return state_.avail_in > 0;
  }
  void end_of_stream() {
    const bool has_more = state_.avail_in > 0 || refill();
    if (has_more && compression_ == Compression::zlib)
      damaged("more bytes after the end of the compressed stream");
    if (has_more)
      inflateReset(&state_); // gzip: the next member; what is no member fails as a damaged header
    is_at_end_ = !has_more;
  }
  [[noreturn]] void damaged(const std::string& complaint) {
    faults_.fail("data", "intact compressed data",
                 fmt::format("{} (after {} decoded bytes)", complaint, produced_));
  }

  ByteSourcePtr source_;
  Compression compression_;
  Faults faults_;
  z_stream state_{};
  std::array<char, chunk_bytes> input_{};
  std::int64_t produced_ = 0;
  bool is_at_end_ = false;
  bool is_cut_short_ = false;
};

int base64_value(char character) {
  if (character >= 'A' && character <= 'Z')
    return character - 'A';
  if (character >= 'a' && character <= 'z')
    return character - 'a' + 26;
  if (character >= '0' && character <= '9')
    return character - '0' + 52;
  return character == '+' ? 62 : character == '/' ? 63 : -1;
}

bool is_space(char character) {
  return character == ' ' || character == '\n' || character == '\r' || character == '\t';
}

class Base64Source final : public ByteSource {
public:
  Base64Source(ByteSourcePtr source, const Faults& faults) : source_(std::move(source)), faults_(faults) {}

  std::size_t read(std::span<char> to) override {
    std::size_t done = 0;
    while (done < to.size()) {
      if (next_ == n_decoded_ && !decode_group())
        break;
      to[done++] = decoded_[next_++];
    }
    return done;
  }
  bool is_cut_short() const override { return is_cut_short_; }

private:
  /// The next character that counts, 0 at the end.
  char next_character() {
    while (!is_at_end_) {
      if (at_ == n_input_) {
        n_input_ = source_->read(input_);
        at_ = 0;
      }
      if (n_input_ == 0 || input_[at_] == '<')
        is_at_end_ = true;
      else if (!is_space(input_[at_]))
        return input_[at_++];
      else
        ++at_;
    }
    return 0;
  }

  bool decode_group() {
    unsigned bits = 0;
    unsigned n_padding = 0;
    for (int i = 0; i < 4; ++i) {
      const char character = next_character();
      if (character == 0) {
        is_cut_short_ = is_cut_short_ || i > 0;
        return false;
      }
      const int value = base64_value(character);
      const bool is_padding = character == '=' && i >= 2;
      if (is_padding ? false : value < 0 || n_padding > 0)
        faults_.fail("data", "base64", in_quotes(std::string_view(&character, 1)));
      n_padding += is_padding ? 1U : 0U;
      bits = bits << 6 | static_cast<unsigned>(is_padding ? 0 : value);
    }
    for (std::size_t i = 0; i < 3; ++i)
      decoded_[i] = static_cast<char>(bits >> (16 - 8 * i) & 0xFFU);
    n_decoded_ = 3 - n_padding;
    next_ = 0;
    return true;
  }

  ByteSourcePtr source_;
  Faults faults_;
  std::array<char, 4096> input_{};
  std::size_t n_input_ = 0;
  std::size_t at_ = 0;
  std::array<char, 3> decoded_{};
  std::size_t n_decoded_ = 0;
  std::size_t next_ = 0;
  bool is_at_end_ = false;
  bool is_cut_short_ = false;
};

} // namespace

std::int64_t size_of_file(const std::filesystem::path& file, Faults& faults) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status))
    faults.fail("", "a file", "nothing at " + in_quotes(file.string()));
  // A pipe would make us wait and a device would never end.
  if (!std::filesystem::is_regular_file(status))
    faults.fail("", "a file", "something else at " + in_quotes(file.string()));
  note_opened(file);
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error)
    faults.fail("", "a readable file", error.message());
  return static_cast<std::int64_t>(size);
}

ByteSourcePtr open_file(const std::filesystem::path& file, std::int64_t from, Faults& faults) {
  size_of_file(file, faults);
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    faults.fail("", "a readable file", "no permission to read " + in_quotes(file.string()));
  stream.seekg(from);
  return std::make_shared<FileSource>(std::move(stream), faults);
}

ByteSourcePtr open_text(std::string_view text) {
  return std::make_shared<TextSource>(text);
}

ByteSourcePtr first_bytes(ByteSourcePtr source, std::int64_t count) {
  return std::make_shared<FirstBytes>(std::move(source), count);
}

ByteSourcePtr inflated(ByteSourcePtr source, Compression compression, const Faults& faults) {
  return std::make_shared<InflateSource>(std::move(source), compression, faults);
}

ByteSourcePtr base64_decoded(ByteSourcePtr source, const Faults& faults) {
  return std::make_shared<Base64Source>(std::move(source), faults);
}

} // namespace maille::image_formats
