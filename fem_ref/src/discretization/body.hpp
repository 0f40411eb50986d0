#pragma once
/// A specimen as a deal.II mesh, and its node numbers.

#include "discretization/element.hpp"
#include "maille/scene/scene.hpp"

#include <deal.II/dofs/dof_handler.h>
#include <deal.II/grid/tria.h>

#include <functional>
#include <span>
#include <vector>

namespace maille::fem_ref {

/// deal.II's triangulation of exactly the body's cells. Cells that share a grid node share a vertex, for
/// contact in a face, an edge or a corner. One scalar FE_Q numbers the nodes; node n has the unknowns dim n
/// ... dim n + dim - 1.
template<int dim>
class Body {
public:
  /// @param meshed  false: no triangulation; nodes are numbered along the grid, and `numbering` is empty
  Body(const Specimen& specimen, int degree, bool meshed = true);

  const Specimen& specimen() const { return *specimen_; }
  const Element<dim>& element() const { return element_; }
  const dealii::DoFHandler<dim>& numbering() const { return numbering_; }

  int n_cells() const { return static_cast<int>(cells_.size()); }
  unsigned n_nodes() const { return n_nodes_; }
  /// Grid cell of a mesh cell; ascending.
  std::int64_t grid_cell(int cell) const { return cells_[cell]; }
  /// Mesh cell of a grid cell that belongs to the body.
  int mesh_cell(std::int64_t grid_cell) const;
  /// Nodes of a cell, corners first in the order of Grid::corner.
  std::span<const unsigned> nodes(int cell) const {
    const auto n = static_cast<std::size_t>(element_.n_nodes());
    return {nodes_.data() + n * static_cast<std::size_t>(cell), n};
  }
  const std::vector<Vec3>& positions() const { return positions_; } ///< of the nodes [m]
  /// Moves every node to shape(grid position).
  void place(const std::function<Vec3(const Vec3&)>& shape);
  /// Frees the triangulation and deal.II's numbering; other members stay valid.
  void release_mesh();
  std::int64_t bytes() const;

private:
  void number_nodes();
  void number_along_grid();

  const Specimen* specimen_;
  Element<dim> element_;
  dealii::Triangulation<dim> triangulation_;
  dealii::DoFHandler<dim> numbering_;
  unsigned n_nodes_ = 0;
  std::vector<std::int64_t> cells_;
  std::vector<unsigned> nodes_; ///< cells x nodes per cell
  std::vector<Vec3> positions_;
};

/// Creates one mesh cell for each cell of the body, in grid order; cells that share a grid node share a
/// vertex.
/// @param place  mesh position of a grid node
/// @return the grid cells, ascending
template<int dim>
std::vector<std::int64_t> make_mesh_of_matter(const Specimen& specimen,
                                              const std::function<Vec3(const Index3& node)>& place,
                                              dealii::Triangulation<dim>& mesh);

} // namespace maille::fem_ref
