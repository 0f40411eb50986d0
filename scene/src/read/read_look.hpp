#pragma once
/// The reader of `look = { ... }`.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/look.hpp"

#include <optional>

namespace maille::reader {

/// `look` of a specimen's or an object's table; nothing where it is absent or faulty. What the image holds is
/// not looked at.
std::optional<Look> read_look(TableReader& table);

} // namespace maille::reader
