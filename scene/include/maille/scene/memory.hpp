#pragma once
/// What the machine can still give, so that what cannot fit is refused before it is allocated.

#include <cstdint>

namespace maille {

/// Memory that this process could have now without swapping [bytes]: what the system says is available, cut to what
/// its control group (a container, a batch job) and its own limit (ulimit -v) leave.
std::int64_t available_memory();

} // namespace maille
