#include "discretization/cell_matrices.hpp"
#include "discretization/prescribed_in_cell.hpp"
#include "distributed_mesh.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "solvers/amg_settings.hpp"
#include "solvers/cg_run.hpp"
#include "solvers/linear_system.hpp"

#include <deal.II/base/mpi.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/lac/affine_constraints.h>
#include <deal.II/lac/dynamic_sparsity_pattern.h>
#include <deal.II/lac/sparsity_tools.h>
#include <deal.II/lac/trilinos_precondition.h>
#include <deal.II/lac/trilinos_sparse_matrix.h>
#include <deal.II/lac/trilinos_vector.h>
#include <mpi.h>

#include <algorithm>

namespace maille::fem_ref {
namespace {

using Vector = dealii::TrilinosWrappers::MPI::Vector;
using DofIndices = std::vector<dealii::types::global_dof_index>;

/// Part of the problem on one rank.
template<int dim>
class Part {
public:
  Part(const Scene& scene, const Options& options, Watch& watch);
  Result solve();

private:
  void constrain();
  void assemble();
  void make_hierarchy();
  void loads(std::int64_t grid_cell, dealii::Vector<double>& load) const;
  double residual_forces(const Vector& u, Vector& forces) const;
  double forces_before_it_moves() const;
  void fill(const Vector& u, double size, Result& result) const;
  void gather(const Vector& u, const Vector& forces, Answer& answer) const;
  bool someone_wants_to_stop();

  const Scene& scene_;
  const Options& options_;
  Watch& watch_;
  Element<dim> element_;
  PrescribedInCell<dim> prescribed_;
  DistributedMesh<dim> mesh_;
  dealii::AffineConstraints<double> constraints_;
  std::vector<std::vector<FaceLoad>> faces_; ///< by grid cell; empty without loads
  dealii::TrilinosWrappers::SparseMatrix matrix_;
  Vector right_hand_side_;
  dealii::TrilinosWrappers::PreconditionAMG multigrid_;
};

template<int dim>
Part<dim>::Part(const Scene& scene, const Options& options, Watch& watch)
    : scene_(scene), options_(options), watch_(watch),
      element_(options.degree, scene.specimen.grid.spacing()), prescribed_(scene),
      mesh_(scene.specimen, options.degree) {
  if (!scene.tractions.empty())
    faces_.resize(scene.specimen.grid.n_cells());
  for (const FaceLoad& face : scene.tractions)
    faces_[face.cell].push_back(face);
}

template<int dim>
void Part<dim>::constrain() {
  constraints_.reinit(mesh_.relevant());
  DofIndices unknowns(mesh_.element().n_dofs_per_cell());
  for (const auto& cell : mesh_.numbering().active_cell_iterators()) {
    if (cell->is_artificial())
      continue;
    cell->get_dof_indices(unknowns);
    prescribed_.for_each(
        element_, scene_.specimen.grid.cell_at(mesh_.grid_cell(cell)),
        [&](int node, unsigned c, double value) {
          const auto unknown =
              unknowns[mesh_.element().component_to_system_index(c, static_cast<unsigned>(node))];
          if (!constraints_.is_constrained(unknown)) {
            constraints_.add_line(unknown);
            constraints_.set_inhomogeneity(unknown, value);
          }
        });
  }
  constraints_.close();
}

/// Loads of gravity, tractions and contracting fibres on a cell, in the order dim * node + component.
template<int dim>
void Part<dim>::loads(std::int64_t cell, dealii::Vector<double>& load) const {
  const double tissue = scene_.specimen.tissue_of(cell),
               density = tissue * scene_.materials[scene_.specimen.material(cell)].density;
  for (unsigned i = 0; i < load.size(); ++i)
    load[i] = density * scene_.gravity[i % dim] * element_.volume_load()[i / dim];
  if (scene_.contracts()) {
    const Eigen::VectorXd pull = tissue * element_.stress_load() * scene_.cell_active_stress(cell);
    for (unsigned i = 0; i < load.size(); ++i)
      load[i] -= pull[i];
  }
  if (faces_.empty())
    return;
  for (const FaceLoad& face : faces_[cell])
    for (unsigned i = 0; i < load.size(); ++i)
      load[i] += face.traction[i % dim] * element_.face_load(face.axis, face.upper)[i / dim];
}

template<int dim>
void Part<dim>::assemble() {
  dealii::DynamicSparsityPattern pattern(mesh_.relevant());
  dealii::DoFTools::make_sparsity_pattern(mesh_.numbering(), pattern, constraints_, false);
  dealii::SparsityTools::distribute_sparsity_pattern(pattern, mesh_.own(), MPI_COMM_WORLD, mesh_.relevant());
  matrix_.reinit(mesh_.own(), mesh_.own(), pattern, MPI_COMM_WORLD);
  right_hand_side_.reinit(mesh_.own(), MPI_COMM_WORLD);
  CellMatrices<dim> matrices(scene_, element_, {});
  const unsigned n = mesh_.element().n_dofs_per_cell();
  dealii::FullMatrix<double> K(n);
  dealii::Vector<double> load(n), f(n);
  DofIndices unknowns(n);
  mesh_.for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    const dealii::FullMatrix<double>& known = matrices(of_grid, 0);
    loads(of_grid, load);
    for (unsigned i = 0; i < n; ++i) {
      f[i] = load[static_cast<unsigned>(mesh_.place(i))];
      for (unsigned j = 0; j < n; ++j)
        K(i, j) = known(static_cast<unsigned>(mesh_.place(i)), static_cast<unsigned>(mesh_.place(j)));
    }
    constraints_.distribute_local_to_global(K, f, unknowns, matrix_, right_hand_side_);
  });
  matrix_.compress(dealii::VectorOperation::add);
  right_hand_side_.compress(dealii::VectorOperation::add);
}

template<int dim>
void Part<dim>::make_hierarchy() {
  const Vec3 lower = scene_.specimen.origin;
  const Box around{
      lower, scene_.specimen.position(scene_.specimen.grid.node_at(scene_.specimen.grid.n_nodes() - 1))};
  std::vector<double> motions = rigid_motions(mesh_.own_positions(element_), dim, around);
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
  const unsigned n = mesh_.element().n_dofs_per_cell();
  dealii::Vector<double> load(n), of_cell(n), force(n);
  DofIndices unknowns(n);
  double energy = 0;
  mesh_.for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    for (unsigned i = 0; i < n; ++i)
      of_cell[static_cast<unsigned>(mesh_.place(i))] = u(unknowns[i]);
    take_out_shift<dim>(of_cell);
    matrices(of_grid, 0).vmult(force, of_cell);
    energy += 0.5 * (of_cell * force);
    loads(of_grid, load);
    for (unsigned i = 0; i < n; ++i) {
      const auto at = static_cast<unsigned>(mesh_.place(i));
      forces(unknowns[i]) += force[at] - load[at];
    }
  });
  forces.compress(dealii::VectorOperation::add);
  return dealii::Utilities::MPI::sum(energy, MPI_COMM_WORLD);
}

void sum_over_ranks(std::span<double> values) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE, MPI_SUM,
                MPI_COMM_WORLD);
}

/// Collects displacements of all nodes and reactions on every rank: each rank contributes its own.
template<int dim>
void Part<dim>::gather(const Vector& u, const Vector& forces, Answer& answer) const {
  const Grid& grid = scene_.specimen.grid;
  answer.displacement = Displacement(grid);
  answer.reaction.assign(scene_.prescribed.size(), 0);
  std::vector<bool> is_done(mesh_.own().n_elements(), false);
  DofIndices unknowns(mesh_.element().n_dofs_per_cell());
  mesh_.for_each_own_cell([&](const auto& cell, std::int64_t of_grid) {
    cell->get_dof_indices(unknowns);
    const Index3 at = grid.cell_at(of_grid);
    for (unsigned i = 0; i < unknowns.size(); ++i) {
      if (!mesh_.own().is_element(unknowns[i]) || is_done[mesh_.own().index_within_set(unknowns[i])])
        continue;
      is_done[mesh_.own().index_within_set(unknowns[i])] = true;
      const auto [component, node] = mesh_.element().system_to_component_index(i);
      const std::vector<int>& parents = element_.parents(static_cast<int>(node));
      if (parents.size() == 1)
        answer.displacement(static_cast<int>(component), grid.corner(at, parents.front())) = u(unknowns[i]);
      if (std::ranges::all_of(parents, [&](int corner) {
            return prescribed_.entry(at, corner, component) != prescribed_.none;
          }))
        for (const int corner : parents)
          answer.reaction[prescribed_.entry(at, corner, component)] +=
              forces(unknowns[i]) / static_cast<double>(parents.size());
    }
  });
  sum_over_ranks(answer.displacement.values());
  sum_over_ranks(answer.reaction);
}

/// Norm of all forces, at prescribed nodes too, if only prescribed nodes have moved.
template<int dim>
double Part<dim>::forces_before_it_moves() const {
  Vector u(mesh_.own(), MPI_COMM_WORLD), with_neighbours(mesh_.own(), mesh_.relevant(), MPI_COMM_WORLD),
      forces(mesh_.own(), MPI_COMM_WORLD);
  constraints_.distribute(u);
  with_neighbours = u;
  residual_forces(with_neighbours, forces);
  return forces.l2_norm();
}

/// @param size from residual_size()
template<int dim>
void Part<dim>::fill(const Vector& u, double size, Result& result) const {
  Answer& answer = result.answer;
  Vector with_neighbours(mesh_.own(), mesh_.relevant(), MPI_COMM_WORLD), forces(mesh_.own(), MPI_COMM_WORLD);
  with_neighbours = u;
  const double energy = residual_forces(with_neighbours, forces);
  gather(with_neighbours, forces, answer);
  for (const auto unknown : mesh_.own())
    if (constraints_.is_constrained(unknown))
      forces(unknown) = 0;
  forces.compress(dealii::VectorOperation::insert);
  answer.residual = size > 0 ? forces.l2_norm() / size : 0;
  if (!is_converged(answer.status)) {
    answer.reaction.clear();
    return;
  }
  answer.strain_energy = energy;
  if (!(answer.residual < std::max(1e-6, 2 * options_.tolerance))) { // a looser tolerance was requested
    answer.status = Status::failed;
    answer.message = fmt::format("the solution leaves a relative residual of {:.2g}", answer.residual);
  }
}

template<int dim>
Result Part<dim>::solve() {
  Result result;
  Answer& answer = result.answer;
  answer.method = options_.degree == 2 ? "fem_q2" : "fem_q1";
  constrain();
  watch_.report(0.1, "assembling");
  assemble();
  Solution solution;
  Vector u(mesh_.own(), MPI_COMM_WORLD);
  result.degrees_of_freedom = static_cast<std::int64_t>(mesh_.numbering().n_dofs());
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
      static_cast<double>(matrix_.memory_consumption() + mesh_.bytes() + multigrid_.memory_consumption());
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
