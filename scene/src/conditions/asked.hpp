#pragma once
/// Something that an input asks for, as faults name it.

#include <string>
#include <string_view>

namespace maille::reader {

struct Asked {
  std::string key;  ///< dotted path, e.g. `move[1].where`
  int line = 0;     ///< 0: a program's, which has none
  std::string text; ///< what stands there

  Asked at(std::string_view member) const { return {key + "." + std::string(member), line, text}; }
};

} // namespace maille::reader
