#pragma once
/// A specimen as a mesh of deal.II's, and the numbers of its nodes.

#include "discretization/element.hpp"
#include "maille/scene/scene.hpp"

#include <deal.II/dofs/dof_handler.h>
#include <deal.II/grid/tria.h>

#include <functional>
#include <span>
#include <vector>

namespace maille::fem_ref {

/// deal.II's triangulation of exactly the cells of matter. Cells that share a grid node share a vertex,
/// whether they meet in a face, an edge or a corner. The numbering is of nodes (one scalar FE_Q); node n
/// carries the unknowns dim n ... dim n + dim - 1.
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
  /// The grid's cell behind a cell of the mesh, ascending.
  std::int64_t grid_cell(int cell) const { return cells_[cell]; }
  /// The mesh's cell for a grid cell of matter.
  int mesh_cell(std::int64_t grid_cell) const;
  /// Nodes of a cell, corners first in the order of Grid::corner.
  std::span<const unsigned> nodes(int cell) const {
    const auto n = static_cast<std::size_t>(element_.n_nodes());
    return {nodes_.data() + n * static_cast<std::size_t>(cell), n};
  }
  const std::vector<Vec3>& positions() const { return positions_; } ///< of the nodes [m]
  /// Puts every node elsewhere: at shape(where the grid has it).
  void place(const std::function<Vec3(const Vec3&)>& shape);
  /// Gives up the triangulation and deal.II's numbering; everything else stays.
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

/// One cell of the mesh for every cell of matter, in the grid's order; cells that share a grid node share a
/// vertex.
/// @param place  where a node of the grid stands in the mesh
/// @return the grid's cells, ascending
template<int dim>
std::vector<std::int64_t> make_mesh_of_matter(const Specimen& specimen,
                                              const std::function<Vec3(const Index3& node)>& place,
                                              dealii::Triangulation<dim>& mesh);

} // namespace maille::fem_ref
