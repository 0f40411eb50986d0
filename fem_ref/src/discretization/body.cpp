

#include "discretization/body.hpp"

#include <algorithm>

namespace maille::fem_ref {

template<int dim>
Body<dim>::Body(const Specimen& specimen, int degree, bool meshed)
    : specimen_(&specimen), element_(degree, specimen.grid.spacing()), numbering_(triangulation_) {
  if (meshed) {
    cells_ = make_mesh_of_matter<dim>(
        specimen, [&](const Index3& node) { return specimen.position(node); }, triangulation_);
    number_nodes();
  } else {
    number_along_grid();
  }
}

template<int dim>
void Body<dim>::number_along_grid() {
  const Grid& grid = specimen_->grid;
  const auto degree = static_cast<int>(element_.fe().degree);
  std::array<std::int64_t, 3> n{1, 1, 1};
  for (std::size_t a = 0; a < dim; ++a)
    n[a] = degree * grid.cells()[a] + 1;
  std::vector<unsigned> number(n[0] * n[1] * n[2], dealii::numbers::invalid_unsigned_int);
  const int per_cell = element_.n_nodes();
  const auto visit = [&](const auto& take) {
    for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
      const Index3 at = grid.cell_at(cells_[cell]);
      for (int i = 0; i < per_cell; ++i) {
        std::int64_t place = 0;
        for (std::size_t a = dim; a-- > 0;)
          place = place * n[a] + degree * at[a] + element_.place(i)[a];
        take(at, i, number[place]);
      }
    }
  };
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    if (specimen_->is_matter(cell))
      cells_.push_back(cell);
  visit([](const Index3&, int, unsigned& of_node) { of_node = 0; });
  for (unsigned& of_node : number)
    if (of_node == 0)
      of_node = n_nodes_++;
  positions_.resize(n_nodes_);
  nodes_.reserve(cells_.size() * static_cast<std::size_t>(per_cell));
  visit([&](const Index3& at, int i, unsigned& of_node) {
    nodes_.push_back(of_node);
    const Vec3 corner = specimen_->position(at), offset = element_.offset(i);
    for (std::size_t a = 0; a < 3; ++a)
      positions_[of_node][a] = corner[a] + offset[a];
  });
}

template<int dim>
void Body<dim>::number_nodes() {
  numbering_.distribute_dofs(element_.fe());
  const auto per_cell = static_cast<std::size_t>(element_.n_nodes());
  n_nodes_ = numbering_.n_dofs();
  positions_.resize(n_nodes_);
  nodes_.reserve(cells_.size() * per_cell);
  std::vector<dealii::types::global_dof_index> nodes(per_cell);
  std::size_t k = 0; // a mesh without refinement keeps the order of its cells
  for (const auto& cell : numbering_.active_cell_iterators()) {
    cell->get_dof_indices(nodes);
    const Vec3 corner = specimen_->position(specimen_->grid.cell_at(cells_[k++]));
    for (std::size_t i = 0; i < per_cell; ++i) {
      nodes_.push_back(nodes[i]);
      const Vec3 offset = element_.offset(static_cast<int>(i));
      for (std::size_t a = 0; a < 3; ++a)
        positions_[nodes[i]][a] = corner[a] + offset[a];
    }
  }
}

template<int dim>
int Body<dim>::mesh_cell(std::int64_t grid_cell) const {
  return static_cast<int>(std::lower_bound(cells_.begin(), cells_.end(), grid_cell) - cells_.begin());
}

template<int dim>
void Body<dim>::place(const std::function<Vec3(const Vec3&)>& shape) {
  for (Vec3& x : positions_)
    x = shape(x);
}

template<int dim>
void Body<dim>::release_mesh() {
  numbering_.clear();
  triangulation_.clear();
}

template<int dim>
std::int64_t Body<dim>::bytes() const {
  return static_cast<std::int64_t>(cells_.size() * sizeof(std::int64_t) + nodes_.size() * sizeof(unsigned) +
                                   positions_.size() * sizeof(Vec3));
}

template class Body<1>;
template class Body<2>;
template class Body<3>;

template<int dim>
std::vector<std::int64_t> make_mesh_of_matter(const Specimen& specimen,
                                              const std::function<Vec3(const Index3& node)>& place,
                                              dealii::Triangulation<dim>& mesh) {
  const Grid& grid = specimen.grid;
  std::vector<unsigned> vertex_of(grid.n_nodes(), dealii::numbers::invalid_unsigned_int);
  std::vector<dealii::Point<dim>> vertices;
  std::vector<dealii::CellData<dim>> cells;
  std::vector<std::int64_t> of_grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    if (!specimen.is_matter(cell))
      continue;
    dealii::CellData<dim> data;
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      const std::int64_t node = grid.corner(grid.cell_at(cell), corner);
      unsigned& vertex = vertex_of[node];
      if (vertex == dealii::numbers::invalid_unsigned_int) {
        vertex = static_cast<unsigned>(vertices.size());
        const Vec3 x = place(grid.node_at(node));
        dealii::Point<dim> point;
        for (unsigned a = 0; a < dim; ++a)
          point[a] = x[a];
        vertices.push_back(point);
      }
      data.vertices[corner] = vertex;
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
