#include "discretization/element.hpp"
#include "problem.hpp"

#include "maille/scene/cell_fields.hpp"
#include "maille/scene/frame.hpp"

#include <deal.II/base/quadrature_lib.h>

namespace maille::fem_ref {
namespace {

/// Extrapolation matrix from the points of a Gauss rule of `points` points per axis to the cell's corners, by
/// linear polynomials: corners x points.
template<int dim>
Eigen::MatrixXd to_corners(unsigned points) {
  const dealii::QGauss<1> line(points);
  const auto n = static_cast<Eigen::Index>(std::pow(points, dim));
  Eigen::MatrixXd weights(1 << dim, n);
  for (int corner = 0; corner < (1 << dim); ++corner)
    for (Eigen::Index q = 0; q < n; ++q) {
      double weight = 1;
      auto rest = static_cast<unsigned>(q);
      for (int a = 0; a < dim && points == 2; ++a, rest /= 2) {
        const double here = line.point(rest % 2)[0], other = line.point(1 - rest % 2)[0];
        weight *= ((corner >> a & 1) - other) / (here - other);
      }
      weights(corner, q) = weight;
    }
  return weights;
}

/// Material of every grid node for output: the most frequent one of its cells, the first of equals.
std::vector<std::uint8_t> shown_materials(const Specimen& specimen) {
  const Grid& grid = specimen.grid;
  std::vector<std::uint8_t> shown(grid.n_nodes(), no_material);
  for (std::size_t node = 0; node < shown.size(); ++node) {
    std::array<int, 256> count{};
    int most = 0;
    specimen.for_each_cell_at(grid.node_at(static_cast<std::int64_t>(node)), [&](std::int64_t cell) {
      const std::uint8_t material = specimen.material(cell);
      const int n = ++count[material];
      if (n > most || (n == most && material < shown[node])) {
        most = n;
        shown[node] = material;
      }
    });
  }
  return shown;
}

struct Sum {
  std::array<double, 6> strain{}, stress{};
  double volume = 0;

  void add(double weight, const std::pair<std::array<double, 6>, std::array<double, 6>>& values) {
    volume += weight;
    for (std::size_t k = 0; k < 6; ++k) {
      strain[k] += weight * values.first[k];
      stress[k] += weight * values.second[k];
    }
  }
};

void fill(const std::vector<Sum>& sums, Answer& answer) {
  answer.nodal_strain.assign(sums.size(), {});
  answer.nodal_stress.assign(sums.size(), {});
  for (std::size_t node = 0; node < sums.size(); ++node)
    for (std::size_t k = 0; k < 6 && sums[node].volume > 0; ++k) {
      answer.nodal_strain[node][k] = sums[node].strain[k] / sums[node].volume;
      answer.nodal_stress[node][k] = sums[node].stress[k] / sums[node].volume;
    }
}

} // namespace

/// Strains of a cell at its corners, corners x strains: evaluated at the points of the Gauss rule of `degree`
/// points per axis, where they are most accurate (Barlow 1976), and extrapolated linearly. @return the cell's
/// volume
template<int dim>
double Problem<dim>::corner_strains(int cell, const dealii::Vector<double>& u,
                                    Eigen::MatrixXd& strains) const {
  const Element<dim>& element = body_.element();
  const dealii::QGauss<dim> rule(static_cast<unsigned>(options_->degree));
  const Eigen::MatrixXd X = positions(cell);
  Eigen::VectorXd local(element.n_unknowns());
  for (Eigen::Index i = 0; i < local.size(); ++i)
    local(i) = u[dim * body_.nodes(cell)[i / dim] + static_cast<unsigned>(i % dim)];
  Eigen::MatrixXd at_points(rule.size(), Element<dim>::n_strains);
  double volume = 0;
  for (unsigned q = 0; q < rule.size(); ++q) {
    Vec3 at{0, 0, 0};
    for (unsigned a = 0; a < dim; ++a)
      at[a] = rule.point(q)[a];
    const Gradients<dim> gradients = gradients_at(element, X, at);
    at_points.row(q) = (strain_matrix<dim>(gradients.of_shape) * local).transpose();
    volume += rule.weight(q) * gradients.volume;
  }
  strains = to_corners<dim>(static_cast<unsigned>(options_->degree)) * at_points;
  return volume;
}

/// Volume-weighted mean over those cells around a node that have its material: stress is discontinuous
/// between materials.
template<int dim>
void Problem<dim>::recover(const dealii::Vector<double>& u, Answer& answer) const {
  const Specimen& specimen = scene_->specimen;
  const std::vector<std::uint8_t> shown = shown_materials(specimen);
  std::vector<Sum> sums(shown.size());
  Eigen::MatrixXd strains;
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const std::int64_t grid_cell = body_.grid_cell(cell);
    const double volume = specimen.tissue_of(grid_cell) * corner_strains(cell, u, strains);
    const StrainAndStress whole(*scene_, grid_cell);
    for (int corner = 0; corner < (1 << dim); ++corner) {
      const auto node =
          static_cast<std::size_t>(specimen.grid.corner(specimen.grid.cell_at(grid_cell), corner));
      if (shown[node] == specimen.material(grid_cell))
        sums[node].add(volume, whole(strains.row(corner).transpose()));
    }
  }
  fill(sums, answer);
}

template<int dim>
std::vector<std::array<double, 6>> Problem<dim>::mean_strains(const dealii::Vector<double>& u) const {
  if (object_frame(*scene_).is_turned)
    return {}; // strain requires the gradient in the frame of the rotated body
  const Element<dim>& element = body_.element();
  const Grid& grid = scene_->specimen.grid;
  double volume = 1;
  for (std::size_t a = 0; a < dim; ++a)
    volume *= grid.spacing()[a];
  const Eigen::MatrixXd mean = element.stress_load().transpose() / volume;
  // Voigt order with engineering shear, of the dimension, to XX YY ZZ XY YZ XZ.
  constexpr std::array<std::array<int, 6>, 3> places{
      {{0, -1, -1, -1, -1, -1}, {0, 1, 3, -1, -1, -1}, {0, 1, 2, 4, 5, 3}}};
  std::vector<std::array<double, 6>> strains(grid.n_cells());
  dealii::Vector<double> of_cell(static_cast<unsigned>(element.n_unknowns()));
  std::vector<dealii::types::global_dof_index> at;
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    unknowns(cell, at);
    for (unsigned i = 0; i < of_cell.size(); ++i)
      of_cell[i] = u[at[i]];
    take_out_shift<dim>(of_cell);
    const Eigen::VectorXd strain =
        mean * Eigen::Map<const Eigen::VectorXd>(of_cell.begin(), element.n_unknowns());
    auto& kept = strains[body_.grid_cell(cell)];
    for (Eigen::Index k = 0; k < strain.size(); ++k) {
      const int place = places[dim - 1][k];
      kept[place] = strain(k) * (place < 3 ? 1 : 0.5);
    }
  }
  return strains;
}

template std::vector<std::array<double, 6>> Problem<1>::mean_strains(const dealii::Vector<double>&) const;
template std::vector<std::array<double, 6>> Problem<2>::mean_strains(const dealii::Vector<double>&) const;
template std::vector<std::array<double, 6>> Problem<3>::mean_strains(const dealii::Vector<double>&) const;
template void Problem<1>::recover(const dealii::Vector<double>&, Answer&) const;
template void Problem<2>::recover(const dealii::Vector<double>&, Answer&) const;
template void Problem<3>::recover(const dealii::Vector<double>&, Answer&) const;

} // namespace maille::fem_ref
