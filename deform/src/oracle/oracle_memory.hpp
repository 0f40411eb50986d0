#pragma once
/// What the slow and obvious methods hold.

#include "maille/scene/scene.hpp"

#include <cstdint>

namespace maille::deform {

/// At their peak, at most [bytes].
std::int64_t bytes_for_literal(const Scene& scene);
std::int64_t bytes_for_sweep(const Scene& scene);

} // namespace maille::deform
