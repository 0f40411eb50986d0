#pragma once
/// Memory of the process: counts every allocation on the heap and every mapping, of all libraries.

#include <cstdint>

namespace maille::test {

/// False where allocations cannot be counted: under sanitizers, and without glibc. Then all counts are 0.
bool heap_is_counted();

/// Counts from its construction on, on all threads. Sizes are those that were really set aside, which are
/// what was asked for, rounded up: by 24 bytes at most where it is small, to whole pages where it is large.
/// One at a time.
class HeapMeter {
public:
  HeapMeter();
  /// Bytes that are held more than at construction: now, and at the most.
  std::int64_t live() const;
  std::int64_t peak() const;
  std::int64_t allocations() const;

private:
  std::int64_t live_before_, allocations_before_;
};

} // namespace maille::test
