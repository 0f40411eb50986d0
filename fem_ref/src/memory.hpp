#pragma once
/// What the machine can still give, and byte counts as text.

#include <cstdint>
#include <string>

namespace maille::fem_ref {

/// Bytes that can be had without swapping: MemAvailable of /proc/meminfo, cut to what the control group of
/// the process has left; a very large number where neither can be read.
std::int64_t available_bytes();

/// `5.2 GB`, `130 MB`
std::string bytes_in_words(double bytes);

} // namespace maille::fem_ref
