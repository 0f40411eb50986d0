// Sources of bytes: files and deflated ones.

#include "image_formats.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
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
      inflateReset(&state_); // gzip: the next member; other data fail as a damaged header
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

} // namespace

std::int64_t size_of_file(const std::filesystem::path& file, Faults& faults) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status))
    faults.fail("", "a file", "nothing at " + in_quotes(file.string()));
  // A pipe would block, and a device would never end.
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

ByteSourcePtr inflated(ByteSourcePtr source, Compression compression, const Faults& faults) {
  return std::make_shared<InflateSource>(std::move(source), compression, faults);
}

std::optional<std::string> TextHeader::field(const std::string& name) const {
  const auto found = fields.find(name);
  return found == fields.end() ? std::nullopt : std::optional(found->second);
}

std::string_view without_blanks(std::string_view text) {
  return trimmed(text, " \t\r");
}

bool read_header_lines(TextHeader& header, const std::filesystem::path& file, std::size_t largest,
                       Faults& faults, const std::function<bool(std::string_view line)>& take) {
  std::error_code none;
  std::string text(std::min<std::uintmax_t>(largest, std::filesystem::file_size(file, none)), '\0');
  text.resize(open_file(file, 0, faults)->read(text));
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = std::string_view(text).substr(at, end - at);
    at = std::min(end + 1, text.size());
    header.bytes = static_cast<std::int64_t>(at);
    if (!take(line))
      return true;
  }
  return false;
}

void set_field(std::map<std::string, std::string>& fields, const std::string& name, std::string_view value,
               Faults& faults) {
  const auto [place, is_new] = fields.emplace(name, value);
  if (!is_new && place->second != value)
    faults.add(name, "one value", in_quotes(place->second) + " and " + in_quotes(value));
}

std::filesystem::path data_beside(const std::filesystem::path& header, const std::string& key,
                                  const std::string& name, const char* expected, Faults& faults) {
  const std::filesystem::path data = name;
  if (name.empty() || data.is_absolute() || std::ranges::find(data, "..") != data.end() ||
      name.starts_with("LIST") || name.find('%') != std::string::npos || name.find('\0') != std::string::npos)
    faults.add(key, expected, in_quotes(name));
  return header.parent_path() / data;
}

std::function<ByteSourcePtr()> data_in(const std::filesystem::path& file, std::int64_t from,
                                       std::optional<Compression> compression, const Faults& faults) {
  return [=] {
    Faults of_data = faults;
    ByteSourcePtr source = open_file(file, from, of_data);
    return compression ? inflated(std::move(source), *compression, faults) : source;
  };
}

} // namespace maille::image_formats
