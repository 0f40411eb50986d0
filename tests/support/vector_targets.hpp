#pragma once
/// Runs part of a test once for every vector instruction set of this machine.

#include <hwy/highway.h>

#include <cstdint>
#include <vector>

namespace maille::test {

/// Restricts the library to one vector instruction set in its lifetime.
class ForcedVectors {
public:
  explicit ForcedVectors(std::int64_t target) { hwy::SetSupportedTargetsForTest(target); }
  ~ForcedVectors() { hwy::SetSupportedTargetsForTest(0); }
  ForcedVectors(const ForcedVectors&) = delete;
  ForcedVectors& operator=(const ForcedVectors&) = delete;
};

/// All compiled instruction sets that the machine supports, the widest first.
inline std::vector<std::int64_t> vector_targets() {
  return hwy::SupportedAndGeneratedTargets();
}

} // namespace maille::test
