# Writes a C++ file that holds every FILES entry of the folder LIBRARY as a string, for find_material.
set(text "// Made from materials/library by cmake/embed_library.cmake.\n#include \"library_files.hpp\"\n\n"
         "namespace maille {\nconst std::vector<LibraryFile>& library_files() {\n"
         "  static const std::vector<LibraryFile> files = {\n")
string(REPLACE ";" "" text "${text}")
foreach(file IN LISTS FILES)
  file(READ ${LIBRARY}/${file} content)
  string(REGEX REPLACE "\\.toml$" "" name ${file})
  string(APPEND text "    {\"${name}\", R\"toml(${content})toml\"},\n")
endforeach()
string(APPEND text "  };\n  return files;\n}\n} // namespace maille\n")
file(WRITE ${OUTPUT} "${text}")
