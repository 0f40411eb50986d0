#include "elastic/masked/masked_multigrid.hpp"
#include "elastic/multigrid/chebyshev.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

namespace maille::deform {

BlockLevel::BlockLevel(CoarseOperator A, Weights from_here, bool has_sums, int steps, ThreadTeam& team)
    : A_(std::move(A)), from_here_(std::move(from_here)) {
  if (has_sums)
    to_here_ = from_here_.transposed(A_.n_rows());
  constexpr std::size_t whole = 16; // entries that loops over entries take at once
  const auto used = static_cast<std::size_t>(block_stride) * static_cast<std::size_t>(n());
  const std::size_t size = (used + whole - 1) / whole * whole;
  u = AlignedArray<float>(size);
  f = AlignedArray<float>(size);
  r = AlignedArray<float>(size);
  inverse_ = AlignedArray<float>(size);
  invert_diagonal();
  largest_ = largest_eigenvalue(team);
  weights_ = chebyshev_weights(largest_, steps);
}

void BlockLevel::invert_diagonal() {
  A_.copy_diagonal(inverse_);
  const float largest = std::max(0.0F, std::ranges::max(inverse_.all()));
  for (float& entry : inverse_)
    entry = entry > 1e-10f * largest ? 1 / entry : 0; // else all that it moves is fixed
}

/// Preconditioned by the diagonal: u is the direction, f the residual. The state is not kept.
class BlockLevel::Directions : public GradientSpace {
public:
  Directions(BlockLevel& level, ThreadTeam& team) : level_(level), team_(team) {}
  double precondition() override {
    double product = 0;
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      product += double{level_.f[i]} * double{level_.f[i]} * double{level_.inverse_[i]};
    return product;
  }
  std::optional<double> find_step(double beta, double product) override {
    const auto weight = static_cast<float>(beta);
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      level_.u[i] = level_.inverse_[i] * level_.f[i] + weight * level_.u[i];
    level_.A_.apply(level_.u.data(), level_.r.data(), team_);
    double curvature = 0;
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      curvature += level_.inverse_[i] > 0 ? double{level_.u[i]} * double{level_.r[i]} : 0;
    return product / curvature;
  }
  void take_step(double step) override {
    for (std::size_t i = 0; i < level_.u.size(); ++i)
      level_.f[i] -= level_.inverse_[i] > 0 ? static_cast<float>(step) * level_.r[i] : 0;
  }

private:
  BlockLevel& level_;
  ThreadTeam& team_;
};

double BlockLevel::largest_eigenvalue(ThreadTeam& team) {
  for (std::size_t i = 0; i < u.size(); ++i)
    f[i] = eigenvalue_noise(i, inverse_[i]);
  Directions directions(*this, team);
  return largest_eigenvalue_seen_by(directions);
}

void BlockLevel::relax(float weight, ThreadTeam& team) {
  if (A_.has_pieces()) {
    A_.apply(u.data(), r.data(), team);
    for_entries_of_rows(team, [&](std::int64_t first, std::int64_t n) {
      relax_entries(n, weight, inverse_.data() + first, f.data() + first, r.data() + first, u.data() + first);
    });
    return;
  }
  for_rows(n(), team, [&](std::int32_t first, std::int32_t end) {
    relax_blocks(A_.blocks(), first, end, weight, inverse_.data(), f.data(), u.data(), r.data());
  });
  std::swap(u, r);
}

/// r = f - A u
void BlockLevel::find_residual(ThreadTeam& team) {
  if (A_.has_pieces()) {
    A_.apply(u.data(), r.data(), team);
    for_entries_of_rows(team, [&](std::int64_t first, std::int64_t n) {
      subtract_entries(n, inverse_.data() + first, f.data() + first, r.data() + first);
    });
    return;
  }
  for_rows(n(), team, [&](std::int32_t first, std::int32_t end) {
    find_block_residual(A_.blocks(), first, end, f.data(), u.data(), r.data());
  });
}

void BlockLevel::go_down(BlockLevel& coarser, ThreadTeam& team, CycleStart) {
  start_entries(static_cast<std::int64_t>(u.size()), weights_[0], inverse_.data(), f.data(), u.data());
  for (std::size_t step = 1; step < weights_.size(); ++step)
    relax(weights_[step], team);
  find_residual(team);
  for_rows(coarser.n(), team, [&](std::int32_t first, std::int32_t end) {
    interpolate_blocks(coarser.to_here_, first, end, r.data(), false, coarser.f.data());
  });
}

void BlockLevel::come_up(const BlockLevel& coarser, ThreadTeam& team, double*) {
  for_rows(n(), team, [&](std::int32_t first, std::int32_t end) {
    interpolate_blocks(coarser.from_here_, first, end, coarser.u.data(), true, u.data());
  });
  for (std::size_t step = weights_.size(); step-- > 0;)
    relax(weights_[step], team);
}

void BlockLevel::correct_twice() {
  first_.correction = AlignedArray<float>(u.size());
  first_.image = AlignedArray<float>(u.size());
}

/// The fourth number of a row, which does not count, is 0 in u.
double BlockLevel::dot(const float* a, const float* b) const {
  return dot_entries(static_cast<std::int64_t>(u.size()), a, b);
}

void BlockLevel::put_aside(ThreadTeam& team) {
  float* const image = first_.image.data();
  A_.apply(u.data(), image, team);
  first_.curvature = dot(u.data(), image);
  first_.step = first_.curvature > 0 ? dot(u.data(), f.data()) / first_.curvature : 0;
  step_entries(static_cast<std::int64_t>(u.size()), static_cast<float>(first_.step), image, f.data());
  std::swap(u, first_.correction);
}

void BlockLevel::combine(ThreadTeam& team) {
  A_.apply(u.data(), r.data(), team);
  const double overlap = first_.curvature > 0 ? dot(u.data(), first_.image.data()) / first_.curvature : 0,
               curvature = dot(u.data(), r.data()) - overlap * overlap * first_.curvature,
               step = curvature > 0 ? dot(u.data(), f.data()) / curvature : 0;
  const auto of_first = static_cast<float>(first_.step - overlap * step),
             of_second = static_cast<float>(step);
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] = of_first * first_.correction[i] + of_second * u[i];
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
  const BlockMatrix& A = A_.blocks();
  const List<std::int32_t> number = unknowns.numbers(u.size());
  for (std::size_t row = 0; row < static_cast<std::size_t>(n()); ++row)
    for (auto k = static_cast<std::size_t>(A.first[row]); k < static_cast<std::size_t>(A.first[row + 1]); ++k)
      for (std::size_t e = 0; e < 9; ++e) {
        const std::int32_t i = number[block_stride * row + e % 3],
                           j = number[block_stride * static_cast<std::size_t>(A.column[k]) + e / 3];
        if (i >= 0 && j >= 0)
          visit(static_cast<std::size_t>(i), static_cast<std::size_t>(j), double{A.blocks[9 * k + e]});
      }
}

void BlockLevel::forget_penalties() {
  // The last change first, where there are two of one number.
  for (auto change = changed_blocks_.rbegin(); change != changed_blocks_.rend(); ++change)
    A_.blocks().blocks[change->first] = change->second;
  for (auto change = changed_inverse_.rbegin(); change != changed_inverse_.rend(); ++change)
    inverse_[change->first] = change->second;
  changed_blocks_.clear();
  changed_inverse_.clear();
}

void BlockLevel::set_penalties(const BlockMatrix& S) {
  forget_penalties();
  const bool has_pieces = A_.has_pieces();
  if (has_pieces)
    A_.set_added(S);
  BlockMatrix& A = A_.blocks();
  for (std::size_t row = 0; row < static_cast<std::size_t>(S.n_rows()); ++row) {
    double sum[3] = {0, 0, 0}, diagonal[3] = {0, 0, 0};
    auto at = static_cast<std::size_t>(A.first[row]);
    for (auto j = static_cast<std::size_t>(S.first[row]); j < static_cast<std::size_t>(S.first[row + 1]);
         ++j) {
      while (A.column[at] < S.column[j])
        ++at;
      for (std::size_t c = 0; c < 3; ++c) { // links join equal components
        const float value = S.blocks[9 * j + 4 * c];
        if (value == 0)
          continue;
        const std::size_t place = 9 * at + 4 * c;
        if (!has_pieces) {
          changed_blocks_.emplace_back(place, A.blocks[place]);
          A.blocks[place] += value;
        }
        sum[c] += std::abs(double{value});
        diagonal[c] += static_cast<std::size_t>(S.column[j]) == row ? double{value} : 0;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t place = block_stride * row + c;
      if (!(sum[c] > 0) || !(inverse_[place] > 0))
        continue;
      changed_inverse_.emplace_back(place, inverse_[place]);
      inverse_[place] =
          static_cast<float>(1 / (1 / double{inverse_[place]} + std::max(diagonal[c], sum[c] / largest_)));
    }
  }
}

} // namespace maille::deform
