

#include "solvers/multigrid_mesh.hpp"

#include <deal.II/grid/grid_generator.h>

#include <algorithm>

namespace maille::fem_ref {

template<int dim>
NodeLattice<dim> NodeLattice<dim>::coarser() const {
  NodeLattice coarse;
  coarse.degree_ = degree_;
  for (std::size_t a = 0; a < dim; ++a)
    coarse.n_[a] = (n_[a] - 1) / 2 + 1;
  coarse.fixed_.resize(fixed_.size());
  Index3 at{0, 0, 0};
  for (at[2] = 0; at[2] < n_[2]; ++at[2])
    for (at[1] = 0; at[1] < n_[1]; ++at[1])
      for (at[0] = 0; at[0] < n_[0]; ++at[0])
        if (const std::uint8_t bits = fixed(at); bits != 0)
          for (int corner = 0; corner < (1 << dim); ++corner) {
            Index3 parent{0, 0, 0};
            for (std::size_t a = 0; a < dim; ++a)
              parent[a] = (at[a] + (corner >> a & 1)) / 2;
            coarse.fixed(parent) |= bits;
          }
  return coarse;
}

template<int dim>
Mesh<dim>::Mesh(const Index3& cells, int degree)
    : triangulation_(dealii::Triangulation<dim>::limit_level_difference_at_vertices),
      element_(dealii::FE_Q<dim>(static_cast<unsigned>(degree)), dim), numbering_(triangulation_),
      n_levels_(halvings(cells, dim) + 1) {
  std::vector<unsigned> coarsest;
  dealii::Point<dim> upper;
  for (unsigned a = 0; a < dim; ++a) {
    coarsest.push_back(static_cast<unsigned>(cells[a]) >> (n_levels_ - 1));
    upper[a] = cells[a];
  }
  dealii::GridGenerator::subdivided_hyper_rectangle(triangulation_, coarsest, dealii::Point<dim>(), upper);
  triangulation_.refine_global(static_cast<unsigned>(n_levels_ - 1));
  numbering_.distribute_dofs(element_);
  numbering_.distribute_mg_dofs();
  for (unsigned i = 0; i < element_.n_dofs_per_cell(); ++i)
    if (const auto [component, node] = element_.system_to_component_index(i); component == 0)
      first_unknown_.push_back(i);
}

template<int dim>
void Mesh<dim>::check(const std::vector<dealii::types::global_dof_index>& unknowns) const {
  for (unsigned i = 0; i < unknowns.size(); ++i) {
    const auto [component, node] = element_.system_to_component_index(i);
    AssertThrow(unknowns[i] == unknowns[first_unknown_[node]] + component, dealii::ExcInternalError());
  }
}

template<int dim>
Level<dim> make_level(const Mesh<dim>& mesh, int level, const NodeLattice<dim>& lattice,
                      const Element<dim>& element) {
  Level<dim> out;
  out.n_unknowns =
      level < 0 ? mesh.numbering().n_dofs() : mesh.numbering().n_dofs(static_cast<unsigned>(level));
  std::vector<bool> is_fixed(out.n_unknowns, false);
  mesh.for_each_cell(level, [&](const Index3& cell, const std::vector<unsigned>& nodes) {
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      Index3 at{0, 0, 0};
      for (std::size_t a = 0; a < dim; ++a)
        at[a] = lattice.degree() * cell[a] + element.place(static_cast<int>(k))[a];
      for (unsigned c = 0; c < dim; ++c)
        if (lattice.fixed(at) >> c & 1)
          is_fixed[nodes[k] + c] = true;
      out.nodes.push_back(nodes[k]);
    }
  });
  for (unsigned i = 0; i < out.n_unknowns; ++i)
    if (is_fixed[i])
      out.fixed.push_back(i);
  return out;
}

template class NodeLattice<2>;
template class Mesh<2>;
template Level<2> make_level(const Mesh<2>&, int, const NodeLattice<2>&, const Element<2>&);
template class NodeLattice<3>;
template class Mesh<3>;
template Level<3> make_level(const Mesh<3>&, int, const NodeLattice<3>&, const Element<3>&);

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
  if (body.has_weights())
    return "cells have weights of their own";
  if (!scene.springs.empty())
    return "there are springs to the ground";
  const std::uint8_t material = body.material(0);
  // Check stored numbers only, if there are any: a box too large for memory must be refused at once.
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
