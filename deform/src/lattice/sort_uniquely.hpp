#pragma once
/// Sorted lists without duplicates.

#include <algorithm>
#include <vector>

namespace maille::deform {

/// Sorts a list and removes duplicates.
template<class Value>
void sort_uniquely(std::vector<Value>& list) {
  std::ranges::sort(list);
  const auto again = std::ranges::unique(list);
  list.erase(again.begin(), again.end());
}

} // namespace maille::deform
