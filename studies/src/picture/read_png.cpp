// Reads PNG by libpng, row by row. libpng reports errors by longjmp, so functions that call it have no
// objects with destructors.

#include "maille/materials/fault.hpp"
#include "picture/read_picture.hpp"

#include <fmt/format.h>
#include <png.h>

#include <csetjmp>
#include <cstring>

namespace maille::studies {

namespace {

[[noreturn]] void leave(png_structp png, png_const_charp /*what*/) {
  png_longjmp(png, 1);
}
void pass_over(png_structp /*png*/, png_const_charp /*what*/) {}

void take(png_structp png, png_bytep to, std::size_t count) {
  auto& left = *static_cast<std::string_view*>(png_get_io_ptr(png));
  if (count > left.size())
    png_error(png, "the end of the file");
  std::memcpy(to, left.data(), count);
  left.remove_prefix(count);
}

class PngReader {
public:
  explicit PngReader(std::string_view bytes) : left_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, leave, pass_over);
    info_ = png_ == nullptr ? nullptr : png_create_info_struct(png_);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  png_uint_32 width() const { return png_get_image_width(png_, info_); }
  png_uint_32 height() const { return png_get_image_height(png_, info_); }
  int bits() const { return png_get_bit_depth(png_, info_); }

  /// @return false if libpng refuses the file
  bool read_head() {
    if (info_ == nullptr || setjmp(png_jmpbuf(png_)) != 0)
      return false;
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX); // the caller limits the size
    png_set_chunk_malloc_max(png_, 1 << 20);
    png_set_read_fn(png_, &left_, take);
    png_read_info(png_, info_);
    return true;
  }
  /// @param rgb receives three bytes per pixel, as stored: without gamma or transparency
  bool read_rows(std::uint8_t* rgb) {
    if (setjmp(png_jmpbuf(png_)) != 0)
      return false;
    png_set_expand(png_);
    png_set_strip_alpha(png_);
    png_set_gray_to_rgb(png_);
    passes_ = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    if (png_get_rowbytes(png_, info_) != std::size_t{3} * width())
      return false;
    for (; passes_ > 0; --passes_)
      for (row_ = 0; row_ < height(); ++row_)
        png_read_row(png_, rgb + std::size_t{3} * width() * row_, nullptr);
    png_read_end(png_, nullptr);
    return true;
  }

private:
  std::string_view left_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  int passes_ = 0;
  png_uint_32 row_ = 0;
};

} // namespace

ColourPicture read_png(std::string_view bytes, const std::filesystem::path& file) {
  PngReader reader(bytes);
  if (!reader.read_head())
    fail_picture(file, wanted_picture, "a file that is none, or damaged");
  require_picture_size(file, reader.width(), reader.height(), bytes.size());
  if (reader.bits() > 8)
    fail_picture(file, wanted_picture, fmt::format("{} bits a channel", reader.bits()));
  ColourPicture picture;
  picture.width = static_cast<int>(reader.width());
  picture.height = static_cast<int>(reader.height());
  picture.rgb.resize(std::size_t{3} * reader.width() * reader.height());
  if (!reader.read_rows(picture.rgb.data()))
    fail_picture(file, wanted_picture, "a file that breaks off, or is damaged");
  return picture;
}

void fail_picture(const std::filesystem::path& file, std::string expected, std::string found) {
  throw InputError({{file.string(), 0, "picture", std::move(expected), std::move(found)}});
}

void require_picture_size(const std::filesystem::path& file, std::uint64_t width, std::uint64_t height,
                          std::uint64_t bytes) {
  constexpr std::uint64_t widest = 16384, always = std::uint64_t{1} << 24, a_byte = 10;
  if (width > widest || height > widest)
    fail_picture(file, fmt::format("a picture of at most {} x {} pixels", widest, widest),
                 fmt::format("{} x {}", width, height));
  if (width * height > always + a_byte * bytes)
    fail_picture(file, fmt::format("at most {} pixels in a file of {} bytes", always + a_byte * bytes, bytes),
                 fmt::format("{} x {}", width, height));
}

} // namespace maille::studies
