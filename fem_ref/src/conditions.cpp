#include "problem.hpp"

#include <cmath>
#include <limits>

namespace maille::fem_ref {
namespace {

void prescribe(dealii::AffineConstraints<double>& constraints, unsigned unknown, double value) {
  if (constraints.is_constrained(unknown))
    return;
  constraints.add_line(unknown);
  constraints.set_inhomogeneity(unknown, value);
}

} // namespace

template<int dim>
void Problem<dim>::constrain(dealii::AffineConstraints<double>& constraints) const {
  if (options_->boundary_displacement)
    constrain_whole_boundary(constraints);
  else
    constrain_by_scene(constraints);
  constraints.close();
}

/// A node is prescribed where all of its parent corners are: for degree 2 that takes in mid points of edges,
/// faces and cells, inside the body too, with the mean of the corners' values.
template<int dim>
void Problem<dim>::constrain_by_scene(dealii::AffineConstraints<double>& constraints) const {
  constexpr double is_free = std::numeric_limits<double>::quiet_NaN();
  const Grid& grid = scene_->specimen.grid;
  const auto n_grid_nodes = static_cast<std::size_t>(grid.n_nodes());
  std::vector<double> prescribed(dim * n_grid_nodes, is_free);
  for (const Prescribed& p : scene_->prescribed)
    if (p.component < dim)
      prescribed[static_cast<std::size_t>(p.component) * n_grid_nodes + static_cast<std::size_t>(p.node)] =
          p.value;

  const Element<dim>& element = body_.element();
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(body_.grid_cell(cell));
    for (unsigned c = 0; c < dim; ++c) {
      std::array<double, 1 << dim> values{};
      bool any = false;
      for (int corner = 0; corner < (1 << dim); ++corner) {
        const auto node = static_cast<std::size_t>(grid.corner(at, corner));
        values[static_cast<std::size_t>(corner)] = prescribed[c * n_grid_nodes + node];
        any = any || !std::isnan(values[static_cast<std::size_t>(corner)]);
      }
      for (int i = 0; any && i < element.n_nodes(); ++i) {
        double mean = 0;
        for (const int corner : element.parents(i))
          mean += values[static_cast<std::size_t>(corner)] / static_cast<double>(element.parents(i).size());
        if (!std::isnan(mean))
          prescribe(constraints, dim * body_.nodes(cell)[static_cast<std::size_t>(i)] + c, mean);
      }
    }
  }
}

template<int dim>
void Problem<dim>::constrain_whole_boundary(dealii::AffineConstraints<double>& constraints) const {
  const Specimen& specimen = scene_->specimen;
  const Element<dim>& element = body_.element();
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const Index3 at = specimen.grid.cell_at(body_.grid_cell(cell));
    for (std::size_t axis = 0; axis < dim; ++axis)
      for (const int side : {0, 1}) {
        Index3 neighbour = at;
        neighbour[axis] += side == 0 ? -1 : 1;
        if (specimen.grid.has_cell(neighbour) && specimen.is_matter(specimen.grid.cell(neighbour)))
          continue;
        for (int i = 0; i < element.n_nodes(); ++i) {
          if (element.place(i)[axis] != side * options_->degree)
            continue;
          const unsigned node = body_.nodes(cell)[static_cast<std::size_t>(i)];
          const Vec3 u = options_->boundary_displacement(body_.positions()[node]);
          for (unsigned c = 0; c < dim; ++c)
            prescribe(constraints, dim * node + c, u[c]);
        }
      }
  }
}

template void Problem<1>::constrain(dealii::AffineConstraints<double>&) const;
template void Problem<2>::constrain(dealii::AffineConstraints<double>&) const;
template void Problem<3>::constrain(dealii::AffineConstraints<double>&) const;

} // namespace maille::fem_ref
