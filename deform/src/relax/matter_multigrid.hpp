#pragma once
/// Multigrid for elasticity on a body of any shape, as a preconditioner.

#include "relax/matter_level.hpp"

#include <memory>
#include <span>
#include <vector>

namespace maille::deform {

/// A symmetric V-cycle: Chebyshev's Jacobi steps on every level, coarser grids on which pieces of matter that are not joined through
/// faces stay apart (see coarsen), the exact operator between their functions (Galerkin), a direct solve at the bottom.
///
/// Both are for the sake of hinges, thin bridges and slots. Averaged stiffness on merged vertices needs 12 iterations of conjugate gradients
/// for one muscle and 135 for a leg of seven that touch at edges; exact operators 4 and 37; vertices of their own as well 4 and 30
/// (theory.md, section 7).
///
/// Same bits for any number of threads.
class MatterMultigrid {
public:
  /// @param steps of relaxation before and after each coarser level
  MatterMultigrid(std::unique_ptr<MatterLevel> finest, int steps, ThreadTeam& team);

  MatterLevel& finest() { return *finest_; }
  std::size_t n_levels() const { return coarser_.size() + 1; }
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
  /// At the most while it was made.
  std::int64_t peak_bytes() const { return peak_bytes_; }

private:
  struct Level {
    BlockMatrix A;
    AlignedArray<float> u, f, r, inverse;
    std::vector<float> weights;
    Weights from_here, to_here; ///< interpolation of the next finer level, and the sums of its residuals
    std::int32_t n() const { return A.n_rows(); }
    std::int64_t bytes() const;
  };

  void build(int steps);
  void add_level(BlockMatrix A, Weights interpolation);
  double largest_eigenvalue();
  double largest_eigenvalue(Level& level);
  void factor_coarsest();
  void solve_coarsest();
  void cycle(std::size_t level);
  void go_down_from_finest();
  void come_up_to_finest();
  template<class Work>
  void for_rows(std::int32_t n, Work&& work);

  std::unique_ptr<MatterLevel> finest_;
  std::vector<float> weights_; ///< of the finest level's relaxation steps
  std::vector<Level> coarser_;
  std::vector<std::int64_t> unknowns_; ///< of the coarsest level
  std::vector<float> inverse_;         ///< of its matrix
  std::vector<double> sums_;
  std::int64_t peak_bytes_ = 0;
  ThreadTeam& team_;
  ThreadTeam alone_{1};
};

} // namespace maille::deform
