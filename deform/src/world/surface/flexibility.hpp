#pragma once
/// Compliance of a body: displacements of its nodes for unit forces on others.
///
/// With K the stiffness and some components fixed, column c is K^-1 e_c. A contact needs only the rows and
/// columns of the touched components, so columns are computed on demand and cached; the Delassus matrix W of
/// all contacts is assembled from them. Columns come from a sparse factor or, in 3D, from multigrid
/// (StiffnessSolver).
///
/// A floating body has a singular K: `fixed` removes just its rigid motions, forces act with their resultants
/// spread evenly against them, and displacements lose their mean shift and rotation. The result is that of
/// the pseudo-inverse, whichever components were fixed. With `inertia` M / dt^2 is added to K, and nothing
/// need be fixed.
///
/// Exact: within the solver's accuracy. Heuristic: only which solver is quickest.

#include "elastic/model/fixed_mask.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <Eigen/Core>

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

namespace maille::deform {

/// The stiffness of a body, on components of its nodes, some of which are held.
class BodyStiffness {
public:
  virtual ~BodyStiffness() = default;
  /// Displacement for forces; those on held components count for nothing.
  /// @param accuracy  of the residual over them, where it is found by iterations
  virtual Eigen::VectorXd solve(const Eigen::VectorXd& forces, double accuracy) = 0;
  /// The same for several, as columns.
  virtual Eigen::MatrixXd solve_all(const Eigen::MatrixXd& forces, double accuracy);
  /// Does now what the first columns would wait for.
  virtual void prepare() {}
  /// Elastic forces of all components.
  virtual Eigen::VectorXd forces(const Eigen::VectorXd& displacement) const = 0;
  /// The same for one component.
  virtual double force_at(std::int64_t component, const Eigen::VectorXd& displacement) const = 0;
};

/// Which way a body's stiffness is inverted.
enum class StiffnessSolver {
  /// The factor in two dimensions and for a thousand nodes, else multigrid; for columns the supernodal factor
  /// where it has 4e7 numbers at most and CHOLMOD is there.
  quickest,
  factor,    ///< a sparse Cholesky factor by Eigen: in two dimensions 0.1 s for 10^4 nodes, in three 10 s
  multigrid, ///< of `coupled`, in three dimensions: 15 ms a column of 10^4 nodes
  /// A Cholesky factor by CHOLMOD, in three dimensions: for 10^4 nodes that are long and thin 0.5 s, then
  /// 3 ms a column where many are asked for together. @throws std::runtime_error where it cannot be made
  supernodal,
};

/// How nodes of a body give way to forces on others: the elasticity of `coupled` (see LatticeElasticity) with
/// some components of nodes held.
///
/// A component of a node has the number dimension * node + component, of the nodes of the body alone, in the
/// order of its grid.
///
/// Memory      a displacement for each column that is kept
/// Repeatable  same bits for any number of threads
class Flexibility {
public:
  /// @param scene must outlive this
  /// @param fixed numbers of components that are held @pre no rigid motion is left, or there is inertia
  /// @param inertia of every component, its mass over the square of a step of time [N/m]; empty: none
  /// @param solver multigrid: three dimensions
  /// @param floats nothing holds the body, `fixed` only takes its rigid motions away. Forces then act with
  ///        their resultants spread evenly over all nodes against them, and displacements have no mean shift
  ///        or turn, so neither depends on which components were fixed
  Flexibility(const Scene& scene, const std::vector<std::int64_t>& fixed,
              const Eigen::VectorXd& inertia = Eigen::VectorXd(), bool floats = false, int threads = 1,
              StiffnessSolver solver = StiffnessSolver::quickest);

  Flexibility(const Flexibility&) = delete; // its stiffness refers to what is held
  Flexibility& operator=(const Flexibility&) = delete;

  std::int64_t n_components() const { return dimension_ * static_cast<std::int64_t>(fixed_.n_nodes()); }
  bool is_fixed(std::int64_t component) const {
    return fixed_(component % dimension_, component / dimension_);
  }
  /// Displacement of everything for a force of 1 N on a component; zero for a fixed one. Kept.
  const Eigen::VectorXd& column(std::int64_t component);
  void prepare() { stiffness_->prepare(); }
  /// Those that are not there yet, all at once.
  void find_columns(std::span<const std::int64_t> components);
  /// Symmetric part of the columns' rows at the same components. Kept for the next call.
  const Eigen::MatrixXd& compliance(const std::vector<std::int64_t>& components);
  /// Displacement of everything for forces on components: the sum of their columns. Kept while the forces
  /// change by so little that nothing moves.
  /// @param components where there are forces
  const Eigen::VectorXd& moved_by(const Eigen::VectorXd& forces, std::span<const std::int64_t> components);
  /// Displacement where fixed components have the values that they have in `prescribed`, without forces; of
  /// a body that floats its mean shift and turn.
  Eigen::VectorXd moved(const Eigen::VectorXd& prescribed) const;
  /// Displacement for forces on all components; those on fixed ones count for nothing.
  Eigen::VectorXd solve(const Eigen::VectorXd& forces) const;
  /// Gives back columns that were not asked for between two calls, where all take more than 1 GiB.
  void forget_unused();
  /// Elastic energy [J].
  double energy(const Eigen::VectorXd& displacement) const {
    return 0.5 * displacement.dot(stiffness_->forces(displacement));
  }
  /// Force on a component that keeps the body in this state [N].
  double force_at(std::int64_t component, const Eigen::VectorXd& displacement) const {
    return stiffness_->force_at(component, displacement);
  }

private:
  Eigen::VectorXd force_for_column(std::int64_t component) const;
  /// For a floating body: removes the resultants from forces, or the mean shift and rotation from
  /// displacements.
  template<class Values>
  void take_rigid_motions_from(Values& values) const;

  FixedMask fixed_; ///< by node of the body
  std::unique_ptr<BodyStiffness> stiffness_;
  Eigen::MatrixXd rigid_; ///< of what floats: its rigid motions, of length 1 and across one another
  double column_accuracy_;
  struct Column {
    Eigen::VectorXd values;
    bool is_used = false;
  };
  std::map<std::int64_t, Column> columns_;
  std::vector<std::int64_t> kept_components_; ///< with their compliance
  Eigen::MatrixXd kept_compliance_;
  std::vector<std::int64_t> forced_; ///< of the forces that moved_by() was asked for last
  Eigen::VectorXd forces_, moved_;   ///< those, and its answer
  int dimension_;
};

} // namespace maille::deform
