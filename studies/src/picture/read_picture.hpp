#pragma once
/// Colour pictures from files.

#include <cstdint>
#include <filesystem>
#include <vector>

namespace maille::studies {

/// A colour picture: three bytes a pixel, rows from the top.
struct ColourPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Of PNG or JPEG, by VTK's readers; shades of grey become colours, transparency is left out.
/// @throws InputError where the file is no such picture
ColourPicture read_picture(const std::filesystem::path& file);

} // namespace maille::studies
