#include "maille/live/picture.hpp"
#include "maille/materials/text_file.hpp"

#include <png.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace maille::live {

bool is_name_of_picture(const std::string& name) {
  return name.size() > 4 && name.ends_with(".png") && name.find('/') == std::string::npos;
}

std::string write_png(const std::string& file, int width, int height, const std::vector<std::uint8_t>& rgba,
                      const std::function<void(const std::filesystem::path&)>& finish) {
  if (width < 1 || height < 1 || rgba.size() < std::size_t{4} * width * height)
    return file + ": there is no picture";
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width);
  image.height = static_cast<png_uint_32>(height);
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&image, bytes.data(), &size, 0, rgba.data(), 0, nullptr) == 0)
    return file + ": " + image.message;
  std::error_code error;
  const auto there = std::filesystem::symlink_status(file, error);
  if ((std::filesystem::exists(there) && !std::filesystem::is_regular_file(there)) || is_kept_input(file))
    return file + ": cannot be written: something else is there";
  std::filesystem::path temporary;
  try {
    std::FILE* const stream = fdopen(create_beside(file, temporary), "wb");
    bool is_whole = stream != nullptr && std::fwrite(bytes.data(), 1, size, stream) == size;
    is_whole = stream != nullptr && std::fclose(stream) == 0 && is_whole;
    if (is_whole && finish)
      finish(temporary);
    if (is_whole)
      std::filesystem::rename(temporary, file, error);
    else
      error.assign(errno, std::generic_category());
  } catch (const std::filesystem::filesystem_error& fault) {
    error = fault.code();
  }
  if (error) {
    const std::string why = error.message();
    std::filesystem::remove(temporary, error);
    return file + ": cannot be written: " + why;
  }
  return {};
}

} // namespace maille::live
