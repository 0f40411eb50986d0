#pragma once
/// Lists that stand for sets.

#include <algorithm>
#include <vector>

namespace maille::deform {

/// Sorts a list and leaves one of each value in it.
template<class Value>
void sort_uniquely(std::vector<Value>& list) {
  std::ranges::sort(list);
  const auto again = std::ranges::unique(list);
  list.erase(again.begin(), again.end());
}

} // namespace maille::deform
