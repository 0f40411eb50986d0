#pragma once
/// How the nodes of a body give way to forces on others of its nodes.

#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <Eigen/Core>
#include <Eigen/SparseCholesky>

#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace maille::deform {

/// The elasticity of `coupled` (see LatticeElasticity) with some components of nodes held, factored once.
///
/// A component of a node has the number dimension * node + component, of the nodes of the body alone, in the
/// order of its grid.
///
/// Cost    a sparse Cholesky factor: in two dimensions 0.1 s for 10^4 nodes, in three 10 s; then 5 ms a
///         column
/// Memory  the factor: some 500 numbers a node in three dimensions
class Flexibility {
public:
  /// @param fixed numbers of components that are held @pre no rigid motion is left, or there is inertia
  /// @param inertia of every component, its mass over the square of a step of time [N/m]; empty: none
  /// @param floats nothing holds the body, `fixed` only takes its rigid motions away. Forces then act with
  ///        their resultants spread evenly over all nodes against them, and displacements have no mean shift
  ///        or turn, so that neither knows which components were chosen
  Flexibility(const Scene& scene, const std::vector<std::int64_t>& fixed,
              const Eigen::VectorXd& inertia = Eigen::VectorXd(), bool floats = false);

  std::int64_t n_components() const { return static_cast<std::int64_t>(free_.size()); }
  bool is_fixed(std::int64_t component) const { return free_[static_cast<std::size_t>(component)] < 0; }
  /// Displacement of everything for a force of 1 N on a component; zero for a fixed one. Kept.
  const Eigen::VectorXd& column(std::int64_t component);
  /// Displacement where fixed components have the values that they have in `prescribed`, without forces; of
  /// a body that floats its mean shift and turn.
  Eigen::VectorXd moved(const Eigen::VectorXd& prescribed) const;
  /// Displacement for forces on all components; those on fixed ones count for nothing.
  Eigen::VectorXd solve(const Eigen::VectorXd& forces) const;
  /// Elastic energy [J].
  double energy(const Eigen::VectorXd& displacement) const {
    return 0.5 * displacement.dot(stiffness_ * displacement);
  }
  /// What pulls at a component to keep the body so [N].
  double force_at(std::int64_t component, const Eigen::VectorXd& displacement) const {
    return stiffness_.col(component).dot(displacement); // it is symmetric
  }

private:
  using Sparse = Eigen::SparseMatrix<double>;

  std::vector<std::int64_t> free_; ///< among the free components; -1: fixed
  Sparse stiffness_;
  Eigen::SimplicialLLT<Sparse> factor_;
  std::int64_t n_free_ = 0;
  Eigen::MatrixXd rigid_; ///< of what floats: its rigid motions, of length 1 and across one another
  std::map<std::int64_t, Eigen::VectorXd> columns_;
};

} // namespace maille::deform
