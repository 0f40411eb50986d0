#include "solvers/hierarchy.hpp"

#include <algorithm>

namespace maille::fem_ref {

int halvings(const Index3& cells, int dimension) {
  int n = 0;
  while (std::all_of(cells.begin(), cells.begin() + dimension, [&](int c) { return c % (2 << n) == 0; }))
    ++n;
  return n;
}

std::string why_no_hierarchy(const Scene& scene) {
  const Specimen& body = scene.specimen;
  if (scene.dimension() < 2)
    return "the body is a line";
  if (body.n_matter_cells() != body.grid.n_cells())
    return "the body is not a box";
  const std::uint8_t material = body.material(0);
  // Over what is stored, if anything is: a box that is too large for any memory has to be refused at once.
  if (!std::ranges::all_of(body.material_id, [&](std::uint8_t id) { return id == material; }))
    return "the body is of more than one material";
  if (!body.fibres.empty() && !scene.materials[material].elasticity.is_isotropic())
    return "fibres may differ from cell to cell";
  return halvings(body.grid.cells(), scene.dimension()) == 0 ? "an odd number of cells cannot be halved" : "";
}

std::int64_t coarsest_unknowns(const Scene& scene, int degree) {
  const int d = scene.dimension(), n = halvings(scene.specimen.grid.cells(), d);
  std::int64_t unknowns = d;
  for (std::size_t a = 0; a < static_cast<std::size_t>(d); ++a)
    unknowns *= degree * (scene.specimen.grid.cells()[a] >> n) + 1;
  return unknowns;
}

} // namespace maille::fem_ref
