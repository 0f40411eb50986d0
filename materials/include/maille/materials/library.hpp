#pragma once
/// The built-in tissues. Each is a data file in materials/library/, compiled in, so that a program needs no
/// path at run time.

#include "maille/materials/fault.hpp"
#include "maille/materials/material.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// A tissue and the source of its numbers; its damage, if any, has its own source.
struct LibraryEntry {
  Material material;
  std::string title; ///< e.g. "vastus lateralis, human, in vivo, relaxed"
  std::string state; ///< passive, active, excised ...
  std::string species;
  std::string source;      ///< author, year, identifier
  std::string uncertainty; ///< as the source states it; may be empty
  std::string note;        ///< what was derived, assumed or left out
  bool verified = false;   ///< the numbers were read in the source or follow from such numbers
};

/// All entries, sorted by name.
/// @throws InputError if a compiled-in file is faulty (a test reads them all)
const std::vector<LibraryEntry>& material_library();

/// The entry called `name` ("muscle/soleus"), or nullptr.
const LibraryEntry* find_material(std::string_view name);

/// The names nearest in spelling to `name`, best first, at most `count`, misspellings only; the group
/// ("muscle/") may be left out. For error messages.
std::vector<std::string> similar_material_names(std::string_view name, int count = 3);

/// Reads one tissue file.
/// @param text the file's content; @param file its name for messages; @param name the material's name
/// @throws InputError with every fault
LibraryEntry parse_library_entry(std::string_view text, const std::string& file, const std::string& name);

} // namespace maille
