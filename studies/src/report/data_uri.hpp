#pragma once
/// Files as parts of a page.

#include <filesystem>
#include <string>
#include <string_view>

namespace maille::studies {

/// `data:TYPE;base64,...` (RFC 2397, RFC 4648)
std::string data_uri(std::string_view type, std::string_view bytes);

/// @throws std::runtime_error
std::string bytes_of_file(const std::filesystem::path& file);

} // namespace maille::studies
