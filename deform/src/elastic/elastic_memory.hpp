#pragma once
/// What the elastic methods hold.

#include "maille/scene/scene.hpp"

#include <cstdint>

namespace maille::deform {

/// At their peak, at most [bytes].
std::int64_t bytes_for_relaxed(const Scene& scene);
std::int64_t bytes_for_coupled(const Scene& scene);

} // namespace maille::deform
