#include "data_uri.hpp"

#include "maille/materials/text_file.hpp"

#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <limits>

namespace maille::studies {

std::string data_uri(std::string_view type, std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string uri = fmt::format("data:{};base64,", type);
  uri.reserve(uri.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      uri += i + k <= bytes.size() ? digits[three >> (18 - 6 * k) & 63] : '=';
  }
  return uri;
}

std::string bytes_of_file(const std::filesystem::path& file) {
  return read_text_file(file, "a file of results", std::numeric_limits<std::int64_t>::max());
}

} // namespace maille::studies
