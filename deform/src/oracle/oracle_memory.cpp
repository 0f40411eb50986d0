#include "oracle/oracle_memory.hpp"

#include "control/memory_check.hpp"
#include "lattice/link_table.hpp"

#include <algorithm>

namespace maille::deform {

std::int64_t bytes_for_literal(const Scene& scene) {
  const std::int64_t nodes = scene.specimen.n_matter_nodes(), d = scene.dimension();
  // Every link may offer its end once from either side; lists grow by doubling, into new memory.
  constexpr std::int64_t candidate = 16, doubling = 3;
  return bytes_at_least(scene) + LinkTable::bytes_for(scene.specimen) +
         d * nodes * std::int64_t{sizeof(double)} + d * nodes / 8 +
         doubling * candidate * scene.specimen.n_matter_links() + bytes_of_prescribed(scene);
}

std::int64_t bytes_for_sweep(const Scene& scene) {
  const std::int64_t nodes = scene.specimen.n_matter_nodes(), d = scene.dimension();
  const std::int64_t start = d * scene.specimen.grid.n_nodes() * std::int64_t{sizeof(double)},
                     parts = d * nodes * std::int64_t{sizeof(double) + 2 * sizeof(std::int32_t)};
  return bytes_at_least(scene) + start + LinkTable::bytes_for(scene.specimen) +
         std::max(parts, bytes_of_two_envelopes(scene)) + bytes_of_prescribed(scene);
}

} // namespace maille::deform
