#pragma once
/// Assembly and post-processing of a scene, before and after the linear solver, for one dimension.

#include "discretization/body.hpp"
#include "solvers/linear_system.hpp"
#include "ties.hpp"

#include "maille/fem_ref/solve.hpp"

#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <array>
#include <functional>
#include <vector>

namespace maille::fem_ref {

/// Prescribed values of all unknowns, from the scene or a manufactured solution.
struct Prescription {
  std::vector<bool> is_prescribed;
  dealii::Vector<double> values; ///< zero where free
};

template<int dim>
class Problem {
public:
  /// @param meshed  false: nodes are numbered along the grid, and assembly is not possible
  Problem(const Scene& scene, const Options& options, bool meshed);

  /// Replaces the scene by one with the same body, materials and prescribed components, and other values and
  /// loads.
  void ask(const Scene& scene) { scene_ = &scene; }
  Prescription prescription() const;
  /// Fills `system` except the values of the matrix. @pre the mesh exists
  void outline(LinearSystem& system, const std::vector<bool>& is_prescribed, const Ties& ties) const;
  /// Fills `system` with the stiffness matrix, prescribed unknowns eliminated. Call it once only: it frees
  /// the mesh.
  void assemble(LinearSystem& system, const std::vector<bool>& is_prescribed, const Ties& ties);
  /// Residual K u - f, cell by cell: the forces that hold every unknown in place, in addition to the loads.
  /// @return the energy u K u / 2. @param cell_energy  receives the energy of each grid cell; null: not
  /// computed
  double residual_forces(const dealii::Vector<double>& u, dealii::Vector<double>& forces,
                         std::vector<double>* cell_energy = nullptr) const;
  Displacement at_grid_nodes(const dealii::Vector<double>& u) const;
  /// Reactions at the prescribed components, in the scene's order. @param forces from residual_forces()
  std::vector<double> reactions(const dealii::Vector<double>& forces) const;
  /// Answer::cell_strain: mean strain of the elements over each cell; empty if moves rotate the body. @pre no
  /// Options::shape
  std::vector<std::array<double, 6>> mean_strains(const dealii::Vector<double>& u) const;
  /// Fills Answer::nodal_strain and Answer::nodal_stress.
  void recover(const dealii::Vector<double>& u, Answer& answer) const;
  /// L2 norm over the body of u - exact.
  double l2_error(const dealii::Vector<double>& u) const;
  const Body<dim>& body() const { return body_; }
  /// Unknowns of a cell, in the order of Element.
  void unknowns(int cell, std::vector<dealii::types::global_dof_index>& unknowns) const;
  /// Calls visit(mesh node, stiffness [N/m]) for the springs of every face at its nodes. Stiffness is split
  /// by the integrals of the shape functions, so mid-points get the larger part.
  void
  for_each_spring(const std::function<void(unsigned, const Eigen::Matrix<double, dim, dim>&)>& visit) const;
  /// Adds springs to the ground, and springs of ties with friction.
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
  /// Calls visit(first mesh node, second, tie) for ties with friction.
  void for_each_rubbing(const std::function<void(unsigned, unsigned, const NodeTie&)>& visit) const;
  /// Adds nodal forces of a cell's contracting fibres.
  void add_active_stress(int cell, dealii::Vector<double>& load) const;
  void add_body_force(int cell, const Samples& samples, dealii::Vector<double>& load) const;

  const Scene* scene_;
  const Options* options_;
  Body<dim> body_;
  std::vector<std::array<unsigned, 2>> rubbing_; ///< mesh nodes, by tie; empty: no friction
};

} // namespace maille::fem_ref
