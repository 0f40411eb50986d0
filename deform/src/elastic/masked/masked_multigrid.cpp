#include "elastic/masked/masked_multigrid.hpp"

#include "elastic/krylov/chebyshev.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// A level with no more vertices is solved directly.
constexpr std::int32_t most_vertices_solved_directly = 150;
/// If coarsening leaves more of the vertices than this, there are many small pieces, and they are joined.
constexpr double worst_coarsening = 0.6;

/// The finest level has slots without matter.
double used_rows(const Weights& P) {
  std::int32_t n = 0;
  for (std::size_t row = 0; row < static_cast<std::size_t>(P.n_rows()); ++row)
    n += P.first[row + 1] > P.first[row] ? 1 : 0;
  return n;
}

} // namespace

std::int64_t MaskedMultigrid::Level::bytes() const {
  return A.bytes() + from_here.bytes() + to_here.bytes() +
         static_cast<std::int64_t>(u.bytes() + f.bytes() + r.bytes() + inverse.bytes() +
                                   (changed_blocks.capacity() + changed_inverse.capacity()) *
                                       sizeof(changed_blocks[0]));
}

MaskedMultigrid::MaskedMultigrid(std::unique_ptr<MaskedLevel> finest, int steps, ThreadTeam& team)
    : u(finest->field()), f(finest->field()), r(finest->field()), finest_(std::move(finest)), team_(team) {
  sums_.resize(static_cast<std::size_t>(finest_->n_parts()));
  largest_ = largest_eigenvalue();
  weights_ = chebyshev_weights(largest_, steps);
  build(steps);
  factor_coarsest();
}

void MaskedMultigrid::build(int steps) {
  CellComplex complex = finest_->complex();
  do {
    Coarsened next = coarsen(complex, Joining::faces);
    if (next.complex.n_vertices > worst_coarsening * used_rows(next.interpolation))
      next = coarsen(complex, Joining::places);
    BlockMatrix A;
    if (coarser_.empty())
      A = finest_->galerkin_product(complex, next, team_);
    else
      A = galerkin_product(coarser_.back().A, next.interpolation,
                           next.interpolation.transposed(next.complex.n_vertices), team_);
    add_level(std::move(A), std::move(next.interpolation));
    coarser_.back().largest = largest_eigenvalue(coarser_.back());
    coarser_.back().weights = chebyshev_weights(coarser_.back().largest, steps);
    complex = std::move(next.complex);
  } while (complex.n_vertices > most_vertices_solved_directly);
}

void MaskedMultigrid::add_level(BlockMatrix A, Weights interpolation) {
  Level& level = coarser_.emplace_back();
  level.A = std::move(A);
  level.to_here = interpolation.transposed(level.n());
  level.from_here = std::move(interpolation);
  constexpr std::size_t whole = 16; // entries that loops over entries take at once
  const auto used = static_cast<std::size_t>(block_stride) * static_cast<std::size_t>(level.n());
  const std::size_t size = (used + whole - 1) / whole * whole;
  level.u = AlignedArray<float>(size);
  level.f = AlignedArray<float>(size);
  level.r = AlignedArray<float>(size);
  level.inverse = AlignedArray<float>(size);
  float largest = 0;
  for (const bool is_second : {false, true})
    for (std::int32_t row = 0; row < level.n(); ++row) {
      const auto begin = level.A.column.begin();
      const auto at = std::lower_bound(begin + level.A.first[static_cast<std::size_t>(row)],
                                       begin + level.A.first[static_cast<std::size_t>(row) + 1], row) -
                      begin;
      for (int c = 0; c < 3; ++c) {
        const float diagonal = level.A.blocks[static_cast<std::size_t>(9 * at + 4 * c)];
        if (!is_second)
          largest = std::max(largest, diagonal);
        else if (diagonal > 1e-10f * largest) // else all that it moves is fixed
          level.inverse[static_cast<std::size_t>(block_stride * row + c)] = 1 / diagonal;
      }
    }
}

double MaskedMultigrid::precondition() {
  go_down_from_finest();
  cycle(0);
  come_up_to_finest();
  return sum_over_parts(
      [&](std::int64_t first, std::int64_t n) { return dot_entries(n, u.data() + first, f.data() + first); });
}

void MaskedMultigrid::go_down_from_finest() {
  const float* const inverse = finest_->inverse();
  finest_->for_each_part(team_, [&](std::int64_t first, std::int64_t n, int) {
    start_entries(n, weights_[0], inverse + first, f.data() + first, u.data() + first);
  });
  for (std::size_t step = 1; step < weights_.size(); ++step) {
    finest_->apply(u.data(), r.data(), team_);
    finest_->for_each_part(team_, [&](std::int64_t first, std::int64_t n, int) {
      relax_entries(n, weights_[step], inverse + first, f.data() + first, r.data() + first, u.data() + first);
    });
  }
  finest_->apply(u.data(), r.data(), team_);
  finest_->for_each_part(team_, [&](std::int64_t first, std::int64_t n, int) {
    subtract_entries(n, inverse + first, f.data() + first, r.data() + first);
  });
  Level& coarse = coarser_[0];
  const std::int64_t stride = finest_->component_stride();
  for_rows(coarse.n(), [&](std::int32_t first, std::int32_t end) {
    for (std::int32_t row = first; row < end; ++row) {
      float sum[3] = {0, 0, 0};
      for (std::int32_t i = coarse.to_here.first.data()[row]; i < coarse.to_here.first.data()[row + 1]; ++i) {
        const float weight = coarse.to_here.weight.data()[i];
        const float* const from = r.data() + coarse.to_here.column.data()[i];
        for (int c = 0; c < 3; ++c)
          sum[c] += weight * from[c * stride];
      }
      std::copy_n(sum, 3, coarse.f.data() + std::int64_t{block_stride} * row);
    }
  });
}

void MaskedMultigrid::come_up_to_finest() {
  const float* const inverse = finest_->inverse();
  const Level& coarse = coarser_[0];
  for_rows(coarse.from_here.n_rows(), [&](std::int32_t first, std::int32_t end) {
    interpolate_slots(coarse.from_here, first, end, coarse.u.data(), inverse, finest_->component_stride(),
                      u.data());
  });
  for (std::size_t step = weights_.size(); step-- > 0;) {
    finest_->apply(u.data(), r.data(), team_);
    finest_->for_each_part(team_, [&](std::int64_t first, std::int64_t n, int) {
      relax_entries(n, weights_[step], inverse + first, f.data() + first, r.data() + first, u.data() + first);
    });
  }
}

void MaskedMultigrid::cycle(std::size_t number) {
  if (number + 1 == coarser_.size()) {
    solve_coarsest();
    return;
  }
  Level &level = coarser_[number], &next = coarser_[number + 1];
  const auto relax = [&](float weight) {
    for_rows(level.n(), [&](std::int32_t first, std::int32_t end) {
      relax_blocks(level.A, first, end, weight, level.inverse.data(), level.f.data(), level.u.data(),
                   level.r.data());
    });
    std::swap(level.u, level.r);
  };
  start_entries(static_cast<std::int64_t>(level.u.size()), level.weights[0], level.inverse.data(),
                level.f.data(), level.u.data());
  for (std::size_t step = 1; step < level.weights.size(); ++step)
    relax(level.weights[step]);
  for_rows(level.n(), [&](std::int32_t first, std::int32_t end) {
    find_block_residual(level.A, first, end, level.f.data(), level.u.data(), level.r.data());
  });
  for_rows(next.n(), [&](std::int32_t first, std::int32_t end) {
    interpolate_blocks(next.to_here, first, end, level.r.data(), false, next.f.data());
  });
  cycle(number + 1);
  for_rows(level.n(), [&](std::int32_t first, std::int32_t end) {
    interpolate_blocks(next.from_here, first, end, next.u.data(), true, level.u.data());
  });
  for (std::size_t step = level.weights.size(); step-- > 0;)
    relax(level.weights[step]);
}

void MaskedMultigrid::factor_coarsest() {
  constexpr double nothing =
      1e-9; // beside the stiffness of a vertex: for motions of what is fixed, or there twice
  const Level& level = coarser_.back();
  std::vector<Eigen::Index> place(level.u.size(), -1);
  unknowns_.clear();
  for (std::size_t i = 0; i < level.inverse.size(); ++i)
    if (level.inverse[i] > 0) {
      place[i] = static_cast<Eigen::Index>(unknowns_.size());
      unknowns_.push_back(static_cast<std::int64_t>(i));
    }
  const auto n = static_cast<Eigen::Index>(unknowns_.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t row = 0; row < static_cast<std::size_t>(level.n()); ++row)
    for (auto k = static_cast<std::size_t>(level.A.first[row]);
         k < static_cast<std::size_t>(level.A.first[row + 1]); ++k)
      for (std::size_t e = 0; e < 9; ++e) {
        const Eigen::Index i = place[block_stride * row + e % 3],
                           j = place[block_stride * static_cast<std::size_t>(level.A.column[k]) + e / 3];
        if (i >= 0 && j >= 0)
          K(i, j) = double{level.A.blocks[9 * k + e]};
      }
  // In units that make the diagonal 1, so that matter of any stiffness counts alike.
  const Eigen::VectorXd unit = K.diagonal().array().rsqrt();
  K = unit.asDiagonal() * (0.5 * (K + K.transpose())).eval() * unit.asDiagonal();
  Eigen::LLT<Eigen::MatrixXd> factors;
  for (double shift = nothing; shift < 1; shift *= 10) {
    K.diagonal().array() += shift;
    factors.compute(K);
    if (factors.info() == Eigen::Success)
      break;
  }
  const Eigen::MatrixXd inverse =
      unit.asDiagonal() * factors.solve(Eigen::MatrixXd::Identity(n, n)) * unit.asDiagonal();
  inverse_.resize(unknowns_.size() * unknowns_.size());
  Eigen::Map<Eigen::MatrixXf>(inverse_.data(), n, n) = (0.5 * (inverse + inverse.transpose())).cast<float>();
}

void MaskedMultigrid::solve_coarsest() {
  Level& level = coarser_.back();
  const auto n = static_cast<Eigen::Index>(unknowns_.size());
  Eigen::VectorXf force(n);
  for (Eigen::Index i = 0; i < n; ++i)
    force[i] = level.f.data()[unknowns_[static_cast<std::size_t>(i)]];
  const Eigen::VectorXf moved = Eigen::Map<const Eigen::MatrixXf>(inverse_.data(), n, n) * force;
  for (Eigen::Index i = 0; i < n; ++i)
    level.u.data()[unknowns_[static_cast<std::size_t>(i)]] = moved[i];
}

std::int64_t MaskedMultigrid::bytes() const {
  auto sum = finest_->bytes() + static_cast<std::int64_t>(u.bytes() + f.bytes() + r.bytes()) +
             static_cast<std::int64_t>(inverse_.size() * sizeof(float) + sums_.size() * sizeof(double));
  for (const Level& level : coarser_)
    sum += level.bytes();
  return sum;
}

MaskedGradients::MaskedGradients(MaskedMultigrid& multigrid, ThreadTeam& team)
    : multigrid_(multigrid), team_(team), state_(multigrid.finest().field()),
      direction_(multigrid.finest().field()) {}

void MaskedGradients::restart() {
  std::ranges::fill(state_.all(), 0.0F);
}

std::optional<double> MaskedGradients::find_step(double beta, double product) {
  const MaskedLevel& level = multigrid_.finest();
  float *const p = direction_.data(), *const q = multigrid_.r.data();
  level.for_each_part(team_, [&](std::int64_t at, std::int64_t n, int) {
    direct_entries(n, multigrid_.u.data() + at, static_cast<float>(beta), p + at);
  });
  level.apply(p, q, team_);
  const double curvature = multigrid_.sum_over_parts([&](std::int64_t at, std::int64_t n) {
    return mask_and_dot_entries(n, level.inverse() + at, p + at, q + at);
  });
  return curvature > 0 ? std::optional(product / curvature) : std::nullopt;
}

void MaskedGradients::take_step(double step) {
  const auto length = static_cast<float>(step);
  multigrid_.finest().for_each_part(team_, [&](std::int64_t at, std::int64_t n, int) {
    step_entries(n, -length, direction_.data() + at, state_.data() + at);
    step_entries(n, length, multigrid_.r.data() + at, multigrid_.f.data() + at);
  });
}

} // namespace maille::deform
