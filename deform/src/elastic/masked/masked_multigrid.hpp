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
  /// @param from_here interpolation of the next finer level from this one; empty on the first coarser grid
  /// @param to_here its transpose
  BlockLevel(CoarseOperator A, Weights from_here, Weights to_here, int steps, ThreadTeam& team);
  /// The first coarser grid. @param parts ranges of entries for sums, and the end @param shared must outlive
  /// this. If not null, all ranks call the functions below together, and the level has the rank's rows
  BlockLevel(CoarseOperator A, List<std::int64_t> parts, const SharedPieces* shared, int steps,
             ThreadTeam& team);

  const CoarseOperator& A() const { return A_; }
  std::int32_t n() const { return A_.n_rows(); }
  /// f = pseudo-random forces that excite soft motions most, as the residuals of conjugate gradients do.
  void set_noise(ThreadTeam& team);
  /// Sets the number of relaxation steps before and after each coarser level.
  void relax_in(int steps);
  /// Rounds A to 16 bits if that changes the energy of u by little.
  void round_operator(ThreadTeam& team);

  AlignedArray<float> u, f, r; ///< block_stride numbers a vertex
  /// Makes the fields, or frees them while coarser grids are built.
  void make_fields(bool does) {
    for (AlignedArray<float>* const field : {&u, &f, &r})
      *field = AlignedArray<float>(does ? inverse_.size() : 0);
  }
  /// The first of two corrections. See MaskedMultigrid.
  struct FirstCorrection {
    AlignedArray<float> correction;
    double curvature = 0, step = 0;
  };
  bool is_corrected_twice() const { return is_corrected_twice_; }
  void correct_twice(bool does);
  /// Stores u as the first correction, and subtracts its best multiple from the problem: f -= step A u.
  void store_first_correction(ThreadTeam& team);
  /// u = the best linear combination of u and the first correction.
  void combine(ThreadTeam& team);

  bool is_shared() const { return shared_ != nullptr; }
  /// @param coarser null on ranks that have none
  void go_down(BlockLevel* coarser, ThreadTeam& team);
  void come_up(const BlockLevel* coarser, ThreadTeam& team);
  /// u = interpolation of coarser.u, or u += it.
  void interpolate_from(const BlockLevel* coarser, bool adds, ThreadTeam& team);
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
  /// Calls work(first entry, how many) for parts of a field. @return the sum of its results
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
  bool is_corrected_twice_ = false; ///< also on ranks without vertices
  const SharedPieces* shared_ = nullptr;
  List<std::int64_t> parts_;
  AlignedArray<float> of_all_; ///< the gathered field, on the first rank of a shared level
  std::vector<double> sums_;   ///< of parts of a field
};

/// Multigrid of a body of any shape. On coarser grids, parts of the body that are not joined through faces
/// stay apart (see coarsen): muscles touch at edges, and a coarse grid that joins such hinges cannot correct
/// their rotation. Coarse operators are exact Galerkin products; the finest operator is not assembled.
///
/// Coarse functions are too stiff where a body is thin compared with them. So the two finest coarse problems
/// are corrected twice, with optimal step lengths (two steps of conjugate gradients). Ranks share the finest
/// grid and the first coarser one; the others are on the first rank.
/// Cost    the first coarser grid has an eighth to a fifth as many vertices as the body has nodes, and a
///         matrix for each pattern of matter in a piece; where every cell differs, and on the other grids,
///         some 27 blocks of 36 bytes a vertex. The two finest levels have most of the work
/// Source  Notay and Vassilevski 2008, Recursive Krylov-based multigrid cycles, section 2
/// Figures docs/developers/relaxation.md. See Multigrid.
class MaskedMultigrid : private Multigrid<BlockLevel> {
public:
  /// @param steps of relaxation before and after each coarser level
  MaskedMultigrid(std::unique_ptr<MaskedLevel> finest, int steps, ThreadTeam& team);

  MaskedLevel& finest() { return *finest_; }
  /// Changes the fixed components of the finest level, or reads the constants of matter anew there. Coarser
  /// levels stay as they are: as good a preconditioner if the change is small.
  void set_fixed(const std::vector<Prescribed>& prescribed);
  void renew_matter();
  /// Frees the hierarchy; rows and units of finest() stay.
  void release();
  /// finest().u = one cycle for A u = finest().f, starting at 0; changes r. @return u . f
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

/// Conjugate gradients on the finest level: residual, correction and image are its fields f, u and r.
class MaskedGradients : public GradientSpace {
public:
  /// Both must outlive this.
  MaskedGradients(MaskedMultigrid& multigrid, ThreadTeam& team);

  /// Sets the state to 0.
  void restart();
  /// Sets the state to 0. @return the previous state
  AlignedArray<float> take_state();
  double precondition() override { return multigrid_.precondition(); }
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;

  /// Frees all but the state.
  void release_direction() { direction_ = {}; }
  const float* state() const { return state_.data(); }
  const float* direction() const { return direction_.data(); }

private:
  MaskedMultigrid& multigrid_;
  ThreadTeam& team_;
  AlignedArray<float> state_, direction_;
};

} // namespace maille::deform
