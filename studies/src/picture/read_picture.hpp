#pragma once
/// Colour pictures from files.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// A colour picture: three bytes a pixel, rows from the top.
struct ColourPicture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

/// Reads PNG by libpng or JPEG by VTK's reader; grey becomes colours, transparency is ignored.
/// @throws InputError if the file is no such picture, or has too many pixels for its size
ColourPicture read_picture(const std::filesystem::path& file);

/// @param bytes of the whole file @param file for messages
ColourPicture read_png(std::string_view bytes, const std::filesystem::path& file);

inline constexpr const char* wanted_picture = "a picture in PNG or JPEG of 8 bits a channel";
[[noreturn]] void fail_picture(const std::filesystem::path& file, std::string expected, std::string found);
/// @throws InputError beyond 16384 pixels along an axis, or beyond 16 million plus ten per byte of the file:
///         memory is bounded by the size of the file, not by its header
void require_picture_size(const std::filesystem::path& file, std::uint64_t width, std::uint64_t height,
                          std::uint64_t bytes);

} // namespace maille::studies
