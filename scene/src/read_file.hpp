#pragma once
/// The text of a file that a person wrote.

#include "maille/materials/fault.hpp"

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace maille::reader {

/// @param what that it is, for messages: "a scene file" @throws InputError if it cannot be read
inline std::string read_text(const std::filesystem::path& file, const std::string& what) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (stream)
    text << stream.rdbuf();
  std::error_code no_matter;
  if (!stream || std::filesystem::is_directory(file, no_matter))
    throw InputError({{file.string(), 0, "", what + " that can be read", "nothing that can be read there"}});
  return text.str();
}

} // namespace maille::reader
