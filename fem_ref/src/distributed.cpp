#include "distributed.hpp"

#include "amg_settings.hpp"
#include "cell_matrices.hpp"
#include "cg_run.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "matter_mesh.hpp"
#include "multigrid_mesh.hpp"
#include "prescribed_in_cell.hpp"
#include "residual_size.hpp"

#include <algorithm>
#include <deal.II/base/mpi.h>
#include <deal.II/distributed/tria.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>
#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>
#include <deal.II/lac/trilinos_vector.h>
#include <mpi.h>

namespace maille::fem_ref {
namespace {

using Vector = dealii::TrilinosWrappers::MPI::Vector;
using DofIndices = std::vector<dealii::types::global_dof_index>;

/// One rank's part of the problem.
template<int dim>
class Part {
public:
  Part(const Scene& scene, const Options& options, Watch& watch);
  Result solve();

private:
  void make_mesh();
  void number();
  void constrain();
  void assemble();
  void make_hierarchy();
  /// Calls visit(cell of the mesh, its number in the scene's grid) for the cells of this rank.
  template<class Visit>
  void for_each_own_cell(const Visit& visit) const;
  void loads(std::int64_t grid_cell, dealii::Vector<double>& load) const;
  double residual_forces(const Vector& u, Vector& forces) const;
  double forces_before_it_moves() const;
  void fill(const Vector& u, double size, Result& result) const;
  void gather(const Vector& u, const Vector& forces, Answer& answer) const;
  bool someone_wants_to_stop();
  std::int64_t grid_cell(const typename dealii::DoFHandler<dim>::active_cell_iterator& cell) const;
  /// From the order of FESystem to dim * node + component.
  std::size_t place(unsigned local) const {
    const auto [component, node] = fe_.system_to_component_index(local);
    return dim * node + component;
  }

  const Scene& scene_;
  const Options& options_;
  Watch& watch_;
  Element<dim> element_;
  PrescribedInCell<dim> prescribed_;
  dealii::parallel::distributed::Triangulation<dim> triangulation_;
  dealii::FESystem<dim> fe_;
  dealii::DoFHandler<dim> numbering_;
  dealii::IndexSet own_, relevant_;
  dealii::AffineConstraints<double> constraints_;
  std::vector<std::vector<FaceLoad>> faces_; ///< by cell of the grid; empty where nothing pulls
  dealii::TrilinosWrappers::SparseMatrix matrix_;
  Vector right_hand_side_;
  dealii::TrilinosWrappers::PreconditionAMG multigrid_;
};

template<int dim>
Part<dim>::Part(const Scene& scene, const Options& options, Watch& watch)
    : scene_(scene), options_(options), watch_(watch),
      element_(options.degree, scene.specimen.grid.spacing()), prescribed_(scene),
      triangulation_(MPI_COMM_WORLD), fe_(dealii::FE_Q<dim>(static_cast<unsigned>(options.degree)), dim),
      numbering_(triangulation_) {
  if (!scene.tractions.empty())
    faces_.resize(static_cast<std::size_t>(scene.specimen.grid.n_cells()));
  for (const FaceLoad& face : scene.tractions)
    faces_[static_cast<std::size_t>(face.cell)].push_back(face);
}

/// In units of cells, so that a cell's middle says which it is.
template<int dim>
void Part<dim>::make_mesh() {
  const Grid& grid = scene_.specimen.grid;
  if (scene_.specimen.n_matter_cells() == grid.n_cells()) {
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
      scene_.specimen,
      [](const Index3& node) {
        return Vec3{1.0 * node[0], 1.0 * node[1], 1.0 * node[2]};
      },
      triangulation_);
}

template<int dim>
std::int64_t Part<dim>::grid_cell(const typename dealii::DoFHandler<dim>::active_cell_iterator& cell) const {
  Index3 at{0, 0, 0};
  for (unsigned a = 0; a < dim; ++a)
    at[a] = static_cast<int>(cell->vertex(0)[a] + 0.5);
  return scene_.specimen.grid.cell(at);
}

template<int dim>
template<class Visit>
void Part<dim>::for_each_own_cell(const Visit& visit) const {
  for (const auto& cell : numbering_.active_cell_iterators())
    if (cell->is_locally_owned())
      visit(cell, grid_cell(cell));
}

template<int dim>
void Part<dim>::number() {
  numbering_.distribute_dofs(fe_);
  own_ = numbering_.locally_owned_dofs();
  dealii::DoFTools::extract_locally_relevant_dofs(numbering_, relevant_);
}

template<int dim>
void Part<dim>::constrain() {
  constraints_.reinit(relevant_);
  DofIndices unknowns(fe_.n_dofs_per_cell());
  for (const auto& cell : numbering_.active_cell_iterators()) {
    if (cell->is_artificial())
      continue;
    cell->get_dof_indices(unknowns);
    prescribed_.for_each(
        element_, scene_.specimen.grid.cell_at(grid_cell(cell)), [&](int node, unsigned c, double value) {
          const auto unknown = unknowns[fe_.component_to_system_index(c, static_cast<unsigned>(node))];
          if (!constraints_.is_constrained(unknown)) {
            constraints_.add_line(unknown);
            constraints_.set_inhomogeneity(unknown, value);
          }
        });
  }
  constraints_.close();
}

/// Of gravity, tractions and contracting fibres on a cell, in the order dim * node + component.
template<int dim>
void Part<dim>::loads(std::int64_t cell, dealii::Vector<double>& load) const {
  const double density = scene_.materials[scene_.specimen.material(cell)].density;
  for (unsigned i = 0; i < load.size(); ++i)
    load[i] = density * scene_.gravity[i % dim] * element_.volume_load()[i / dim];
  if (scene_.contracts()) {
    const Eigen::VectorXd pull = element_.stress_load() * scene_.cell_active_stress(cell);
    for (unsigned i = 0; i < load.size(); ++i)
      load[i] -= pull[i];
  }
  if (faces_.empty())
    return;
  for (const FaceLoad& face : faces_[static_cast<std::size_t>(cell)])
    for (unsigned i = 0; i < load.size(); ++i)
      load[i] += face.traction[i % dim] * element_.face_load(face.axis, face.upper)[i / dim];
}

template<int dim>
void Part<dim>::assemble() {
  dealii::DynamicSparsityPattern pattern(relevant_);
  dealii::DoFTools::make_sparsity_pattern(numbering_, pattern, constraints_, false);
  dealii::SparsityTools::distribute_sparsity_pattern(pattern, own_, MPI_COMM_WORLD, relevant_);
  matrix_.reinit(own_, own_, pattern, MPI_COMM_WORLD);
  right_hand_side_.reinit(own_, MPI_COMM_WORLD);
  CellMatrices<dim> matrices(scene_, element_, {});
  const unsigned n = fe_.n_dofs_per_cell();
  dealii::FullMatrix<double> K(n);
  dealii::Vector<double> load(n), f(n);
  DofIndices unknowns(n);
  for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    const dealii::FullMatrix<double>& known = matrices(of_grid, 0);
    loads(of_grid, load);
    for (unsigned i = 0; i < n; ++i) {
      f[i] = load[static_cast<unsigned>(place(i))];
      for (unsigned j = 0; j < n; ++j)
        K(i, j) = known(static_cast<unsigned>(place(i)), static_cast<unsigned>(place(j)));
    }
    constraints_.distribute_local_to_global(K, f, unknowns, matrix_, right_hand_side_);
  });
  matrix_.compress(dealii::VectorOperation::add);
  right_hand_side_.compress(dealii::VectorOperation::add);
}

template<int dim>
void Part<dim>::make_hierarchy() {
  std::vector<Vec3> positions(own_.n_elements() / dim);
  DofIndices unknowns(fe_.n_dofs_per_cell());
  for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    const Vec3 corner = scene_.specimen.position(scene_.specimen.grid.cell_at(of_grid));
    for (int node = 0; node < element_.n_nodes(); ++node) {
      const auto first = unknowns[fe_.component_to_system_index(0, static_cast<unsigned>(node))];
      if (!own_.is_element(first))
        continue;
      Vec3& x = positions[own_.index_within_set(first) / dim];
      for (std::size_t a = 0; a < 3; ++a)
        x[a] = corner[a] + element_.offset(node)[a];
    }
  });
  const Vec3 lower = scene_.specimen.origin;
  const Box around{
      lower, scene_.specimen.position(scene_.specimen.grid.node_at(scene_.specimen.grid.n_nodes() - 1))};
  std::vector<double> motions = rigid_motions(positions, dim, around);
  multigrid_.initialize(matrix_.trilinos_matrix(), amg_settings(dim, motions));
}

template<int dim>
bool Part<dim>::someone_wants_to_stop() {
  const int own = watch_.should_stop() ? 1 + static_cast<int>(watch_.status()) : 0;
  const int all = dealii::Utilities::MPI::max(own, MPI_COMM_WORLD);
  if (all > 0 && own == 0)
    watch_.stop(static_cast<Status>(all - 1));
  return all > 0;
}

/// K u - f, cell by cell; @return the energy u K u / 2
template<int dim>
double Part<dim>::residual_forces(const Vector& u, Vector& forces) const {
  CellMatrices<dim> matrices(scene_, element_, {});
  const unsigned n = fe_.n_dofs_per_cell();
  dealii::Vector<double> load(n), of_cell(n), force(n);
  DofIndices unknowns(n);
  double energy = 0;
  for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    for (unsigned i = 0; i < n; ++i)
      of_cell[static_cast<unsigned>(place(i))] = u(unknowns[i]);
    matrices(of_grid, 0).vmult(force, of_cell);
    energy += 0.5 * (of_cell * force);
    loads(of_grid, load);
    for (unsigned i = 0; i < n; ++i) {
      const auto at = static_cast<unsigned>(place(i));
      forces(unknowns[i]) += force[at] - load[at];
    }
  });
  forces.compress(dealii::VectorOperation::add);
  return dealii::Utilities::MPI::sum(energy, MPI_COMM_WORLD);
}

void sum_over_ranks(std::vector<double>& values) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                MPI_COMM_WORLD);
}

/// Displacement at every node and reactions, whole on every rank: each gives what it owns.
template<int dim>
void Part<dim>::gather(const Vector& u, const Vector& forces, Answer& answer) const {
  const Grid& grid = scene_.specimen.grid;
  answer.displacement = Displacement(grid);
  answer.reaction.assign(scene_.prescribed.size(), 0);
  std::vector<bool> is_done(own_.n_elements(), false);
  DofIndices unknowns(fe_.n_dofs_per_cell());
  for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    const Index3 at = grid.cell_at(of_grid);
    for (unsigned i = 0; i < unknowns.size(); ++i) {
      if (!own_.is_element(unknowns[i]) || is_done[own_.index_within_set(unknowns[i])])
        continue;
      is_done[own_.index_within_set(unknowns[i])] = true;
      const auto [component, node] = fe_.system_to_component_index(i);
      const std::vector<int>& parents = element_.parents(static_cast<int>(node));
      if (parents.size() == 1)
        answer.displacement(static_cast<int>(component), grid.corner(at, parents.front())) = u(unknowns[i]);
      if (std::ranges::all_of(parents, [&](int corner) {
            return prescribed_.entry(at, corner, component) != prescribed_.none;
          }))
        for (const int corner : parents)
          answer.reaction[static_cast<std::size_t>(prescribed_.entry(at, corner, component))] +=
              forces(unknowns[i]) / static_cast<double>(parents.size());
    }
  });
  for (auto& component : answer.displacement.component)
    sum_over_ranks(component);
  sum_over_ranks(answer.reaction);
}

/// The size of all forces, at prescribed nodes too, where nothing but those has moved.
template<int dim>
double Part<dim>::forces_before_it_moves() const {
  Vector u(own_, MPI_COMM_WORLD), with_neighbours(own_, relevant_, MPI_COMM_WORLD),
      forces(own_, MPI_COMM_WORLD);
  constraints_.distribute(u);
  with_neighbours = u;
  residual_forces(with_neighbours, forces);
  return forces.l2_norm();
}

/// @param size of residual_size
template<int dim>
void Part<dim>::fill(const Vector& u, double size, Result& result) const {
  Answer& answer = result.answer;
  Vector with_neighbours(own_, relevant_, MPI_COMM_WORLD), forces(own_, MPI_COMM_WORLD);
  with_neighbours = u;
  const double energy = residual_forces(with_neighbours, forces);
  gather(with_neighbours, forces, answer);
  for (const auto unknown : own_)
    if (constraints_.is_constrained(unknown))
      forces(unknown) = 0;
  forces.compress(dealii::VectorOperation::insert);
  answer.residual = size > 0 ? forces.l2_norm() / size : 0;
  if (!is_settled(answer.status)) {
    answer.reaction.clear();
    return;
  }
  answer.strain_energy = energy;
  if (!(answer.residual < std::max(1e-6, 2 * options_.tolerance))) { // who asked for less gets less
    answer.status = Status::failed;
    answer.message = fmt::format("the solution leaves a relative residual of {:.2g}", answer.residual);
  }
}

template<int dim>
Result Part<dim>::solve() {
  Result result;
  Answer& answer = result.answer;
  answer.method = options_.degree == 2 ? "fem_q2" : "fem_q1";
  make_mesh();
  number();
  constrain();
  watch_.report(0.1, "assembling");
  assemble();
  Solution solution;
  Vector u(own_, MPI_COMM_WORLD);
  result.degrees_of_freedom = static_cast<std::int64_t>(numbering_.n_dofs());
  answer.algorithm = fmt::format("Q{}, CG with smoothed-aggregation AMG on {} ranks, {} unknowns",
                                 options_.degree, ranks().size, result.degrees_of_freedom);
  if (!someone_wants_to_stop())
    make_hierarchy();
  answer.seconds.setup = watch_.seconds();
  run_cg(matrix_, u, right_hand_side_, multigrid_, options_.tolerance, watch_, solution,
         [this] { return someone_wants_to_stop(); });
  constraints_.distribute(u);
  answer.status = solution.status;
  answer.message = solution.message;
  answer.iterations = solution.iterations;
  if (has_displacement(answer.status))
    fill(u, residual_size(right_hand_side_.l2_norm(), forces_before_it_moves()), result);
  answer.seconds.solve = watch_.seconds() - answer.seconds.setup;
  const auto own_bytes =
      static_cast<double>(matrix_.memory_consumption() + numbering_.memory_consumption() +
                          triangulation_.memory_consumption() + multigrid_.memory_consumption());
  answer.bytes = static_cast<std::int64_t>(dealii::Utilities::MPI::sum(own_bytes, MPI_COMM_WORLD));
  watch_.report(1, "done");
  return result;
}

} // namespace

Result solve_distributed(const Scene& scene, const Options& options, Watch& watch) {
  watch.report(0, "meshing");
  if (scene.dimension() == 2)
    return Part<2>(scene, options, watch).solve();
  return Part<3>(scene, options, watch).solve();
}

} // namespace maille::fem_ref
