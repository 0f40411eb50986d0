#pragma once
/// Compliance of a body: displacements of its nodes for unit forces on nodes.
///
/// With K the stiffness and some components fixed, column c is K^-1 e_c. A contact needs only the rows and
/// columns of its components. Columns are therefore computed on demand and cached, and the Delassus matrix W
/// of all contacts is assembled from them. A sparse factor or, in 3D, multigrid solves for the columns
/// (StiffnessSolver).
///
/// A floating body has a singular K: `fixed` removes only its rigid motions, each force is balanced by its
/// resultant spread evenly over all nodes, and displacements have no mean shift and rotation. The result is
/// that of the pseudo-inverse, for any choice of fixed components. `inertia` adds M / dt^2 to K; then no
/// component needs to be fixed.
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

/// Stiffness of a body on the components of its nodes, some of them fixed.
class BodyStiffness {
public:
  virtual ~BodyStiffness() = default;
  /// Displacement for forces; forces on fixed components are ignored.
  /// @param accuracy  relative residual of iterative solvers
  virtual Eigen::VectorXd solve(const Eigen::VectorXd& forces, double accuracy) = 0;
  /// The same for several, as columns.
  virtual Eigen::MatrixXd solve_all(const Eigen::MatrixXd& forces, double accuracy);
  /// Makes the set-up that the first columns would otherwise wait for.
  virtual void prepare() {}
  /// Elastic forces of all components.
  virtual Eigen::VectorXd forces(const Eigen::VectorXd& displacement) const = 0;
  /// The same for one component.
  virtual double force_at(std::int64_t component, const Eigen::VectorXd& displacement) const = 0;
};

/// Solver of the stiffness.
enum class StiffnessSolver {
  /// A factor in two dimensions and up to a thousand nodes, else multigrid. For sets of columns, the
  /// supernodal factor if it has at most 4e7 numbers and CHOLMOD is available.
  quickest,
  factor,    ///< a sparse Cholesky factor by Eigen: in two dimensions 0.1 s for 10^4 nodes, in three 10 s
  multigrid, ///< of `coupled`, in three dimensions: 15 ms a column of 10^4 nodes
  /// A Cholesky factor by CHOLMOD, in three dimensions: for 10^4 nodes of a slender body 0.5 s, then 3 ms a
  /// column in sets of many. @throws std::runtime_error if it cannot be made
  supernodal,
};

/// Compliance of a body: the elasticity of `coupled` (see LatticeElasticity) with some components fixed.
///
/// Component `axis` of a node has the number dimension * node + axis; nodes are those of the body only, in
/// the order of its grid.
///
/// Memory      a displacement for each cached column
/// Repeatable  same bits for any number of threads
class Flexibility {
public:
  /// @param scene must outlive this
  /// @param fixed numbers of fixed components @pre they remove all rigid motions, or there is inertia
  /// @param inertia mass of every component over the square of a time step [N/m]; empty: none
  /// @param solver multigrid: only in three dimensions
  /// @param floats the body has no holds, `fixed` only removes its rigid motions. Each force is then balanced
  ///        by its resultant spread evenly over all nodes, and displacements have no mean shift or rotation:
  ///        neither depends on the choice of fixed components
  Flexibility(const Scene& scene, const std::vector<std::int64_t>& fixed,
              const Eigen::VectorXd& inertia = Eigen::VectorXd(), bool floats = false, int threads = 1,
              StiffnessSolver solver = StiffnessSolver::quickest);

  Flexibility(const Flexibility&) = delete; // its stiffness refers to fixed_
  Flexibility& operator=(const Flexibility&) = delete;

  std::int64_t n_components() const { return dimension_ * static_cast<std::int64_t>(fixed_.n_nodes()); }
  bool is_fixed(std::int64_t component) const {
    return fixed_(component % dimension_, component / dimension_);
  }
  /// Displacement of all nodes for a force of 1 N on a component; zero for a fixed one. Cached.
  const Eigen::VectorXd& column(std::int64_t component);
  void prepare() { stiffness_->prepare(); }
  /// Computes and caches the missing columns, several at a time.
  void find_columns(std::span<const std::int64_t> components);
  /// Symmetric part of the columns' rows at the same components. Entries are cached between calls.
  /// @param components sorted
  const Eigen::MatrixXd& compliance(const std::vector<std::int64_t>& components);
  /// Restricts watched_column() to these nodes of the body. @param nodes sorted
  void watch(const std::vector<std::int32_t>& nodes);
  bool watches_all() const { return dimension_ * std::ssize(watched_) == n_components(); }
  /// column() at the watched nodes.
  const Eigen::VectorXd& watched_column(std::int64_t component);
  /// Displacement of all nodes for forces on components: the sum of their columns.
  /// @param components components with forces
  Eigen::VectorXd moved_by(const Eigen::VectorXd& forces, std::span<const std::int64_t> components);
  /// Displacement without forces, with the fixed components of `prescribed`; for a floating body, the mean
  /// shift and rotation of `prescribed`.
  Eigen::VectorXd moved(const Eigen::VectorXd& prescribed) const;
  /// Displacement for forces on all components; forces on fixed components are ignored.
  Eigen::VectorXd solve(const Eigen::VectorXd& forces) const;
  /// Frees columns that were not used since the last call, if all columns take more than 1 GiB.
  void forget_unused();
  /// Elastic energy [J].
  double energy(const Eigen::VectorXd& displacement) const {
    return 0.5 * displacement.dot(stiffness_->forces(displacement));
  }
  /// External force on a component that holds the body in this state [N].
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
  Eigen::MatrixXd rigid_; ///< orthonormal rigid motions of a floating body; else empty
  double column_accuracy_;
  struct Column {
    Eigen::VectorXd values, watched; ///< `watched` is empty until its first use
    bool is_used = false;
  };
  std::map<std::int64_t, Column> columns_;
  std::vector<std::int64_t> kept_components_; ///< sorted, with their compliance
  Eigen::MatrixXd kept_compliance_;
  std::vector<std::int32_t> watched_;
  int dimension_;
};

} // namespace maille::deform
