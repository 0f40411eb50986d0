#include "discretization/matter_mesh.hpp"

namespace maille::fem_ref {

template<int dim>
std::vector<std::int64_t> make_mesh_of_matter(const Specimen& specimen,
                                              const std::function<Vec3(const Index3& node)>& place,
                                              dealii::Triangulation<dim>& mesh) {
  const Grid& grid = specimen.grid;
  std::vector<unsigned> vertex_of(static_cast<std::size_t>(grid.n_nodes()),
                                  dealii::numbers::invalid_unsigned_int);
  std::vector<dealii::Point<dim>> vertices;
  std::vector<dealii::CellData<dim>> cells;
  std::vector<std::int64_t> of_grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!specimen.is_matter(cell))
      continue;
    dealii::CellData<dim> data;
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      const std::int64_t node = grid.corner(grid.cell_at(cell), corner);
      unsigned& vertex = vertex_of[static_cast<std::size_t>(node)];
      if (vertex == dealii::numbers::invalid_unsigned_int) {
        vertex = static_cast<unsigned>(vertices.size());
        const Vec3 x = place(grid.node_at(node));
        dealii::Point<dim> point;
        for (unsigned a = 0; a < dim; ++a)
          point[a] = x[a];
        vertices.push_back(point);
      }
      data.vertices[static_cast<std::size_t>(corner)] = vertex;
    }
    cells.push_back(std::move(data));
    of_grid.push_back(cell);
  }
  mesh.create_triangulation(vertices, cells, dealii::SubCellData());
  return of_grid;
}

using Place = std::function<Vec3(const Index3& node)>;
template std::vector<std::int64_t> make_mesh_of_matter(const Specimen&, const Place&,
                                                       dealii::Triangulation<1>&);
template std::vector<std::int64_t> make_mesh_of_matter(const Specimen&, const Place&,
                                                       dealii::Triangulation<2>&);
template std::vector<std::int64_t> make_mesh_of_matter(const Specimen&, const Place&,
                                                       dealii::Triangulation<3>&);

} // namespace maille::fem_ref
