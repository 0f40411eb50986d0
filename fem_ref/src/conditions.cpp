#include "discretization/prescribed_in_cell.hpp"
#include "problem.hpp"

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

template<int dim>
void Problem<dim>::prescribe_by_scene(Prescription& prescription) const {
  const PrescribedInCell<dim> known(*scene_);
  for (int cell = 0; cell < body_.n_cells(); ++cell)
    known.for_each(body_.element(), scene_->specimen.grid.cell_at(body_.grid_cell(cell)),
                   [&](int node, unsigned component, double value) {
                     prescribe(prescription, dim * body_.nodes(cell)[node] + component, value);
                   });
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
          const unsigned node = body_.nodes(cell)[i];
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
