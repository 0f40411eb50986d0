#include "maille/live/picture.hpp"

#include <png.h>

#include <cstdint>
#include <string>
#include <vector>

namespace maille::live {

std::string write_png(const std::string& file, int width, int height, const std::vector<std::uint8_t>& rgba) {
  if (width < 1 || height < 1 ||
      rgba.size() <
          static_cast<std::size_t>(4) * static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return file + ": there is no picture";
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGBA;
  if (png_image_write_to_file(&image, file.c_str(), 0, rgba.data(), 0, nullptr) == 0)
    return file + ": " + image.message;
  return {};
}

} // namespace maille::live
