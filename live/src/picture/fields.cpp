#include "maille/live/picture.hpp"
#include "maille/scene/cell_fields.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace maille::live {

std::vector<float> strain_of_cells(const Scene& scene, const Displacement& displacement) {
  const CellFields fields = cell_fields(scene, displacement);
  std::vector<float> values;
  values.reserve(fields.strain.size());
  for (const auto& strain : fields.strain) {
    const Vec3 principal = principal_values(strain);
    values.push_back(static_cast<float>(std::max(std::abs(principal[0]), std::abs(principal[2]))));
  }
  return values;
}

std::vector<float> length_at_cells(const Scene& scene, const Displacement& displacement) {
  const Grid& grid = scene.specimen.grid;
  std::vector<float> values(grid.n_cells(), 0);
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!scene.specimen.is_matter(cell))
      continue;
    Vec3 mean{};
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      const Vec3 u = displacement.at(grid.corner(grid.cell_at(cell), corner));
      for (std::size_t a = 0; a < 3; ++a)
        mean[a] += u[a] / grid.corners_per_cell();
    }
    values[cell] = static_cast<float>(std::hypot(mean[0], mean[1], mean[2]));
  }
  return values;
}

std::vector<Rgb> field_palette() {
  return render::field_colours();
}

} // namespace maille::live
