#pragma once
/// Distributed solve of one scene on all ranks: deal.II's distributed triangulation (p4est), Trilinos
/// matrices, CG with AMG.

#include "discretization/body.hpp"
#include "discretization/element.hpp"
#include "maille/fem_ref/solve.hpp"
#include "process/abandonable.hpp"
#include "solvers/multigrid_mesh.hpp"

#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/grid/grid_generator.h>
#include <mpi.h>

namespace maille::fem_ref {

/// One rank's part of the mesh. Construction is collective; p4est distributes the cells. The mesh is in units
/// of cells, so the position of a cell gives its grid index.
template<int dim>
class DistributedMesh {
public:
  using Cell = typename dealii::DoFHandler<dim>::active_cell_iterator;

  /// @param specimen  outlives the mesh
  DistributedMesh(const Specimen& specimen, int degree);

  const dealii::FESystem<dim>& element() const { return element_; }
  const dealii::DoFHandler<dim>& numbering() const { return numbering_; }
  /// Unknowns of this rank; unknowns of its cells and their neighbours.
  const dealii::IndexSet& own() const { return own_; }
  const dealii::IndexSet& relevant() const { return relevant_; }
  std::size_t bytes() const { return numbering_.memory_consumption() + triangulation_.memory_consumption(); }

  /// Grid cell of a mesh cell.
  std::int64_t grid_cell(const Cell& cell) const {
    Index3 at{0, 0, 0};
    for (unsigned a = 0; a < dim; ++a)
      at[a] = static_cast<int>(cell->vertex(0)[a] + 0.5);
    return specimen_.grid.cell(at);
  }
  /// Calls visit(mesh cell, grid cell) for the cells of this rank.
  template<class Visit>
  void for_each_own_cell(const Visit& visit) const {
    for (const auto& cell : numbering_.active_cell_iterators())
      if (cell->is_locally_owned())
        visit(cell, grid_cell(cell));
  }
  /// Converts an index in the order of FESystem to dim * node + component.
  std::size_t place(unsigned local) const {
    const auto [component, node] = element_.system_to_component_index(local);
    return dim * node + component;
  }
  /// Node positions of this rank's unknowns [m], in the order of the unknowns.
  std::vector<Vec3> own_positions(const Element<dim>& of_cell) const;

private:
  void make_cells();

  const Specimen& specimen_;
  dealii::parallel::distributed::Triangulation<dim> triangulation_;
  dealii::FESystem<dim> element_;
  dealii::DoFHandler<dim> numbering_;
  dealii::IndexSet own_, relevant_;
};

template<int dim>
DistributedMesh<dim>::DistributedMesh(const Specimen& specimen, int degree)
    : specimen_(specimen), triangulation_(MPI_COMM_WORLD),
      element_(dealii::FE_Q<dim>(static_cast<unsigned>(degree)), dim), numbering_(triangulation_) {
  make_cells();
  numbering_.distribute_dofs(element_);
  own_ = numbering_.locally_owned_dofs();
  dealii::DoFTools::extract_locally_relevant_dofs(numbering_, relevant_);
}

/// A box starts from its coarsest lattice, any other body from all its cells.
template<int dim>
void DistributedMesh<dim>::make_cells() {
  const Grid& grid = specimen_.grid;
  if (specimen_.n_matter_cells() == grid.n_cells()) {
    const int n = halvings(grid.cells(), dim);
    std::vector<unsigned> coarsest;
    dealii::Point<dim> upper;
    for (unsigned a = 0; a < dim; ++a) {
      coarsest.push_back(static_cast<unsigned>(grid.cells()[a] >> n));
      upper[a] = grid.cells()[a];
    }
    dealii::GridGenerator::subdivided_hyper_rectangle(triangulation_, coarsest, dealii::Point<dim>(), upper);
    triangulation_.refine_global(static_cast<unsigned>(n));
    return;
  }
  make_mesh_of_matter<dim>(
      specimen_,
      [](const Index3& node) {
        return Vec3{1.0 * node[0], 1.0 * node[1], 1.0 * node[2]};
      },
      triangulation_);
}

template<int dim>
std::vector<Vec3> DistributedMesh<dim>::own_positions(const Element<dim>& of_cell) const {
  std::vector<Vec3> positions(own_.n_elements() / dim);
  std::vector<dealii::types::global_dof_index> unknowns(element_.n_dofs_per_cell());
  for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    const Vec3 corner = specimen_.position(specimen_.grid.cell_at(of_grid));
    for (int node = 0; node < of_cell.n_nodes(); ++node) {
      const auto first = unknowns[element_.component_to_system_index(0, static_cast<unsigned>(node))];
      if (!own_.is_element(first))
        continue;
      Vec3& x = positions[own_.index_within_set(first) / dim];
      for (std::size_t a = 0; a < 3; ++a)
        x[a] = corner[a] + of_cell.offset(node)[a];
    }
  });
  return positions;
}

/// Same as Solver::solve, in two or three dimensions, without recovered stress. Collective: every rank must
/// pass the same scene, and receives the whole answer. Cells, unknowns and the matrix are distributed; the
/// scene, p4est's coarse mesh and the answer are replicated on each rank. The mesh of a box starts from its
/// coarsest lattice, other meshes from all cells.
Result solve_distributed(const Scene& scene, const Options& options, Watch& watch);

} // namespace maille::fem_ref
