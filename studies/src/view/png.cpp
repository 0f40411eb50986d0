#include "export/whole_file.hpp"
#include "view/seen_scene.hpp"

#include <fmt/format.h>
#include <png.h>

#include <stdexcept>
#include <string>

namespace maille::studies {

void write_png(const std::vector<std::uint8_t>& rgb, int width, int height,
               const std::filesystem::path& file) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGB;
  // In memory, since the file is to be whole or not there.
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgb.data(), 0, nullptr) == 0)
    throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(), image.message));
  bytes.resize(size);
  write_whole(file, bytes);
}

} // namespace maille::studies
