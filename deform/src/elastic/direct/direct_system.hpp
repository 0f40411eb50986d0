#pragma once
/// Elasticity by a sparse Cholesky factor, for bodies so slender that float32 multigrid sees them as
/// unconstrained: columns and chains of single cells, whose factors have almost no fill.
///
/// K = L L^T on the free components, in float64, ordered by approximate minimum degree. The factor serves as
/// preconditioner of FlexibleGradients, which removes its rounding errors: near the end of float64's range (a
/// rod a thousand times as long as thick) one solve is not accurate enough.
///
/// The constructor analyses (see SparseCholesky); iterations_worth_it() and bytes() say whether a factor
/// pays; factor() computes it. Penalties of limits are added to K and factored anew.
///
/// Heuristic: which bodies are slender enough (is_very_slender, bytes_for_factor), and the cost model.

#include "elastic/componentwise/componentwise_preconditioner.hpp"
#include "elastic/model/stiffness_blocks.hpp"

#include "maille/base/arena.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace maille {
class SparseCholesky;
}

namespace maille::deform {

/// In float64, on a body of any shape in three dimensions.
///
/// Same bits for any number of threads: the factor is made by one.
///
/// Checked by  tests/deform/elastic/slender/slender_boxes_test.cpp
class DirectSystem : public BodySystem {
public:
  /// Orders the unknowns and finds the size of the factor. @param task must outlive this
  explicit DirectSystem(const CoupledTask& task);
  ~DirectSystem() override;

  std::int64_t n_components() const { return lower_.rows(); } ///< that are not fixed
  /// Iterations of multigrid that cost as much as the factor.
  std::int64_t iterations_worth_it() const;
  /// Bytes of the matrix, the factor, and the fields of conjugate gradients around them.
  std::int64_t bytes() const;
  /// @return false where the matrix is not positive definite, within rounding
  bool factor();

  /// correction = K^-1 residual, within rounding. @pre factor() returned true
  void precondition(const Displacement& residual, Displacement& correction) override;
  void set_penalties(const List<PenaltyLink>& links) override;

private:
  /// Where a component of a node has its place among the unknowns.
  struct Unknown {
    int component = 0;
    std::int64_t node = 0;
  };

  std::vector<std::int64_t> nodes_;
  FixedMask fixed_; ///< by place in nodes_
  std::vector<Unknown> unknowns_;
  Eigen::SparseMatrix<double> lower_;
  std::unique_ptr<SparseCholesky> factor_;
  Charge of_matrix_, of_factor_;
};

/// True for columns, ribbons and sheets a hundred times as long as thick: their bending energy may be below
/// float32 rounding. Thickness is that of a column with the same number of nodes per cell. False for grids of
/// more than 2 million nodes.
bool is_very_slender(const Specimen& body);
/// Memory allowed for a factor; 0 for bodies that get none: large ones, and all but chains and columns
/// [bytes].
std::int64_t bytes_for_factor(const Specimen& body);

/// Null if the body gets no factor.
std::unique_ptr<DirectSystem> make_direct_system(const CoupledTask& task);

/// Solves by the factor: for very slender bodies, and where multigrid stagnates. @param system of the task,
/// or null @return as CoupledAlgorithm; nothing without a factor
std::optional<bool> solve_coupled_by_factor(const CoupledTask& task, std::unique_ptr<DirectSystem> system,
                                            Answer& answer);

} // namespace maille::deform
