#pragma once
/// What the machine can still give, so that what cannot fit is refused before it is allocated.

#include <cstdint>
#include <string>

namespace maille {

/// Memory that this process could have now without swapping [bytes]: what the system says is available, cut to what
/// its control group (a container, a batch job) and its own limit (ulimit -v) leave.
std::int64_t available_memory();

/// A count of bytes for people, in the unit that leaves three digits or less before the point: `384 bytes`, `1.5 KiB`,
/// `130 MiB`, `5.2 GiB`.
std::string bytes_in_words(double bytes);

} // namespace maille
