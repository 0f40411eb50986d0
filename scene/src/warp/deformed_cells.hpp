#pragma once
/// The cells of deformed bodies, one after the other, by where their corners are among an image's voxels.
/// Private to scene.

#include "maille/scene/warp/warp.hpp"
#include "warp/cell_map.hpp"
#include "warp/voxel_frame.hpp"

#include <stdexcept>
#include <vector>

namespace maille::warping {

/// Refuses what is no body of three dimensions with a displacement of its nodes.
inline void check(const DeformedBody& body) {
  if (!body.specimen || !body.displacement || body.specimen->grid.dimension() != 3 ||
      body.displacement->n_components() != 3 ||
      static_cast<std::int64_t>(body.displacement->n_nodes()) != body.specimen->grid.n_nodes())
    throw std::invalid_argument("expected a body of three dimensions and a displacement of its nodes");
}

/// Calls visit(cell, where it is in the grid, corners in indices of voxels) for every cell of matter. Nodes
/// are placed a layer at a time.
template<class Visit>
void for_each_deformed_cell(const ImageInfo& image, const DeformedBody& body, Visit&& visit) {
  check(body);
  const Specimen& specimen = *body.specimen;
  const Displacement& u = *body.displacement;
  const Grid& grid = specimen.grid;
  const Affine3 to_voxels = body_to_voxels(image, specimen.placement);
  const auto in_layer = static_cast<std::size_t>(grid.nodes()[0]) * static_cast<std::size_t>(grid.nodes()[1]);
  std::vector<Eigen::Vector3d> lower(in_layer), upper(in_layer);
  const auto place_layer = [&](int k, std::vector<Eigen::Vector3d>& layer) {
    std::size_t at = 0;
    for (int j = 0; j < grid.nodes()[1]; ++j)
      for (int i = 0; i < grid.nodes()[0]; ++i, ++at) {
        const std::int64_t node = grid.node({i, j, k});
        const Vec3 x = specimen.position({i, j, k});
        layer[at] = to_voxels.of({x[0] + u(0, node), x[1] + u(1, node), x[2] + u(2, node)});
      }
  };
  place_layer(0, upper);
  const auto row = static_cast<std::size_t>(grid.nodes()[0]);
  for (int k = 0; k < grid.cells()[2]; ++k) {
    std::swap(lower, upper);
    place_layer(k + 1, upper);
    for (int j = 0; j < grid.cells()[1]; ++j)
      for (int i = 0; i < grid.cells()[0]; ++i) {
        const std::int64_t cell = grid.cell({i, j, k});
        if (!specimen.is_matter(cell))
          continue;
        const std::size_t first = static_cast<std::size_t>(i) + row * static_cast<std::size_t>(j);
        const Corners corners{lower[first], lower[first + 1], lower[first + row], lower[first + row + 1],
                              upper[first], upper[first + 1], upper[first + row], upper[first + row + 1]};
        visit(cell, Index3{i, j, k}, corners);
      }
  }
}

} // namespace maille::warping
