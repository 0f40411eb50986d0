#pragma once
/// Constants of a scene's materials by the materials' names, for --unknown.

#include <toml++/toml.h>

#include <string>
#include <vector>

namespace maille::studies {

/// A constant of all matter of a name.
struct MaterialConstant {
  std::string constant,
      material; ///< `E_fibre`, `muscle/soleus`; no material: `constant` is a key of the scene
};

/// `E_fibre`, `E_cross of muscle/soleus` and keys of a scene, in any order: what stands before an `of` and
/// has no material of its own is of that one.
/// @param words  a list that was separated by commas
std::vector<MaterialConstant> constants_in(const std::vector<std::string>& words);

/// The tables of a scene that hold the constants of a material: [specimen] `material` and `labels` whose text
/// is its name, or whose table has it as `name`. A name of the library becomes a table of its constants, its
/// density and its limits, which say the same.
/// @param document  of the scene; changed where a name becomes a table
/// @return none where no matter has that name
/// @throws std::invalid_argument  matter of that name has no such constant
std::vector<toml::table*> tables_of(toml::table& document, const MaterialConstant& wanted);

} // namespace maille::studies
