#include "program.hpp"

#include <cstdlib>

namespace maille::studies {

std::string shell_word(std::string_view text) {
  std::string word = "'";
  for (const char c : text)
    word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

bool has_program(std::string_view name) {
  return std::system(("command -v " + shell_word(name) + " > /dev/null 2>&1").c_str()) == 0;
}

} // namespace maille::studies
