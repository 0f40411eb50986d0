#pragma once
/// The body of an object in a world: what a specimen can be, and shapes that only worlds have.

#include "read/reader.hpp"

namespace maille::reader {

/// `shape` and its keys. @return false where there is no body
bool read_object_body(TableReader& table, const BodyDefaults& defaults, const std::filesystem::path& folder,
                      Scene& scene);

} // namespace maille::reader
