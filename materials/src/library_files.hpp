#pragma once
/// What cmake/embed_library.cmake makes of materials/library.

#include <string_view>
#include <vector>

namespace maille {

struct LibraryFile {
  std::string_view name; ///< "muscle/soleus"
  std::string_view text;
};

const std::vector<LibraryFile>& library_files();

} // namespace maille
