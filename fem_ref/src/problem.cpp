#include "problem.hpp"

#include <algorithm>
#include <cmath>
#include <deal.II/dofs/dof_tools.h>

namespace maille::fem_ref {

using DofIndices = std::vector<dealii::types::global_dof_index>;

std::int64_t LinearSystem::bytes() const {
  return static_cast<std::int64_t>(pattern.memory_consumption() + matrix.memory_consumption() +
                                   right_hand_side.memory_consumption() + constraints.memory_consumption() +
                                   positions.size() * sizeof(Vec3));
}

template<int dim>
Problem<dim>::Problem(const Scene& scene, const Options& options)
    : scene_(&scene), options_(&options), body_(scene.specimen, options.degree) {}

template<int dim>
void Problem<dim>::assemble(LinearSystem& system) {
  const Index3& cells = scene_->specimen.grid.cells();
  system.dimension = dim;
  system.degree = options_->degree;
  system.longest = options_->degree * *std::max_element(cells.begin(), cells.end()) + 1;
  constrain(system.constraints);
  make_pattern(system);
  body_.release_mesh(); // as large as the matrix; cells and nodes are known by now
  system.matrix.reinit(system.pattern);
  system.right_hand_side.reinit(dim * body_.n_nodes());
  add_cells(system);
  add_tractions(system);
  system.positions = body_.take_positions();
}

template<int dim>
DofIndices Problem<dim>::unknowns(int cell) const {
  DofIndices unknowns;
  unknowns.reserve(static_cast<std::size_t>(body_.element().n_unknowns()));
  for (const unsigned node : body_.nodes(cell))
    for (unsigned c = 0; c < dim; ++c)
      unknowns.push_back(dim * node + c);
  return unknowns;
}

/// Node couplings from deal.II, each widened to dim x dim unknowns; prescribed rows keep their diagonal only.
template<int dim>
void Problem<dim>::make_pattern(LinearSystem& system) const {
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
  system.pattern.copy_from(unknowns);
}

namespace {

/// Stiffness matrices of cells. Where neither matter nor fibre differ they are the same, and computed once.
template<int dim>
class CellMatrices {
public:
  CellMatrices(const Scene& scene, const Element<dim>& element)
      : scene_(&scene), element_(&element), of_material_(scene.materials.size()),
        scratch_(static_cast<unsigned>(element.n_unknowns())) {}

  const dealii::FullMatrix<double>& operator()(std::int64_t cell) {
    const std::uint8_t material = scene_->specimen.material(cell);
    const bool shared =
        scene_->specimen.fibres.empty() || scene_->materials[material].elasticity.is_isotropic();
    dealii::FullMatrix<double>& K = shared ? of_material_[material] : scratch_;
    if (shared && K.m() > 0)
      return K;
    K.reinit(scratch_.m(), scratch_.m(), true);
    element_->stiffness(scene_->cell_stiffness(cell), &K(0, 0));
    return K;
  }

private:
  const Scene* scene_;
  const Element<dim>* element_;
  std::vector<dealii::FullMatrix<double>> of_material_;
  dealii::FullMatrix<double> scratch_;
};

} // namespace

template<int dim>
void Problem<dim>::add_cells(LinearSystem& system) const {
  CellMatrices<dim> matrices(*scene_, body_.element());
  const Samples samples = body_.element().samples(options_->degree + 3);
  const Eigen::VectorXd& weights = body_.element().volume_load();
  dealii::Vector<double> load(static_cast<unsigned>(body_.element().n_unknowns()));
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const std::int64_t grid_cell = body_.grid_cell(cell);
    const double density = scene_->materials[scene_->specimen.material(grid_cell)].density;
    for (unsigned i = 0; i < load.size(); ++i)
      load[i] = density * scene_->gravity[i % dim] * weights[i / dim];
    if (options_->body_force)
      add_body_force(cell, samples, load);
    system.constraints.distribute_local_to_global(matrices(grid_cell), load, unknowns(cell), system.matrix,
                                                  system.right_hand_side);
  }
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
void Problem<dim>::add_tractions(LinearSystem& system) const {
  dealii::Vector<double> load(static_cast<unsigned>(body_.element().n_unknowns()));
  for (const FaceLoad& face : scene_->tractions) {
    const Eigen::VectorXd& weights = body_.element().face_load(face.axis, face.upper);
    for (unsigned i = 0; i < load.size(); ++i)
      load[i] = face.traction[i % dim] * weights[i / dim];
    system.constraints.distribute_local_to_global(load, unknowns(body_.mesh_cell(face.cell)),
                                                  system.right_hand_side);
  }
}

/// What keeps every unknown where it is, beside the loads: K u - f, cell by cell. @return the energy u K u / 2
template<int dim>
double Problem<dim>::residual_forces(const dealii::Vector<double>& u, dealii::Vector<double>& forces) const {
  CellMatrices<dim> matrices(*scene_, body_.element());
  const Samples samples = body_.element().samples(options_->degree + 3);
  const Eigen::VectorXd& weights = body_.element().volume_load();
  const auto n = static_cast<unsigned>(body_.element().n_unknowns());
  dealii::Vector<double> load(n), of_cell(n), force(n);
  double energy = 0;
  for (int cell = 0; cell < body_.n_cells(); ++cell) {
    const std::int64_t grid_cell = body_.grid_cell(cell);
    const double density = scene_->materials[scene_->specimen.material(grid_cell)].density;
    const DofIndices at = unknowns(cell);
    for (unsigned i = 0; i < n; ++i) {
      load[i] = density * scene_->gravity[i % dim] * weights[i / dim];
      of_cell[i] = u[at[i]];
    }
    if (options_->body_force)
      add_body_force(cell, samples, load);
    matrices(grid_cell).vmult(force, of_cell);
    energy += 0.5 * (of_cell * force);
    for (unsigned i = 0; i < n; ++i)
      forces[at[i]] += force[i] - load[i];
  }
  for (const FaceLoad& face : scene_->tractions) {
    const DofIndices at = unknowns(body_.mesh_cell(face.cell));
    const Eigen::VectorXd& share = body_.element().face_load(face.axis, face.upper);
    for (unsigned i = 0; i < n; ++i)
      forces[at[i]] -= face.traction[i % dim] * share[i / dim];
  }
  return energy;
}

/// Reactions at the scene's prescribed components. What holds a mid point whose place is the mean of prescribed corners goes to
/// those corners in equal parts, so that forces, and their work along the corners' displacements, stay what they are.
template<int dim>
void Problem<dim>::react(const dealii::Vector<double>& u, Answer& answer) const {
  dealii::Vector<double> forces(u.size());
  answer.strain_energy = residual_forces(u, forces);
  if (options_->boundary_displacement)
    return; // what is prescribed is not the scene's
  const Grid& grid = scene_->specimen.grid;
  constexpr int none = -1;
  const auto n_grid_nodes = static_cast<std::size_t>(grid.n_nodes());
  std::vector<int> entry(dim * n_grid_nodes, none);
  for (std::size_t i = 0; i < scene_->prescribed.size(); ++i)
    if (const Prescribed& p = scene_->prescribed[i]; p.component < dim)
      entry[static_cast<std::size_t>(p.component) * n_grid_nodes + static_cast<std::size_t>(p.node)] =
          static_cast<int>(i);
  answer.reaction.assign(scene_->prescribed.size(), 0);
  std::vector<bool> is_done(u.size(), false);
  for (int cell = 0; cell < body_.n_cells(); ++cell)
    for (int i = 0; i < body_.element().n_nodes(); ++i)
      for (unsigned c = 0; c < dim; ++c) {
        const unsigned unknown = dim * body_.nodes(cell)[static_cast<std::size_t>(i)] + c;
        const std::vector<int>& parents = body_.element().parents(i);
        const auto entry_of = [&](int corner) {
          const std::int64_t node = grid.corner(grid.cell_at(body_.grid_cell(cell)), corner);
          return entry[c * n_grid_nodes + static_cast<std::size_t>(node)];
        };
        if (is_done[unknown] || std::ranges::any_of(parents, [&](int k) { return entry_of(k) == none; }))
          continue;
        is_done[unknown] = true;
        for (const int corner : parents)
          answer.reaction[static_cast<std::size_t>(entry_of(corner))] +=
              forces[unknown] / static_cast<double>(parents.size());
      }
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
            u[dim * body_.nodes(cell)[static_cast<std::size_t>(corner)] + static_cast<unsigned>(c)];
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
