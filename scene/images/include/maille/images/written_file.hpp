#pragma once
/// Common code of writers: files with or without gzip, and conversion of values.

#include "maille/images/write_image.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

namespace maille::image_formats {

/// A file that is written sequentially; every failure throws.
class WrittenFile {
public:
  enum class Packing {
    none,
    gzip,
    gzip_fast,     ///< for fields, which hardly compress
    gzip_appended, ///< appended to the file, equally fast
  };
  WrittenFile(const std::filesystem::path& file, Packing packing) : name_(file.string()) {
    // `T`: no compression.
    const char* const modes[] = {"wbT", "wb6", "wb1", "ab1"};
    file_.reset(gzopen(file.c_str(), modes[static_cast<int>(packing)]));
    if (!file_)
      fail();
  }
  void write(const void* bytes, std::size_t count) {
    constexpr std::size_t most = std::size_t{1} << 24;
    const char* from = static_cast<const char*>(bytes);
    for (std::size_t done = 0; done < count;) {
      const auto part = static_cast<unsigned>(std::min(most, count - done));
      if (gzwrite(file_.get(), from + done, part) != static_cast<int>(part))
        fail();
      done += part;
    }
  }
  void close() {
    if (gzclose(file_.release()) != Z_OK)
      fail();
  }

private:
  struct Close {
    void operator()(gzFile_s* file) const { gzclose(file); }
  };
  [[noreturn]] void fail() const { throw std::runtime_error("cannot write " + name_); }

  std::string name_;
  std::unique_ptr<gzFile_s, Close> file_;
};

/// Types of stored values.
enum class StoredType { float32, uint8, int16, int32 };
/// The type for `stored_as`. @throws std::invalid_argument  if values are no labels
StoredType stored_type(std::span<const float> values, StoredAs stored_as);
std::size_t bytes_of(StoredType type);
/// Writes values in this machine's byte order.
void write_values(WrittenFile& file, std::span<const float> values, StoredType type);

} // namespace maille::image_formats
