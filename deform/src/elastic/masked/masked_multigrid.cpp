#include "elastic/masked/masked_multigrid.hpp"

#include "elastic/masked/diagonal_gradients.hpp"
#include "elastic/multigrid/chebyshev.hpp"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

namespace maille::deform {

namespace {

/// A level with no more vertices is solved directly.
constexpr std::int32_t most_vertices_solved_directly = 60;
/// If coarsening leaves a larger share of the vertices, the pieces are small, and Joining::places is used.
constexpr double worst_coarsening = 0.6;

/// Coarse grids that are corrected twice, from the finest on. More grids bring little, and cost much where
/// grids shrink slowly.
constexpr std::size_t n_corrected_twice = 2;

/// Relaxation steps of the rounding test. A single step does not detect a chain of 500 cells.
constexpr int most_steps_to_ask = 3;

/// Vertices with matter from `first` to `end`; the finest level also has empty slots.
std::int64_t used_vertices(const Coarsened& coarsened, std::int32_t first, std::int32_t end) {
  std::int64_t n = 0;
  for (auto v = static_cast<std::size_t>(first); v < static_cast<std::size_t>(end); ++v)
    n += coarsened.place[v] >= 0 || coarsened.is_hinge[v] != 0 ? 1 : 0;
  return n;
}

} // namespace

MaskedMultigrid::MaskedMultigrid(std::unique_ptr<MaskedLevel> finest, int steps, ThreadTeam& team)
    : Multigrid(team), finest_(std::move(finest)) {
  largest_ = largest_eigenvalue();
  weights_ = chebyshev_weights(largest_, steps);
  finest_->make_fields(false);
  build(steps);
  for (const auto& level : levels_)
    level->make_fields(true);
  if (finest_->slabs().is_first())
    factor_coarsest();
  round_operators(steps);
  finest_->make_fields(true);
}

/// Moves the interpolation out of `coarsened`.
CoarseOperator MaskedMultigrid::operator_above_finest(const CellComplex& fine, Coarsened& coarsened) {
  const std::int32_t n = coarsened.complex.n_vertices;
  CoarseOperator A = galerkin_product(*finest_, fine, coarsened, n > most_vertices_solved_directly, team());
  to_finest_ = SlotInterpolation(coarsened);
  if (const BlockMatrix springs = finest_->springs_as_matrix(); !springs.column.empty()) {
    const Weights P = to_finest_.rows_of(springs, A.pieces().pieces);
    A.blocks() = sum_of(A.blocks(), galerkin_product(springs, P, P.transposed(n), team()));
  }
  return A;
}

/// Builds the first coarser grid. @param whole receives its operator on the first rank @return its cells, on
/// the first rank
CellComplex MaskedMultigrid::build_by_ranks(int steps, CoarseOperator& whole) {
  const Slabs& slabs = finest_->slabs();
  const CellComplex fine = finest_->matter().complex(team());
  Coarsened next = coarsen(fine, Joining::faces, team(), true);
  shared_.emplace(slabs, next);
  const auto used = used_vertices(next, finest_->rows().first_slot(slabs.own().first),
                                  finest_->rows().first_slot(slabs.own().end));
  if (shared_->n_vertices() > worst_coarsening * slabs.first_of_ranks(static_cast<double>(used)).back()) {
    next = coarsen(fine, Joining::places, team(), true);
    shared_.emplace(slabs, next);
  }
  CellComplex complex = shared_->complex(next);
  CoarseOperator A = galerkin_product(*finest_, fine, next, &*shared_, true, team(), complex.cells, &whole);
  to_finest_ = SlotInterpolation(next);
  levels_.push_back(std::make_unique<BlockLevel>(std::move(A), shared_->parts(), &*shared_, steps, team()));
  return complex;
}

void MaskedMultigrid::build(int steps) {
  CoarseOperator whole{BlockMatrix()}; // of what ranks share
  CellComplex complex =
      finest_->slabs().are_shared() ? build_by_ranks(steps, whole) : finest_->matter().complex(team());
  while (finest_->slabs().is_first() &&
         (levels_.empty() || complex.n_vertices > most_vertices_solved_directly)) {
    const bool is_finest = levels_.empty();
    Coarsened next = coarsen(complex, Joining::faces, team(), is_finest);
    if (next.complex.n_vertices >
        worst_coarsening * static_cast<double>(used_vertices(next, 0, complex.n_vertices)))
      next = coarsen(complex, Joining::places, team(), is_finest);
    Weights to_next;
    if (!is_finest)
      to_next = next.interpolation.transposed(next.complex.n_vertices);
    CoarseOperator A = is_finest ? operator_above_finest(complex, next)
                                 : galerkin_product(levels_.back()->is_shared() ? whole : levels_.back()->A(),
                                                    complex, next, to_next, team());
    whole = CoarseOperator(BlockMatrix());
    if (is_finest)
      levels_.push_back(std::make_unique<BlockLevel>(
          std::move(A),
          first_entries_of_planes(next.complex.cells, {0, (finest_->rows().layers().end + 1) / 2}), nullptr,
          steps, team()));
    else
      levels_.push_back(std::make_unique<BlockLevel>(std::move(A), std::move(next.interpolation),
                                                     std::move(to_next), steps, team()));
    complex = std::move(next.complex);
  }
}

/// Rounds level operators to 16 bits where that is safe. Stiff parts that hang on thin or soft ones rotate at
/// very little energy, and rounding by 2^-11 of their stiffness may exceed it. So each level is tested with
/// the result of a cycle on pseudo-random forces, with few relaxation steps, because relaxation handles stiff
/// motions. The first level is tested with the interpolated result. The smallest level comes first, because a
/// level is stored twice during its test.
void MaskedMultigrid::round_operators(int steps) {
  const bool is_shared = level(0).is_shared();
  const std::size_t n_twice = std::min(n_levels(), n_corrected_twice);
  const auto correct_twice = [&](bool does) {
    for (std::size_t i = 0; i < n_twice; ++i)
      level(i).correct_twice(does);
  };
  if (is_shared ? shared_->n_vertices() > most_vertices_solved_directly : n_levels() > 1) {
    for (std::size_t i = 1; i < n_levels(); ++i)
      level(i).relax_in(std::min(steps, most_steps_to_ask));
    BlockLevel* const second = n_levels() > 1 ? &level(1) : nullptr; // of the first rank
    correct_twice(true);
    if (second != nullptr) {
      second->set_noise(team());
      correct(1);
    }
    correct_twice(false); // for the memory
    level(0).interpolate_from(second, false, team());
    for (std::size_t i = std::max<std::size_t>(is_shared ? 1 : 0, n_levels() - 1); i-- > 0;)
      level(i).round_operator(team());
    for (std::size_t i = 1; i < n_levels(); ++i)
      level(i).relax_in(steps);
  }
  correct_twice(true);
}

double MaskedMultigrid::largest_eigenvalue() {
  finest_->set_noise(team());
  DiagonalGradients<MaskedLevel> gradients(*finest_, team());
  return largest_eigenvalue_seen_by(gradients);
}

void MaskedMultigrid::set_fixed(const std::vector<Prescribed>& prescribed) {
  finest_->set_fixed(prescribed);
}

void MaskedMultigrid::renew_matter() {
  finest_->renew_matter(team());
  largest_ = largest_eigenvalue();
  weights_ = chebyshev_weights(largest_, static_cast<int>(weights_.size()));
}

void MaskedMultigrid::release() {
  levels_.clear();
  to_finest_ = {};
  finest_->make_fields(false);
}

/// level(i).u = approximate solution of A u = level(i).f; changes f.
void MaskedMultigrid::correct(std::size_t i) {
  BlockLevel& here = level(i);
  BlockLevel* const coarser = i + 1 < n_levels() ? &level(i + 1) : nullptr;
  const bool is_last = coarser == nullptr && !here.is_shared();
  const auto once = [&] {
    if (is_last)
      return solve_coarsest();
    here.go_down(coarser, team());
    if (coarser != nullptr)
      correct(i + 1);
    here.come_up(coarser, team());
  };
  once();
  if (is_last || !here.is_corrected_twice())
    return;
  here.store_first_correction(team());
  once();
  here.combine(team());
}

double MaskedMultigrid::precondition() {
  go_down_from_finest();
  correct(0);
  return come_up_to_finest();
}

void MaskedMultigrid::go_down_from_finest() {
  finest_->for_each_part(team(), [&](std::int64_t first, std::int64_t n) {
    start_entries(n, weights_[0], finest_->inverse() + first, finest_->f.data() + first,
                  finest_->u.data() + first);
  });
  finest_->exchange_borders(finest_->u);
  for (std::size_t step = 1; step < weights_.size(); ++step) {
    finest_->relax(weights_[step], team());
    finest_->exchange_borders(finest_->u);
  }
  finest_->find_residual(team());
  finest_->exchange_borders(finest_->r, 2);
  add_up_residuals();
}

/// Restricts the residual to the first coarser grid, slot by slot, so that only the interpolation is stored,
/// not its transpose. Slabs of planes run in parallel; every second one shares no vertex.
void MaskedMultigrid::add_up_residuals() {
  constexpr int planes_per_slab = Slabs::planes_per_unit;
  BlockLevel& coarse = level(0);
  std::ranges::fill(coarse.f.all(), 0.0F);
  const auto& pieces = coarse.A().pieces().pieces;
  const MaskedRows& rows = finest_->rows();
  const PlaneRange own = finest_->slabs().own(); // its vertices lie in these planes and the adjacent ones
  const int begin = std::max(0, own.first - 1), planes = own.end + (finest_->slabs().is_last() ? 0 : 2);
  run_slabs(team(), begin / planes_per_slab, (planes + planes_per_slab - 1) / planes_per_slab, [&](int slab) {
    const int first_plane = std::max(begin, slab * planes_per_slab);
    const std::int32_t end = rows.first_slot(std::min((slab + 1) * planes_per_slab, planes));
    to_finest_.add_up(pieces, rows.first_slot(first_plane), end, finest_->r.data(),
                      finest_->component_stride(), coarse.f.data());
  });
}

/// @return u . f
double MaskedMultigrid::come_up_to_finest() {
  const BlockLevel& coarse = level(0);
  const PlaneRange own = finest_->slabs().own();
  const std::int32_t begin = finest_->rows().first_slot(own.first) / block_stride * block_stride,
                     slots = (finest_->rows().first_slot(own.end) + block_stride - 1) / block_stride *
                             block_stride;
  for_rows(slots - begin, team(), [&](std::int32_t first, std::int32_t end) {
    to_finest_.interpolate(coarse.A().pieces().pieces, begin + first, begin + end, coarse.u.data(),
                           finest_->inverse(), finest_->component_stride(), finest_->u.data());
  });
  finest_->exchange_borders(finest_->u);
  for (std::size_t step = weights_.size(); step-- > 1;) {
    finest_->relax(weights_[step], team());
    finest_->exchange_borders(finest_->u);
  }
  return finest_->relax_and_dot(weights_[0], team());
}

MaskedGradients::MaskedGradients(MaskedMultigrid& multigrid, ThreadTeam& team)
    : multigrid_(multigrid), team_(team), state_(multigrid.finest().field()) {}

void MaskedGradients::restart() {
  std::ranges::fill(state_.all(), 0.0F);
}

AlignedArray<float> MaskedGradients::take_state() {
  return std::exchange(state_, multigrid_.finest().field());
}

std::optional<double> MaskedGradients::find_step(double beta, double product) {
  MaskedLevel& level = multigrid_.finest();
  if (direction_.size() == 0) // allocated after the first residual, to limit memory
    direction_ = level.field();
  float* const p = direction_.data();
  level.for_each_part(team_, [&](std::int64_t at, std::int64_t n) {
    direct_entries(n, level.u.data() + at, static_cast<float>(beta), p + at);
  });
  level.exchange_borders(direction_);
  const double curvature = level.apply_and_dot(p, level.r.data(), team_);
  return curvature > 0 ? std::optional(product / curvature) : std::nullopt;
}

void MaskedGradients::take_step(double step) {
  const auto length = static_cast<float>(step);
  multigrid_.finest().for_each_part(team_, [&](std::int64_t at, std::int64_t n) {
    step_entries(n, -length, direction_.data() + at, state_.data() + at);
    step_entries(n, length, multigrid_.finest().r.data() + at, multigrid_.finest().f.data() + at);
  });
}

} // namespace maille::deform
