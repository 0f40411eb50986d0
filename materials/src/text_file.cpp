#include "maille/materials/text_file.hpp"

#include "maille/materials/fault.hpp"

#include <fmt/format.h>

#include <array>
#include <fstream>

namespace maille {

std::string read_text_file(const std::filesystem::path& file, std::string_view what, std::int64_t largest) {
  const auto fail = [&](const std::string& expected, const std::string& found) {
    throw InputError({{file.string(), 0, "", fmt::format("{} {}", what, expected), found}});
  };
  std::ifstream stream(file, std::ios::binary);
  std::string text;
  std::array<char, 1 << 14> part{};
  while (stream) {
    stream.read(part.data(), static_cast<std::streamsize>(part.size()));
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
    if (static_cast<std::int64_t>(text.size()) > largest)
      fail(fmt::format("of at most {} bytes", largest), "more");
  }
  if (!stream.is_open() || stream.bad()) // a folder opens, and cannot be read
    fail("that can be read", text.empty()
                                 ? "nothing that can be read there"
                                 : fmt::format("an error of the device after {} bytes", text.size()));
  return text;
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos)
    return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

} // namespace maille
