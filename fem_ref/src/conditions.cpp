#include "problem.hpp"

#include <cmath>
#include <limits>

namespace maille::fem_ref {
namespace {

void prescribe(Prescription& prescription, unsigned unknown, double value) {
  if (prescription.is_prescribed[unknown])
    return;
  prescription.is_prescribed[unknown] = true;
  prescription.values[unknown] = value;
}

} // namespace

template<int dim>
Prescription Problem<dim>::prescription() const {
  Prescription prescription{std::vector<bool>(dim * body_.n_nodes(), false),
                            dealii::Vector<double>(dim * body_.n_nodes())};
  if (options_->boundary_displacement)
    prescribe_whole_boundary(prescription);
  else
    prescribe_by_scene(prescription);
  return prescription;
}

/// A node is prescribed where all of its parent corners are: for degree 2 that takes in mid points of edges,
/// faces and cells, inside the body too, with the mean of the corners' values.
template<int dim>
void Problem<dim>::prescribe_by_scene(Prescription& prescription) const {
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
          prescribe(prescription, dim * body_.nodes(cell)[static_cast<std::size_t>(i)] + c, mean);
      }
    }
  }
}

template<int dim>
void Problem<dim>::prescribe_whole_boundary(Prescription& prescription) const {
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
            prescribe(prescription, dim * node + c, u[c]);
        }
      }
  }
}

template Prescription Problem<1>::prescription() const;
template Prescription Problem<2>::prescription() const;
template Prescription Problem<3>::prescription() const;

} // namespace maille::fem_ref
