#pragma once
/// Memory of the process: counts every allocation on the heap and every mapping, of all libraries.

#include <cstdint>

namespace maille::test {

/// False if allocations cannot be counted: with sanitizers, or without glibc. Then all counts are 0.
bool heap_is_counted();

/// Counts from its construction on, on all threads. Sizes are those really allocated: the requested ones,
/// rounded up by 24 bytes at most if small, to whole pages if large. Only one meter at a time.
class HeapMeter {
public:
  HeapMeter();
  /// Allocated bytes since construction: present value and peak.
  std::int64_t live() const;
  std::int64_t peak() const;
  std::int64_t allocations() const;

private:
  std::int64_t live_before_, allocations_before_;
};

} // namespace maille::test
