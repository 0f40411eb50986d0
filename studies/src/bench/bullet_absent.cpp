// Compiled where there is no libbullet, instead of bullet_soft_body.cpp.
#include "bench/lattice_rivals.hpp"

namespace maille::studies {

std::optional<RivalResult> relax_by_bullet(const Scene&, double) {
  return std::nullopt;
}

} // namespace maille::studies
