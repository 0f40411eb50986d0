#pragma once
/// Runs of cells of matter along x, found eight cells at a time.

#include "maille/scene/scene.hpp"

#include <cstdint>
#include <cstring>

namespace maille {

/// Calls visit(first, end), x indices, for all maximal runs of cells of matter in a row.
/// @param row of cells: y + z (cells along y)
template<class Visit>
void for_each_run_of_matter(const Specimen& body, std::int64_t row, const Visit& visit) {
  const int n = body.grid.cells()[0];
  if (body.material_id.empty()) {
    visit(0, n);
    return;
  }
  static_assert(no_material == 0xff);
  const std::uint8_t* const ids = body.material_id.data() + row * n;
  for (int x = 0; x < n;) {
    for (std::uint64_t eight = 0; x + 8 <= n; x += 8) {
      std::memcpy(&eight, ids + x, sizeof eight);
      if (~eight != 0)
        break;
    }
    while (x < n && ids[x] == no_material)
      ++x;
    if (x == n)
      return;
    const void* const gap = std::memchr(ids + x, no_material, static_cast<std::size_t>(n - x));
    const int end = gap == nullptr ? n : static_cast<int>(static_cast<const std::uint8_t*>(gap) - ids);
    visit(x, end);
    x = end;
  }
}

} // namespace maille
