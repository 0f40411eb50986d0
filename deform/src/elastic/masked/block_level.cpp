#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/masked/diagonal_gradients.hpp"
#include "elastic/masked/masked_multigrid.hpp"
#include "elastic/multigrid/chebyshev.hpp"

#include <algorithm>
#include <cmath>

#include <cstdint>
#include <utility>

namespace maille::deform {

namespace {

/// Entries of n vertices, rounded up to whole lines for the loops.
std::size_t entries_of(std::int32_t n) {
  return static_cast<std::size_t>(padded_row(block_stride * n));
}

List<std::int64_t> usual_parts(std::size_t size) {
  List<std::int64_t> first;
  for (std::size_t part = 0; part <= n_parts_of(size); ++part)
    first.push_back(static_cast<std::int64_t>(std::min(size, part * entries_of_part)));
  return first;
}

} // namespace

BlockLevel::BlockLevel(CoarseOperator A, Weights from_here, Weights to_here, int steps, ThreadTeam& team)
    : BlockLevel(std::move(A), usual_parts(entries_of(A.n_rows())), nullptr, steps, team) {
  from_here_ = std::move(from_here);
  to_here_ = std::move(to_here);
}

BlockLevel::BlockLevel(CoarseOperator A, List<std::int64_t> parts, const SharedPieces* shared, int steps,
                       ThreadTeam& team)
    : A_(std::move(A)), shared_(shared), parts_(std::move(parts)), sums_(parts_.size() - 1) {
  inverse_ = AlignedArray<float>(entries_of(n()));
  if (is_shared() && shared->is_first())
    of_all_ = AlignedArray<float>(entries_of(shared->n_vertices()));
  make_fields(true);
  invert_diagonal(team);
  largest_ = largest_eigenvalue(team);
  make_fields(false);
  relax_in(steps);
}

void BlockLevel::relax_in(int steps) {
  weights_ = chebyshev_weights(largest_, steps);
}

void BlockLevel::invert_diagonal(ThreadTeam& team) {
  A_.copy_diagonal(inverse_, team);
  const auto first = static_cast<std::size_t>(parts_.front()), end = static_cast<std::size_t>(parts_.back());
  float largest = 0;
  for (std::size_t i = first; i < end; ++i)
    largest = std::max(largest, inverse_[i]);
  if (is_shared())
    largest = static_cast<float>(shared_->largest(double{largest}));
  for (std::size_t i = 0; i < inverse_.size(); ++i) { // else the component is fixed, or owned by another rank
    float& entry = inverse_[i];
    entry = entry > 1e-10f * largest && i >= first && i < end ? 1 / entry : 0;
  }
}

void BlockLevel::set_noise(ThreadTeam& team) {
  for_each_part(team, [&](std::int64_t first, std::int64_t n) {
    noise_entries(n, first + (is_shared() ? shared_->offset() : 0), inverse_.data() + first,
                  f.data() + first);
  });
}

double BlockLevel::energy(ThreadTeam& team) {
  A_.apply(u.data(), r.data(), team);
  return dot(u.data(), r.data(), team);
}

void BlockLevel::round_operator(ThreadTeam& team) {
  constexpr double small_part = 0.03;           // larger changes cost iterations, as measured
  constexpr std::int32_t fewest_vertices = 500; // smaller levels take little memory
  if ((is_shared() ? shared_->n_vertices() : n()) < fewest_vertices)
    return;
  const double exact = energy(team);
  A_.round(team);
  if (std::abs(energy(team) - exact) <= small_part * exact)
    A_.forget_exact();
  else
    A_.undo_rounding();
}

double BlockLevel::largest_eigenvalue(ThreadTeam& team) {
  set_noise(team);
  DiagonalGradients<BlockLevel> gradients(*this, team);
  return largest_eigenvalue_seen_by(gradients);
}

double BlockLevel::apply_and_dot(const float* p, float* Ap, ThreadTeam& team) {
  A_.apply(p, Ap, team);
  return sum_over_parts(team, [&](std::int64_t first, std::int64_t n) {
    return mask_and_dot_entries(n, inverse() + first, p + first, Ap + first);
  });
}

void BlockLevel::relax(float weight, ThreadTeam& team) {
  if (A_.has_pieces()) {
    A_.apply(u.data(), r.data(), team);
    for_each_part(team, [&](std::int64_t first, std::int64_t n) {
      relax_entries(n, weight, inverse_.data() + first, f.data() + first, r.data() + first, u.data() + first);
    });
    exchange_borders(u);
    return;
  }
  for_rows(n(), team, [&](std::int32_t first, std::int32_t end) {
    A_.with_blocks([&](const auto& blocks) {
      relax_blocks(blocks, first, end, weight, inverse_.data(), f.data(), u.data(), r.data());
    });
  });
  std::swap(u, r);
  exchange_borders(u);
}

/// r = f - A u
void BlockLevel::find_residual(ThreadTeam& team) {
  if (A_.has_pieces()) {
    A_.apply(u.data(), r.data(), team);
    for_each_part(team, [&](std::int64_t first, std::int64_t n) {
      subtract_entries(n, inverse_.data() + first, f.data() + first, r.data() + first);
    });
    return;
  }
  for_rows(n(), team, [&](std::int32_t first, std::int32_t end) {
    A_.with_blocks(
        [&](const auto& blocks) { find_block_residual(blocks, first, end, f.data(), u.data(), r.data()); });
  });
}

void BlockLevel::go_down(BlockLevel* coarser, ThreadTeam& team) {
  for_each_part(team, [&](std::int64_t first, std::int64_t n) {
    start_entries(n, weights_[0], inverse_.data() + first, f.data() + first, u.data() + first);
  });
  exchange_borders(u);
  for (std::size_t step = 1; step < weights_.size(); ++step)
    relax(weights_[step], team);
  find_residual(team);
  if (is_shared())
    shared_->collect(r.data(), of_all_.data());
  const float* const residual = is_shared() ? of_all_.data() : r.data();
  if (coarser != nullptr)
    for_rows(coarser->n(), team, [&](std::int32_t first, std::int32_t end) {
      interpolate_blocks(coarser->to_here_, first, end, residual, false, coarser->f.data());
    });
}

void BlockLevel::interpolate_from(const BlockLevel* coarser, bool adds, ThreadTeam& team) {
  if (is_shared() && adds)
    shared_->collect(u.data(), of_all_.data());
  float* const of_all = is_shared() ? of_all_.data() : u.data();
  if (coarser != nullptr)
    for_rows(coarser->from_here_.n_rows(), team, [&](std::int32_t first, std::int32_t end) {
      interpolate_blocks(coarser->from_here_, first, end, coarser->u.data(), adds, of_all);
    });
  if (is_shared())
    shared_->hand_out(of_all, u.data());
  exchange_borders(u);
}

void BlockLevel::come_up(const BlockLevel* coarser, ThreadTeam& team) {
  interpolate_from(coarser, true, team);
  for (std::size_t step = weights_.size(); step-- > 0;)
    relax(weights_[step], team);
}

void BlockLevel::correct_twice(bool does) {
  is_corrected_twice_ = does;
  first_.correction = AlignedArray<float>(does ? u.size() : 0);
}

/// The unused fourth number of a row is 0 in u.
double BlockLevel::dot(const float* a, const float* b, ThreadTeam& team) {
  return sum_over_parts(
      team, [&](std::int64_t first, std::int64_t n) { return dot_entries(n, a + first, b + first); });
}

void BlockLevel::store_first_correction(ThreadTeam& team) {
  A_.apply(u.data(), r.data(), team);
  first_.curvature = dot(u.data(), r.data(), team);
  first_.step = first_.curvature > 0 ? dot(u.data(), f.data(), team) / first_.curvature : 0;
  for_each_part(team, [&](std::int64_t first, std::int64_t n) {
    step_entries(n, static_cast<float>(first_.step), r.data() + first, f.data() + first);
  });
  std::swap(u, first_.correction);
}

void BlockLevel::combine(ThreadTeam& team) {
  A_.apply(u.data(), r.data(), team);
  const double overlap = first_.curvature > 0
                             ? dot(first_.correction.data(), r.data(), team) / first_.curvature
                             : 0,
               curvature = dot(u.data(), r.data(), team) - overlap * overlap * first_.curvature,
               step = curvature > 0 ? dot(u.data(), f.data(), team) / curvature : 0;
  const auto of_first = static_cast<float>(first_.step - overlap * step),
             of_second = static_cast<float>(step);
  for_each_part(team, [&](std::int64_t first, std::int64_t n) {
    combine_entries(n, of_first, first_.correction.data() + first, of_second, u.data() + first);
  });
}

CoarsestSolve::Unknowns BlockLevel::unknowns() const {
  CoarsestSolve::Unknowns unknowns;
  unknowns.are_rounded = true;
  unknowns.begin_layer();
  for (std::size_t i = 0; i < inverse_.size(); ++i)
    if (inverse_[i] > 0)
      unknowns.place.push_back(static_cast<std::int64_t>(i));
  unknowns.begin_layer();
  return unknowns;
}

void BlockLevel::for_each_entry(const CoarsestSolve::Unknowns& unknowns,
                                const CoarsestSolve::Visit& visit) const {
  const List<std::int32_t> number = unknowns.numbers(u.size());
  const BlockMatrix& A = A_.blocks();
  for (std::size_t row = 0; row + 1 < A.first.size(); ++row)
    for (auto k = static_cast<std::size_t>(A.first[row]); k < static_cast<std::size_t>(A.first[row + 1]); ++k)
      for (std::size_t e = 0; e < 9; ++e) {
        const std::int32_t i = number[block_stride * row + e % 3],
                           j = number[block_stride * static_cast<std::size_t>(A.column[k]) + e / 3];
        if (i >= 0 && j >= 0)
          visit(static_cast<std::size_t>(i), static_cast<std::size_t>(j), double{A.blocks[9 * k + e]});
      }
}

} // namespace maille::deform
