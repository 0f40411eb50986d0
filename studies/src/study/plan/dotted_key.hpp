#pragma once
/// Nodes of a TOML table by dotted key: `specimen.material.E_fibre`, `move.0.by`.

#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace maille::studies {

/// Where a key leads; `last` is how far it can be followed, for messages.
struct DottedNode {
  toml::node* node = nullptr; ///< nullptr: there is none
  std::string last;
};

/// Follows names of tables and indices (from 0) of arrays.
DottedNode find_dotted(toml::table& root, std::string_view key);

/// Puts a value, written as TOML, in the place of what stands at `key`.
/// @pre find_dotted finds it; the text is one TOML value
void replace_dotted(toml::table& root, std::string_view key, const std::string& value);

} // namespace maille::studies
