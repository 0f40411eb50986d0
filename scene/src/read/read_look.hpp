#pragma once
/// The reader of `look = { ... }`.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/look.hpp"

#include <optional>

namespace maille::reader {

/// `look` of a specimen's or an object's table; nothing if it is absent or faulty. Does not read the image.
std::optional<Look> read_look(TableReader& table);

} // namespace maille::reader
