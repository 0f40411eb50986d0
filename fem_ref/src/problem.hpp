#pragma once
/// One scene in one dimension: assembly before the linear solver, answers after it.

#include "body.hpp"
#include "linear_system.hpp"

#include "maille/fem_ref/solve.hpp"

#include <deal.II/lac/dynamic_sparsity_pattern.h>

namespace maille::fem_ref {

template<int dim>
class Problem {
public:
  /// Meshes the body; `assemble` comes next.
  Problem(const Scene& scene, const Options& options);

  /// Fills `system` with the stiffness matrix and the loads, prescribed unknowns taken out. Once only: the
  /// mesh is given up on the way.
  void assemble(LinearSystem& system);
  Displacement at_grid_nodes(const dealii::Vector<double>& u) const;
  /// Fills Answer::reaction and Answer::strain_energy.
  void react(const dealii::Vector<double>& u, Answer& answer) const;
  /// L2 norm over the body of u - exact.
  double l2_error(const dealii::Vector<double>& u) const;
  std::int64_t bytes() const { return body_.bytes(); }

private:
  void constrain(dealii::AffineConstraints<double>& constraints) const;
  void constrain_by_scene(dealii::AffineConstraints<double>& constraints) const;
  void constrain_whole_boundary(dealii::AffineConstraints<double>& constraints) const;
  void make_pattern(LinearSystem& system) const;
  void add_cells(LinearSystem& system) const;
  void add_tractions(LinearSystem& system) const;
  double residual_forces(const dealii::Vector<double>& u, dealii::Vector<double>& forces) const;
  void add_body_force(int cell, const Samples& samples, dealii::Vector<double>& load) const;
  std::vector<dealii::types::global_dof_index> unknowns(int cell) const;

  const Scene* scene_;
  const Options* options_;
  Body<dim> body_;
};

} // namespace maille::fem_ref
