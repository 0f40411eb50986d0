#pragma once
/// The cells of a specimen's matter as a mesh of deal.II's.

#include "maille/scene/scene.hpp"

#include <deal.II/grid/tria.h>
#include <functional>
#include <vector>

namespace maille::fem_ref {

/// One cell of the mesh for every cell of matter, in the grid's order; cells that share a grid node share a
/// vertex.
/// @param place  where a node of the grid stands in the mesh
/// @return the grid's cells, ascending
template<int dim>
std::vector<std::int64_t> make_mesh_of_matter(const Specimen& specimen,
                                              const std::function<Vec3(const Index3& node)>& place,
                                              dealii::Triangulation<dim>& mesh);

} // namespace maille::fem_ref
