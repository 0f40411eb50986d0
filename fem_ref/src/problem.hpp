#pragma once
/// One scene in one dimension: assembly before the linear solver, answers after it.

#include "discretization/body.hpp"
#include "solvers/linear_system.hpp"
#include "ties.hpp"

#include "maille/fem_ref/solve.hpp"

#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <array>
#include <functional>
#include <vector>

namespace maille::fem_ref {

/// What the scene, or a manufactured solution, says about every unknown.
struct Prescription {
  std::vector<bool> is_prescribed;
  dealii::Vector<double> values; ///< zero where free
};

template<int dim>
class Problem {
public:
  /// @param meshed  false: nodes are numbered along the grid, and there is nothing to assemble from
  Problem(const Scene& scene, const Options& options, bool meshed);

  /// The scene to be asked from now on: same body, materials and prescribed components, other values and
  /// loads.
  void ask(const Scene& scene) { scene_ = &scene; }
  Prescription prescription() const;
  /// Fills in everything of `system` but the matrix's numbers. @pre the mesh is there
  void outline(LinearSystem& system, const std::vector<bool>& is_prescribed, const Ties& ties) const;
  /// Fills `system` with the stiffness matrix, prescribed unknowns taken out. Once only: the mesh is given up
  /// on the way.
  void assemble(LinearSystem& system, const std::vector<bool>& is_prescribed, const Ties& ties);
  /// K u - f, cell by cell: what keeps every unknown where it is, beside the loads. @return the energy u K
  /// u / 2. @param cell_energy  its parts, a cell of the grid each; null: not kept
  double residual_forces(const dealii::Vector<double>& u, dealii::Vector<double>& forces,
                         std::vector<double>* cell_energy = nullptr) const;
  Displacement at_grid_nodes(const dealii::Vector<double>& u) const;
  /// Reactions at the scene's prescribed components, in its order. @param forces of residual_forces
  std::vector<double> reactions(const dealii::Vector<double>& forces) const;
  /// Answer::cell_strain: means over cells of the elements' own strain; empty where moves turn the body.
  /// @pre no Options::shape
  std::vector<std::array<double, 6>> mean_strains(const dealii::Vector<double>& u) const;
  /// Fills Answer::nodal_strain and Answer::nodal_stress.
  void recover(const dealii::Vector<double>& u, Answer& answer) const;
  /// L2 norm over the body of u - exact.
  double l2_error(const dealii::Vector<double>& u) const;
  const Body<dim>& body() const { return body_; }
  /// Unknowns of a cell, in the order of Element.
  void unknowns(int cell, std::vector<dealii::types::global_dof_index>& unknowns) const;
  /// Calls visit(node of the mesh, stiffness [N/m]) for the springs of every face at its nodes: by the
  /// integrals of their shape functions, so that those at mid points have the larger part.
  void
  for_each_spring(const std::function<void(unsigned, const Eigen::Matrix<double, dim, dim>&)>& visit) const;
  /// Adds springs to the ground, and those of ties that rub.
  void add_springs(LinearSystem& system) const;

private:
  void prescribe_by_scene(Prescription& prescription) const;
  void prescribe_whole_boundary(Prescription& prescription) const;
  void make_pattern(LinearSystem& system, const Ties& ties) const;
  void add_cells(LinearSystem& system) const;
  double corner_strains(int cell, const dealii::Vector<double>& u, Eigen::MatrixXd& strains) const;
  Eigen::MatrixXd positions(int cell) const;
  std::function<Eigen::MatrixXd(int)> mapped_positions() const;
  Eigen::VectorXd face_load(const FaceLoad& face) const;
  /// Calls visit(first node of the mesh, second, tie) for ties that rub.
  void for_each_rubbing(const std::function<void(unsigned, unsigned, const NodeTie&)>& visit) const;
  /// What a cell's contracting fibres pull its nodes with.
  void add_active_stress(int cell, dealii::Vector<double>& load) const;
  void add_body_force(int cell, const Samples& samples, dealii::Vector<double>& load) const;

  const Scene* scene_;
  const Options* options_;
  Body<dim> body_;
  std::vector<std::array<unsigned, 2>> rubbing_; ///< nodes of the mesh, by tie; empty: none rubs
};

} // namespace maille::fem_ref
