#pragma once
/// Multigrid for elasticity on a body of any shape, as the preconditioner of conjugate gradients.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_level.hpp"
#include "elastic/masked/slot_interpolation.hpp"
#include "elastic/multigrid/multigrid.hpp"

#include <numeric>
#include <optional>
#include <utility>

namespace maille::deform {

template<class Level>
class DiagonalGradients;

/// A coarser grid of a body.
class BlockLevel {
public:
  /// @param from_here interpolation of the next finer level; none where that is the body's own
  /// @param to_here transposed
  BlockLevel(CoarseOperator A, Weights from_here, Weights to_here, int steps, ThreadTeam& team);
  /// The finest of them. @param parts entries whose products are added up first, and the end
  /// @param shared if not null, then all ranks call what is below together, but for what coarser levels do;
  ///        the level has the rank's rows. It must outlive this
  BlockLevel(CoarseOperator A, List<std::int64_t> parts, const SharedPieces* shared, int steps,
             ThreadTeam& team);

  const CoarseOperator& A() const { return A_; }
  std::int32_t n() const { return A_.n_rows(); }
  /// Forces whose answers are made of soft motions more than of others, as those of conjugate gradients are.
  void set_noise(ThreadTeam& team);
  /// Relaxes with this number of steps before and after each coarser level.
  void relax_in(int steps);
  /// A is kept in numbers of 16 bits where that changes the energy of u by a small part at most.
  void round_operator(ThreadTeam& team);

  AlignedArray<float> u, f, r; ///< block_stride numbers a vertex
  /// The fields are not needed while coarser grids are built; at first they do not exist.
  void make_fields(bool does) {
    for (AlignedArray<float>* const field : {&u, &f, &r})
      *field = AlignedArray<float>(does ? inverse_.size() : 0);
  }
  /// The first of two corrections. @pre is_corrected_twice()
  struct FirstCorrection {
    AlignedArray<float> correction;
    double curvature = 0, step = 0;
  };
  bool is_corrected_twice() const { return is_corrected_twice_; }
  void correct_twice(bool does);
  /// u is a correction for A u = f: it is put aside, and f becomes what its best multiple leaves.
  void put_aside(ThreadTeam& team);
  /// u is a correction for that: it becomes the best sum of both.
  void combine(ThreadTeam& team);

  bool is_shared() const { return shared_ != nullptr; }
  /// @param coarser null on ranks that have none
  void go_down(BlockLevel* coarser, ThreadTeam& team);
  void come_up(const BlockLevel* coarser, ThreadTeam& team);
  /// u = what coarser.u is here, or that added to it.
  void take_from(const BlockLevel* coarser, bool adds, ThreadTeam& team);
  // Interface of CoarsestLevel.
  CoarsestSolve::Unknowns unknowns() const;
  void for_each_entry(const CoarsestSolve::Unknowns& unknowns, const CoarsestSolve::Visit& visit) const;

private:
  friend class DiagonalGradients<BlockLevel>;
  const float* inverse() const { return inverse_.data(); }
  double apply_and_dot(const float* p, float* Ap, ThreadTeam& team);
  void invert_diagonal(ThreadTeam& team);
  double largest_eigenvalue(ThreadTeam& team);
  double energy(ThreadTeam& team);
  void relax(float weight, ThreadTeam& team);
  void find_residual(ThreadTeam& team);
  /// Calls work(first entry, how many) for parts of a field, of any length. @return the sum of what it
  /// returns
  template<class Work>
  double sum_over_parts(ThreadTeam& team, const Work& work) {
    team.run(static_cast<int>(sums_.size()), [&](int item, int) {
      const auto part = static_cast<std::size_t>(item);
      sums_[part] = work(parts_[part], parts_[part + 1] - parts_[part]);
    });
    return is_shared() ? shared_->total(sums_) : std::accumulate(sums_.begin(), sums_.end(), 0.0);
  }
  void exchange_borders(AlignedArray<float>& field) const {
    if (is_shared())
      shared_->exchange_borders(field.data());
  }
  template<class Work>
  void for_each_part(ThreadTeam& team, const Work& work) {
    for_parts(u.size(), team, [&](std::size_t first, std::size_t end, std::size_t) {
      work(static_cast<std::int64_t>(first), static_cast<std::int64_t>(end - first));
    });
  }
  double dot(const float* a, const float* b, ThreadTeam& team);

  CoarseOperator A_;
  Weights from_here_, to_here_; ///< to_here_ sums the finer level's residuals
  AlignedArray<float> inverse_; ///< of the diagonal
  double largest_ = 0;          ///< eigenvalue of inverse diagonal times A, or a little more
  std::vector<float> weights_;  ///< of the relaxation
  FirstCorrection first_;
  bool is_corrected_twice_ = false; ///< also where a rank has no vertices
  const SharedPieces* shared_ = nullptr;
  List<std::int64_t> parts_;
  AlignedArray<float> of_all_; ///< a field of all ranks, where it is shared, on the first
  std::vector<double> sums_;   ///< of parts of a field
};

/// Coarser grids on which parts of the body that are not joined through faces stay apart (see coarsen:
/// muscles touch at edges, and a coarse grid that joins such hinges cannot correct how they turn), the exact
/// operator between their functions (Galerkin); on top of them the body's own, which is not assembled.
///
/// Coarse functions are too stiff where a body is thin beside them. So the problems of the two finest of the
/// coarser grids are corrected twice, by steps of the right length (conjugate gradients): what the first
/// correction is short of, the second makes good. Ranks share the body's own grid and the first of the
/// coarser ones; the others are on the first rank.
///
/// Cost    the finest of the coarser grids, of an eighth to a fifth as many vertices as nodes, has a matrix
///         for each pattern of matter in a piece, the others some 27 blocks of 36 bytes a vertex; where
///         matter is different from cell to cell, all have blocks. The finest two levels have most of the
///         work
/// Source  Notay and Vassilevski 2008, Recursive Krylov-based multigrid cycles, section 2
/// Figures docs/developers/relaxation.md. See Multigrid.
class MaskedMultigrid : private Multigrid<BlockLevel> {
public:
  /// @param steps of relaxation before and after each coarser level
  MaskedMultigrid(std::unique_ptr<MaskedLevel> finest, int steps, ThreadTeam& team);

  MaskedLevel& finest() { return *finest_; }
  /// Other components are fixed at the finest level, or its matter has other constants, while coarser levels
  /// stay what they were: for those that are near, as good a preconditioner.
  void set_fixed(const std::vector<Prescribed>& prescribed);
  void renew_matter();
  /// Frees all but the meaning of the fields of finest().
  void release();
  /// finest().u = one cycle for A u = finest().f from nothing; changes r. @return u . f
  double precondition();

private:
  double largest_eigenvalue();
  void build(int steps);
  CellComplex build_by_ranks(int steps, CoarseOperator& whole);
  CoarseOperator operator_above_finest(const CellComplex& fine, Coarsened& coarsened);
  void round_operators(int steps);
  void correct(std::size_t level);
  void go_down_from_finest();
  void add_up_residuals();
  double come_up_to_finest();

  std::unique_ptr<MaskedLevel> finest_;
  SlotInterpolation to_finest_;
  std::optional<SharedPieces> shared_; ///< of the first coarser grid, where ranks share the finest
  std::vector<float> weights_;         ///< of the finest level's relaxation steps
  double largest_ = 0;                 ///< eigenvalue of the finest level, as of the others
};

/// Residual, correction and image are the fields f, u and r of the multigrid.
class MaskedGradients : public GradientSpace {
public:
  /// Both must outlive this.
  MaskedGradients(MaskedMultigrid& multigrid, ThreadTeam& team);

  /// The state is nothing.
  void restart();
  /// The same. @return the previous state
  AlignedArray<float> take_state();
  double precondition() override { return multigrid_.precondition(); }
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;

  /// Nothing but the state is left.
  void release_direction() { direction_ = {}; }
  const float* state() const { return state_.data(); }
  const float* direction() const { return direction_.data(); }

private:
  MaskedMultigrid& multigrid_;
  ThreadTeam& team_;
  AlignedArray<float> state_, direction_;
};

} // namespace maille::deform
