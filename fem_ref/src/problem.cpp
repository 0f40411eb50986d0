#include "problem.hpp"

#include "discretization/cell_matrices.hpp"
#include "discretization/prescribed_in_cell.hpp"
#include "maille/mechanics/friction.hpp"

#include <deal.II/dofs/dof_tools.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace maille::fem_ref {

using DofIndices = std::vector<dealii::types::global_dof_index>;

std::int64_t LinearSystem::bytes() const {
  return static_cast<std::int64_t>(pattern.memory_consumption() + matrix.memory_consumption() +
                                   constraints.memory_consumption() + positions.size() * sizeof(Vec3));
}

template<int dim>
Problem<dim>::Problem(const Scene& scene, const Options& options, bool meshed)
    : scene_(&scene), options_(&options), body_(scene.specimen, options.degree, meshed) {
  if (options.shape)
    body_.place(options.shape);
  if (!has_friction(scene.tied))
    return;
  std::map<std::int64_t, unsigned> of_mesh;
  for (int cell = 0; cell < body_.n_cells(); ++cell)
    for (int corner = 0; corner < (1 << dim); ++corner)
      of_mesh[scene.specimen.grid.corner(scene.specimen.grid.cell_at(body_.grid_cell(cell)), corner)] =
          body_.nodes(cell)[corner];
  for (const NodeTie& tie : scene.tied.ties)
    rubbing_.push_back({of_mesh.at(tie.one), of_mesh.at(tie.other)});
}

template<int dim>
void Problem<dim>::for_each_rubbing(
    const std::function<void(unsigned, unsigned, const NodeTie&)>& visit) const {
  for (std::size_t t = 0; t < rubbing_.size(); ++t)
    if (scene_->tied.ties[t].spring > 0)
      visit(rubbing_[t][0], rubbing_[t][1], scene_->tied.ties[t]);
}

template<int dim>
void Problem<dim>::outline(LinearSystem& system, const std::vector<bool>& is_prescribed,
                           const Ties& ties) const {
  const Index3& cells = scene_->specimen.grid.cells();
  system.dimension = dim;
  system.degree = options_->degree;
  system.longest = options_->degree * *std::max_element(cells.begin(), cells.end()) + 1;
  for (unsigned i = 0; i < is_prescribed.size(); ++i)
    if (is_prescribed[i])
      system.constraints.add_line(i);
  ties.constrain(is_prescribed, system.constraints);
  system.constraints.close();
  make_pattern(system, ties);
  system.positions = body_.positions();
}

template<int dim>
void Problem<dim>::assemble(LinearSystem& system, const std::vector<bool>& is_prescribed, const Ties& ties) {
  outline(system, is_prescribed, ties);
  body_.release_mesh(); // as large as the matrix, and no longer needed
  system.matrix.reinit(system.pattern);
  add_cells(system);
}

template<int dim>
void Problem<dim>::unknowns(int cell, DofIndices& unknowns) const {
  unknowns.clear();
  for (const unsigned node : body_.nodes(cell))
    for (unsigned c = 0; c < dim; ++c)
      unknowns.push_back(dim * node + c);
}

/// Node couplings from deal.II, each expanded to dim x dim unknowns. Prescribed rows keep only their
/// diagonal, as do rows of dependent unknowns, whose couplings move to the independent ones.
template<int dim>
void Problem<dim>::make_pattern(LinearSystem& system, const Ties& ties) const {
  const unsigned n = body_.n_nodes();
  dealii::DynamicSparsityPattern nodes(n);
  dealii::DoFTools::make_sparsity_pattern(body_.numbering(), nodes);
  dealii::DynamicSparsityPattern unknowns(dim * n);
  DofIndices row;
  for (unsigned i = 0; i < n; ++i) {
    row.clear();
    for (auto entry = nodes.begin(i); entry != nodes.end(i); ++entry)
      for (unsigned c = 0; c < dim; ++c)
        if (!system.constraints.is_constrained(dim * entry->column() + c))
          row.push_back(dim * entry->column() + c);
    for (unsigned c = 0; c < dim; ++c)
      if (system.constraints.is_constrained(dim * i + c))
        unknowns.add(dim * i + c, dim * i + c);
      else
        unknowns.add_entries(dim * i + c, row.begin(), row.end(), true);
  }
  for (int cell = 0; cell < body_.n_cells() && !ties.empty(); ++cell) {
    this->unknowns(cell, row);
    if (std::ranges::any_of(row, [&](auto unknown) { return ties.follows(static_cast<unsigned>(unknown)); }))
      system.constraints.add_entries_local_to_global(row, unknowns, false);
  }
  for_each_rubbing([&](unsigned one, unsigned other, const NodeTie&) {
    row.clear();
    for (const unsigned node : {one, other})
      for (unsigned c = 0; c < dim; ++c)
        row.push_back(dim * node + c);
    system.constraints.add_entries_local_to_global(row, unknowns, false);
  });
  system.pattern.copy_from(unknowns);
}

/// Positions of a cell's nodes, nodes x dim.
template<int dim>
Eigen::MatrixXd Problem<dim>::positions(int cell) const {
  const auto nodes = body_.nodes(cell);
  Eigen::MatrixXd X(static_cast<Eigen::Index>(nodes.size()), dim);
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::size_t a = 0; a < dim; ++a)
      X(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(a)) = body_.positions()[nodes[i]][a];
  return X;
}

template<int dim>
std::function<Eigen::MatrixXd(int)> Problem<dim>::mapped_positions() const {
  if (!options_->shape)
    return {};
  return [this](int cell) { return positions(cell); };
}

template<int dim>
Eigen::VectorXd Problem<dim>::face_load(const FaceLoad& face) const {
  if (!options_->shape)
    return body_.element().face_load(face.axis, face.upper);
  const Eigen::MatrixXd X = positions(body_.mesh_cell(face.cell));
  return MappedCell<dim>(body_.element(), X).face_load(face.axis, face.upper);
}

template<int dim>
void Problem<dim>::add_cells(LinearSystem& system) const {
  CellMatrices<dim> matrices(*scene_, body_.element(), mapped_positions());
  DofIndices at;
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    unknowns(cell, at);
    system.constraints.distribute_local_to_global(matrices(body_.grid_cell(cell), cell), at, system.matrix);
  }
  add_springs(system);
}

template<int dim>
void Problem<dim>::for_each_spring(
    const std::function<void(unsigned, const Eigen::Matrix<double, dim, dim>&)>& visit) const {
  for (const FaceSpring& spring : scene_->springs) {
    const int cell = body_.mesh_cell(spring.cell);
    const Eigen::VectorXd share = face_load({spring.cell, spring.axis, spring.upper, {}});
    Eigen::Matrix<double, dim, dim> stiffness = Eigen::Matrix<double, dim, dim>::Identity();
    if (const Eigen::Vector3d n(spring.direction[0], spring.direction[1], spring.direction[2]); !n.isZero(0))
      stiffness = n.template head<dim>() * n.template head<dim>().transpose();
    for (Eigen::Index i = 0; i < share.size(); ++i)
      if (share[i] != 0)
        visit(body_.nodes(cell)[i], spring.stiffness * share[i] * stiffness);
  }
}

template<int dim>
void Problem<dim>::add_springs(LinearSystem& system) const {
  dealii::FullMatrix<double> block(dim, dim);
  DofIndices at(dim);
  for_each_spring([&](unsigned node, const Eigen::Matrix<double, dim, dim>& stiffness) {
    for (unsigned b = 0; b < dim; ++b) {
      at[b] = dim * node + b;
      for (unsigned a = 0; a < dim; ++a)
        block(a, b) = stiffness(a, b);
    }
    system.constraints.distribute_local_to_global(block, at, system.matrix);
  });
  dealii::FullMatrix<double> pair(2 * dim, 2 * dim);
  at.resize(2 * dim);
  for_each_rubbing([&](unsigned one, unsigned other, const NodeTie& tie) {
    for (unsigned i = 0; i < 2 * dim; ++i) {
      at[i] = dim * (i < dim ? one : other) + i % dim;
      for (unsigned j = 0; j < 2 * dim; ++j) {
        const double across = tie.normal[i % dim] * tie.normal[j % dim];
        pair(i, j) = (i / dim == j / dim ? 1 : -1) * tie.spring * ((i % dim == j % dim ? 1 : 0) - across);
      }
    }
    system.constraints.distribute_local_to_global(pair, at, system.matrix);
  });
}

template<int dim>
void Problem<dim>::add_body_force(int cell, const Samples& samples, dealii::Vector<double>& load) const {
  const Vec3 corner = scene_->specimen.position(scene_->specimen.grid.cell_at(body_.grid_cell(cell)));
  for (std::size_t q = 0; q < samples.points.size(); ++q) {
    const Vec3& p = samples.points[q];
    const Vec3 force = options_->body_force({corner[0] + p[0], corner[1] + p[1], corner[2] + p[2]});
    for (unsigned i = 0; i < load.size(); ++i)
      load[i] += samples.weights[q] * force[i % dim] * samples.shape(static_cast<Eigen::Index>(q), i / dim);
  }
}

template<int dim>
void Problem<dim>::add_active_stress(int cell, dealii::Vector<double>& load) const {
  const Eigen::VectorXd stress =
      scene_->specimen.tissue_of(body_.grid_cell(cell)) * scene_->cell_active_stress(body_.grid_cell(cell));
  if (stress.isZero(0))
    return;
  Eigen::VectorXd pull;
  if (options_->shape) {
    const Eigen::MatrixXd X = positions(cell);
    pull = MappedCell<dim>(body_.element(), X).stress_load() * stress;
  } else {
    pull = body_.element().stress_load() * stress;
  }
  for (unsigned i = 0; i < load.size(); ++i)
    load[i] -= pull[i];
}

template<int dim>
double Problem<dim>::residual_forces(const dealii::Vector<double>& u, dealii::Vector<double>& forces,
                                     std::vector<double>* cell_energy) const {
  CellMatrices<dim> matrices(*scene_, body_.element(), mapped_positions());
  const Samples samples = body_.element().samples(options_->degree + 3);
  Eigen::VectorXd weights = body_.element().volume_load();
  const bool is_heavy = scene_->gravity != Vec3{0, 0, 0};
  const auto n = static_cast<unsigned>(body_.element().n_unknowns());
  dealii::Vector<double> load(n), of_cell(n), force(n);
  double energy = 0;
  if (cell_energy)
    cell_energy->assign(static_cast<std::size_t>(scene_->specimen.grid.n_cells()), 0);
  DofIndices at;
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const std::int64_t grid_cell = body_.grid_cell(cell);
    const double density = scene_->specimen.tissue_of(grid_cell) *
                           scene_->materials[scene_->specimen.material(grid_cell)].density;
    unknowns(cell, at);
    if (options_->shape && is_heavy) {
      const Eigen::MatrixXd X = positions(cell);
      weights = MappedCell<dim>(body_.element(), X).volume_load();
    }
    for (unsigned i = 0; i < n; ++i) {
      load[i] = density * scene_->gravity[i % dim] * weights[i / dim];
      of_cell[i] = u[at[i]];
    }
    take_out_shift<dim>(of_cell);
    if (scene_->contracts())
      add_active_stress(cell, load);
    if (options_->body_force)
      add_body_force(cell, samples, load);
    matrices(grid_cell, cell).vmult(force, of_cell);
    const double part = 0.5 * (of_cell * force);
    if (cell_energy)
      (*cell_energy)[grid_cell] = part;
    energy += part;
    for (unsigned i = 0; i < n; ++i)
      forces[at[i]] += force[i] - load[i];
  }
  for (const FaceLoad& face : scene_->tractions) {
    unknowns(body_.mesh_cell(face.cell), at);
    const Eigen::VectorXd share = face_load(face);
    for (unsigned i = 0; i < n; ++i)
      forces[at[i]] -= face.traction[i % dim] * share[i / dim];
  }
  for_each_spring([&](unsigned node, const Eigen::Matrix<double, dim, dim>& stiffness) {
    for (unsigned a = 0; a < dim; ++a)
      for (unsigned b = 0; b < dim; ++b)
        forces[dim * node + a] += stiffness(a, b) * u[dim * node + b];
  });
  for_each_rubbing([&](unsigned one, unsigned other, const NodeTie& tie) {
    Vec3 apart{};
    for (unsigned a = 0; a < dim; ++a)
      apart[a] = u[dim * one + a] - u[dim * other + a];
    const Vec3 rub = rub_of(tie, apart);
    for (unsigned a = 0; a < dim; ++a) {
      forces[dim * one + a] -= rub[a];
      forces[dim * other + a] += rub[a];
    }
  });
  return energy;
}

/// The reaction at a mid-point of prescribed corners is split equally between those corners, which preserves
/// total force and its work along the displacements of the corners.
template<int dim>
std::vector<double> Problem<dim>::reactions(const dealii::Vector<double>& forces) const {
  const Grid& grid = scene_->specimen.grid;
  const PrescribedInCell<dim> known(*scene_);
  std::vector<double> reaction(scene_->prescribed.size(), 0);
  std::vector<bool> is_done(forces.size(), false);
  for (int cell = 0; cell < body_.n_cells(); ++cell)
    for (int i = 0; i < body_.element().n_nodes(); ++i)
      for (unsigned c = 0; c < dim; ++c) {
        const unsigned unknown = dim * body_.nodes(cell)[i] + c;
        const std::vector<int>& parents = body_.element().parents(i);
        const auto entry_of = [&](int corner) {
          return known.entry(grid.cell_at(body_.grid_cell(cell)), corner, c);
        };
        if (is_done[unknown] ||
            std::ranges::any_of(parents, [&](int k) { return entry_of(k) == known.none; }))
          continue;
        is_done[unknown] = true;
        for (const int corner : parents)
          reaction[entry_of(corner)] += forces[unknown] / static_cast<double>(parents.size());
      }
  return reaction;
}

template<int dim>
Displacement Problem<dim>::at_grid_nodes(const dealii::Vector<double>& u) const {
  const Grid& grid = scene_->specimen.grid;
  Displacement displacement(grid);
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(body_.grid_cell(cell));
    for (int corner = 0; corner < (1 << dim); ++corner)
      for (int c = 0; c < dim; ++c)
        displacement(c, grid.corner(at, corner)) =
            u[dim * body_.nodes(cell)[corner] + static_cast<unsigned>(c)];
  }
  return displacement;
}

template<int dim>
double Problem<dim>::l2_error(const dealii::Vector<double>& u) const {
  const Samples samples = body_.element().samples(options_->degree + 3);
  double squared = 0;
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const auto nodes = body_.nodes(cell);
    const Vec3 corner = scene_->specimen.position(scene_->specimen.grid.cell_at(body_.grid_cell(cell)));
    for (std::size_t q = 0; q < samples.points.size(); ++q) {
      const Vec3& p = samples.points[q];
      const Vec3 exact = options_->exact({corner[0] + p[0], corner[1] + p[1], corner[2] + p[2]});
      for (unsigned c = 0; c < dim; ++c) {
        double difference = -exact[c];
        for (std::size_t i = 0; i < nodes.size(); ++i)
          difference += samples.shape(static_cast<Eigen::Index>(q), static_cast<Eigen::Index>(i)) *
                        u[dim * nodes[i] + c];
        squared += samples.weights[q] * difference * difference;
      }
    }
  }
  return std::sqrt(squared);
}

template class Problem<1>;
template class Problem<2>;
template class Problem<3>;

} // namespace maille::fem_ref
