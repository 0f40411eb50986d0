#pragma once
/// What a method holds in memory, array by array.

#include <cstdint>
#include <string>
#include <vector>

namespace maille::deform {

/// One array, or several alike.
struct ArrayBytes {
  std::string name;
  std::int64_t bytes = 0;
  std::string why; ///< what makes it necessary, and how large it is
};
using Footprint = std::vector<ArrayBytes>;

/// The sum over all arrays [bytes].
inline std::int64_t bytes_of(const Footprint& footprint) {
  std::int64_t sum = 0;
  for (const ArrayBytes& array : footprint)
    sum += array.bytes;
  return sum;
}

} // namespace maille::deform
