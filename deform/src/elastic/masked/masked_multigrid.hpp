#pragma once
/// Multigrid for elasticity on a body of any shape, as the preconditioner of conjugate gradients.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/masked/masked_level.hpp"

#include <algorithm>
#include <memory>
#include <span>
#include <vector>

namespace maille::deform {

/// A symmetric V-cycle: Chebyshev's Jacobi steps on every level, coarser grids on which parts of the body
/// that are not joined through faces stay apart (see coarsen: muscles touch at edges, and a coarse grid that
/// joins such hinges cannot correct how they turn), the exact operator between their functions
/// (Galerkin), a direct solve at the bottom.
///
/// Cost    a coarse vertex has some 27 blocks of 36 bytes, an eighth to a fifth as many vertices as nodes:
///         the finest level, whose operator is not assembled, has most of the work
/// Figures docs/developers/relaxation.md. Same bits for any number of threads.
class MaskedMultigrid {
public:
  /// @param steps of relaxation before and after each coarser level
  MaskedMultigrid(std::unique_ptr<MaskedLevel> finest, int steps, ThreadTeam& team);

  MaskedLevel& finest() { return *finest_; }
  std::size_t n_levels() const { return coarser_.size() + 1; }
  /// Stiffens links of the body, and its coarser levels by what their functions make of it (Galerkin). Those
  /// of before are so no longer.
  void set_penalties(const std::vector<SlotLink>& links);
  /// Fields of the finest level.
  AlignedArray<float> u, f, r;
  /// u = one cycle for A u = f from nothing; changes r. @return u . f
  double precondition();
  /// Calls work(first entry, how many) for all parts of a field. @return the sum of what it returns
  template<class Work>
  double sum_over_parts(Work&& work) {
    finest_->for_each_part(team_, [&](std::int64_t first, std::int64_t n, int part) {
      sums_[static_cast<std::size_t>(part)] = work(first, n);
    });
    double sum = 0;
    for (const double part : sums_)
      sum += part;
    return sum;
  }
  std::int64_t bytes() const;

private:
  struct Level {
    BlockMatrix A;
    AlignedArray<float> u, f, r, inverse;
    std::vector<float> weights;
    double largest = 0; ///< eigenvalue of inverse diagonal times A, or a little more
    /// What was in A.blocks and inverse before penalties were set.
    std::vector<std::pair<std::size_t, float>> changed_blocks, changed_inverse;
    Weights from_here, to_here; ///< interpolation of the next finer level, and the sums of its residuals
    std::int32_t n() const { return A.n_rows(); }
    std::int64_t bytes() const;
    void forget_penalties();
    void set_penalties(const BlockMatrix& S);
  };

  class FinestDirections;
  class CoarserDirections;

  void build(int steps);
  void add_level(BlockMatrix A, Weights interpolation);
  double largest_eigenvalue();
  double largest_eigenvalue(Level& level);
  void factor_coarsest();
  void solve_coarsest();
  void cycle(std::size_t level);
  void go_down_from_finest();
  void come_up_to_finest();
  /// Calls work(first row, end) for parts of n rows.
  template<class Work>
  void for_rows(std::int32_t n, Work&& work) {
    constexpr std::int32_t rows_per_item = 128, rows_worth_threads = 1000;
    (n < rows_worth_threads ? alone_ : team_)
        .run((n + rows_per_item - 1) / rows_per_item,
             [&](int item, int) { work(item * rows_per_item, std::min(n, (item + 1) * rows_per_item)); });
  }

  std::unique_ptr<MaskedLevel> finest_;
  std::vector<float> weights_; ///< of the finest level's relaxation steps
  double largest_ = 0;         ///< eigenvalue of the finest level, as of the others
  std::vector<Level> coarser_;
  std::vector<std::int64_t> unknowns_; ///< of the coarsest level
  std::vector<float> inverse_;         ///< of its matrix
  std::vector<double> sums_;
  ThreadTeam& team_;
  ThreadTeam alone_{1};
};

/// Residual, correction and image are the fields f, u and r of the multigrid.
class MaskedGradients : public GradientSpace {
public:
  /// Both must outlive this.
  MaskedGradients(MaskedMultigrid& multigrid, ThreadTeam& team);

  /// The state is nothing.
  void restart();
  double precondition() override { return multigrid_.precondition(); }
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;

  const float* state() const { return state_.data(); }
  const float* direction() const { return direction_.data(); }
  std::int64_t bytes() const { return static_cast<std::int64_t>(state_.bytes() + direction_.bytes()); }

private:
  MaskedMultigrid& multigrid_;
  ThreadTeam& team_;
  AlignedArray<float> state_, direction_;
};

} // namespace maille::deform
