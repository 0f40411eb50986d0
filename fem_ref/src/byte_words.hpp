#pragma once
/// Byte counts as text, for messages.

#include <fmt/format.h>

#include <string>

namespace maille::fem_ref {

/// `5.2 GB`, `130 MB`
inline std::string bytes_in_words(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.3g} MB", bytes / 1e6) : fmt::format("{:.3g} GB", bytes / 1e9);
}

} // namespace maille::fem_ref
