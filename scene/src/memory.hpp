#pragma once
#include <cstdint>

namespace maille {

/// Memory that the machine could give to this process now [bytes]: what the system says is available, and no
/// more than the process's own limit (ulimit -v).
std::int64_t available_memory();

} // namespace maille
