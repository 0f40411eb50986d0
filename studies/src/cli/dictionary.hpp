#pragma once
/// What the figures of results are called, and what they mean: `maille help columns`.

#include <string>

namespace maille::studies {

/// The columns of `run`, `compare`, `study` and `trade`: names in CSV and JSON, units, meanings.
std::string columns_in_words();

} // namespace maille::studies
