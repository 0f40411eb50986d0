#pragma once
/// A body as deal.II's hierarchy of meshes, each with half the cells of the next along every axis, and the
/// fixed unknowns of each level.

#include "discretization/element.hpp"
#include "maille/scene/scene.hpp"

#include <deal.II/dofs/dof_handler.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/grid/tria.h>

#include <cstdint>
#include <string>
#include <vector>

namespace maille::fem_ref {

/// One level of the box, and its fixed unknowns.
template<int dim>
struct Level {
  std::vector<unsigned> nodes; ///< for every node of every cell, its unknown of component 0
  std::vector<unsigned> fixed;
  std::size_t n_unknowns = 0;
};

/// Nodes of a level as a lattice of degree x cells + 1 along every axis.
template<int dim>
class NodeLattice {
public:
  NodeLattice(const Index3& cells, int degree) : degree_(degree) {
    for (std::size_t a = 0; a < dim; ++a)
      n_[a] = degree * cells[a] + 1;
    fixed_.resize(static_cast<std::size_t>(n_[0]) * static_cast<std::size_t>(n_[1]) *
                  static_cast<std::size_t>(n_[2]));
  }
  int degree() const { return degree_; }
  std::size_t index(const Index3& at) const {
    return static_cast<std::size_t>(at[0]) +
           static_cast<std::size_t>(n_[0]) *
               (static_cast<std::size_t>(at[1]) +
                static_cast<std::size_t>(n_[1]) * static_cast<std::size_t>(at[2]));
  }
  /// One bit a component.
  std::uint8_t& fixed(const Index3& at) { return fixed_[index(at)]; }
  std::uint8_t fixed(const Index3& at) const { return fixed_[index(at)]; }

  /// Fixed components of the next coarser level: a node is fixed if a fixed node interpolates from it.
  NodeLattice coarser() const;

private:
  NodeLattice() = default;
  int degree_ = 1;
  Index3 n_{1, 1, 1};
  std::vector<std::uint8_t> fixed_;
};

/// The triangulation in units of the finest cells, so that node positions are integers.
template<int dim>
class Mesh {
public:
  Mesh(const Index3& cells, int degree);
  const dealii::DoFHandler<dim>& numbering() const { return numbering_; }
  int n_levels() const { return n_levels_; }

  /// Visits every cell of a level (level -1: in the body's own numbering) with its position on the level's
  /// lattice and the unknowns of component 0 of its nodes.
  template<class Visit>
  void for_each_cell(int level, const Visit& visit) const {
    const int size = level < 0 ? 1 : 1 << (n_levels_ - 1 - level);
    std::vector<dealii::types::global_dof_index> unknowns(element_.n_dofs_per_cell());
    std::vector<unsigned> nodes(first_unknown_.size());
    const auto take = [&](const auto& cell) {
      Index3 at{0, 0, 0};
      for (unsigned a = 0; a < dim; ++a)
        at[a] = static_cast<int>(cell->vertex(0)[a] / size + 0.5);
      for (std::size_t k = 0; k < nodes.size(); ++k)
        nodes[k] = unknowns[first_unknown_[k]];
      visit(at, nodes);
    };
    if (level < 0)
      for (const auto& cell : numbering_.active_cell_iterators()) {
        cell->get_dof_indices(unknowns);
        check(unknowns);
        take(cell);
      }
    else
      for (const auto& cell : numbering_.mg_cell_iterators_on_level(static_cast<unsigned>(level))) {
        cell->get_mg_dof_indices(unknowns);
        take(cell);
      }
  }

private:
  /// Components of a node are numbered one after the other.
  void check(const std::vector<dealii::types::global_dof_index>& unknowns) const;

  dealii::Triangulation<dim> triangulation_;
  dealii::FESystem<dim> element_;
  dealii::DoFHandler<dim> numbering_;
  std::vector<unsigned> first_unknown_; ///< by node of the element
  int n_levels_;
};

/// @param level  -1: the finest mesh in the body's own numbering, used by CG
template<int dim>
Level<dim> make_level(const Mesh<dim>& mesh, int level, const NodeLattice<dim>& lattice,
                      const Element<dim>& element);

/// Number of times that all axes can be halved.
int halvings(const Index3& cells, int dimension);
/// Reason that the body has no hierarchy of meshes, in words; empty if it has one: a box of equal cells, with
/// an even number of them along every axis.
std::string why_no_hierarchy(const Scene& scene);
/// Unknowns of the coarsest mesh: every axis is halved while all numbers of cells stay integers.
std::int64_t coarsest_unknowns(const Scene& scene, int degree);

} // namespace maille::fem_ref
