#pragma once
/// Runs a piece of a test once for every kind of vector that this machine has.

#include <hwy/highway.h>

#include <cstdint>
#include <vector>

namespace maille::test {

/// Restricts the library to one kind of vector while it lives.
class ForcedVectors {
public:
  explicit ForcedVectors(std::int64_t target) { hwy::SetSupportedTargetsForTest(target); }
  ~ForcedVectors() { hwy::SetSupportedTargetsForTest(0); }
  ForcedVectors(const ForcedVectors&) = delete;
  ForcedVectors& operator=(const ForcedVectors&) = delete;
};

/// Every kind that was compiled and that the machine can run, the widest first.
inline std::vector<std::int64_t> vector_targets() {
  return hwy::SupportedAndGeneratedTargets();
}

} // namespace maille::test
