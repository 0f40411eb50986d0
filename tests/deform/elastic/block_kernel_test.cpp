/// The loops over coarser levels of bodies of any shape against the obvious ones.

#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/masked_kernel.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "support/vector_targets.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace maille::deform {
namespace {

constexpr std::int32_t n_rows = 52;

/// Rows of 0 to 33 blocks: all that is left over by loops that take several at once.
BlockMatrix random_matrix(std::mt19937& random) {
  BlockMatrix A;
  A.first.push_back(0);
  for (std::int32_t row = 0; row < n_rows; ++row) {
    for (std::int32_t i = 0; i < row % 34; ++i)
      A.column.push_back((row + i) % n_rows);
    A.first.push_back(static_cast<std::int32_t>(A.column.size()));
  }
  A.blocks = AlignedArray<float>(9 * A.column.size() + 16);
  std::uniform_real_distribution<float> value(-1, 1);
  for (std::size_t i = 0; i < 9 * A.column.size(); ++i)
    A.blocks[i] = value(random);
  return A;
}

Weights random_weights(std::mt19937& random, std::int32_t rows) {
  Weights P;
  P.first.push_back(0);
  std::uniform_real_distribution<float> value(0, 1);
  for (std::int32_t row = 0; row < rows; ++row) {
    for (std::int32_t i = 0; i < (row / 5) % 4 * 2; ++i) { // some rows, and some groups of rows, have none
      P.column.push_back((7 * row + i) % n_rows);
      P.weight.push_back(value(random));
    }
    P.first.push_back(static_cast<std::int32_t>(P.column.size()));
  }
  return P;
}

std::vector<float> random_field(std::mt19937& random, std::size_t size) {
  std::uniform_real_distribution<float> value(-1, 1);
  std::vector<float> field(size);
  for (float& entry : field)
    entry = value(random);
  return field;
}

/// Component c of row `row` of A u, in float64.
double product(const BlockMatrix& A, std::int32_t row, std::size_t c, const std::vector<float>& u) {
  double sum = 0;
  for (auto i = static_cast<std::size_t>(A.first[static_cast<std::size_t>(row)]);
       i < static_cast<std::size_t>(A.first[static_cast<std::size_t>(row) + 1]); ++i)
    for (std::size_t b = 0; b < 3; ++b)
      sum += double{A.blocks[9 * i + 3 * b + c]} *
             double{u[block_stride * static_cast<std::size_t>(A.column[i]) + b]};
  return sum;
}

double interpolated(const Weights& P, std::int32_t row, std::size_t c, const std::vector<float>& u) {
  double sum = 0;
  for (auto i = static_cast<std::size_t>(P.first[static_cast<std::size_t>(row)]);
       i < static_cast<std::size_t>(P.first[static_cast<std::size_t>(row) + 1]); ++i)
    sum += double{P.weight[i]} * double{u[block_stride * static_cast<std::size_t>(P.column[i]) + c]};
  return sum;
}

/// Of sums of up to 99 products of numbers below 1; found: below 2e-6.
constexpr double rounding = 1e-5;

TEST(BlockKernelOracle, ProductsResidualsAndStepsAreThoseOfPlainLoops) {
  constexpr unsigned seed = 5;
  std::mt19937 random(seed);
  const BlockMatrix A = random_matrix(random);
  constexpr std::size_t size = block_stride * n_rows;
  const auto u = random_field(random, size), f = random_field(random, size),
             inverse = random_field(random, size);
  constexpr float weight = 0.7F;
  for (const std::int64_t target : tests::vector_targets()) {
    SCOPED_TRACE(target);
    const tests::ForcedVectors forced(target);
    std::vector<float> forces(size), residual(size), next(size);
    apply_blocks(A, 0, n_rows, u.data(), forces.data());
    find_block_residual(A, 0, n_rows, f.data(), u.data(), residual.data());
    relax_blocks(A, 0, n_rows, weight, inverse.data(), f.data(), u.data(), next.data());
    for (std::int32_t row = 0; row < n_rows; ++row)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = block_stride * static_cast<std::size_t>(row) + c;
        const double force = product(A, row, c, u);
        EXPECT_NEAR(double{forces[i]}, force, rounding);
        EXPECT_NEAR(double{residual[i]}, double{f[i]} - force, rounding);
        EXPECT_NEAR(double{next[i]},
                    double{u[i]} + double{weight} * double{inverse[i]} * (double{f[i]} - force), rounding);
      }
  }
}

/// Rows differ by 1e30 in size, and numbers of a row by 1e6.
TEST(BlockKernelOracle, ProductsOfRoundedBlocksAreThoseOfPlainLoopsButForRounding) {
  constexpr unsigned seed = 8;
  std::mt19937 random(seed);
  BlockMatrix A = random_matrix(random);
  for (std::size_t row = 0; row < n_rows; ++row)
    for (auto i = static_cast<std::size_t>(A.first[row]); i < static_cast<std::size_t>(A.first[row + 1]); ++i)
      for (std::size_t e = 0; e < 9; ++e)
        A.blocks[9 * i + e] *= (row % 2 == 0 ? 1e-15F : 1e15F) * (i % 3 == 0 ? 1e-6F : 1);
  const auto rows = A.first, columns = A.column;
  ThreadTeam team(2);
  const RoundedBlockMatrix B = rounded(A, team);
  A.first = rows;
  A.column = columns;
  constexpr std::size_t size = block_stride * n_rows;
  const auto u = random_field(random, size), f = random_field(random, size),
             inverse = random_field(random, size);
  constexpr float weight = 0.7F;
  std::vector<float> first;
  for (const std::int64_t target : tests::vector_targets()) {
    SCOPED_TRACE(target);
    const tests::ForcedVectors forced(target);
    std::vector<float> forces(size), residual(size), next(size);
    apply_blocks(B, 0, n_rows, u.data(), forces.data());
    find_block_residual(B, 0, n_rows, f.data(), u.data(), residual.data());
    relax_blocks(B, 0, n_rows, weight, inverse.data(), f.data(), u.data(), next.data());
    for (std::int32_t row = 0; row < n_rows; ++row)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = block_stride * static_cast<std::size_t>(row) + c;
        double terms = 0; // at their largest
        for (auto k = static_cast<std::size_t>(A.first[static_cast<std::size_t>(row)]);
             k < static_cast<std::size_t>(A.first[static_cast<std::size_t>(row) + 1]); ++k)
          for (std::size_t b = 0; b < 3; ++b)
            terms += std::abs(double{A.blocks[9 * k + 3 * b + c]} *
                              double{u[block_stride * static_cast<std::size_t>(A.column[k]) + b]});
        const double near = terms / 2048 + 1e-6 * terms, force = double{forces[i]};
        EXPECT_NEAR(force, product(A, row, c, u), near);
        EXPECT_NEAR(double{residual[i]}, double{f[i]} - force, 1e-6 * (terms + 1));
        EXPECT_NEAR(double{next[i]},
                    double{u[i]} + double{weight} * double{inverse[i]} * (double{f[i]} - force),
                    1e-6 * (terms + 2));
      }
    for (std::size_t i = 3; i < forces.size(); i += block_stride)
      forces[i] = 0;                                         // does not count
    if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) == 0) // which fuse products with sums
      continue;
    if (first.empty())
      first = forces;
    EXPECT_EQ(forces, first);
  }
}

TEST(BlockKernelOracle, InterpolationIsThatOfPlainLoops) {
  constexpr unsigned seed = 6;
  std::mt19937 random(seed);
  constexpr std::int32_t rows = 72;
  const Weights P = random_weights(random, rows);
  const auto u = random_field(random, block_stride * n_rows);
  const auto before = random_field(random, block_stride * rows);
  for (const std::int64_t target : tests::vector_targets()) {
    SCOPED_TRACE(target);
    const tests::ForcedVectors forced(target);
    auto out = before;
    std::vector<float> alone(block_stride * rows);
    interpolate_blocks(P, 0, rows, u.data(), true, out.data());
    interpolate_blocks(P, 0, rows, u.data(), false, alone.data());
    for (std::int32_t row = 0; row < rows; ++row)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = block_stride * static_cast<std::size_t>(row) + c;
        const double sum = interpolated(P, row, c, u);
        EXPECT_NEAR(double{alone[i]}, sum, rounding);
        EXPECT_NEAR(double{out[i]}, double{before[i]} + sum, rounding);
      }
  }
}

TEST(BlockKernelOracle, NoiseIsThatOfOneEntryAfterAnother) {
  constexpr unsigned seed = 8;
  std::mt19937 random(seed);
  constexpr std::size_t first = 4096, size = 160;
  const auto inverse = random_field(random, size); // half of it below 0: as if fixed
  for (const std::int64_t target : tests::vector_targets()) {
    SCOPED_TRACE(target);
    const tests::ForcedVectors forced(target);
    std::vector<float> noise(size);
    noise_entries(size, first, inverse.data(), noise.data());
    for (std::size_t i = 0; i < size; ++i)
      EXPECT_EQ(noise[i], eigenvalue_noise(first + i, inverse[i])) << i;
  }
}

/// Machines that fuse products with sums, whatever the length of their vectors.
TEST(BlockKernelContract, VectorsOfAnyLengthGiveTheSameBits) {
  constexpr unsigned seed = 7;
  std::mt19937 random(seed);
  const BlockMatrix A = random_matrix(random);
  const auto u = random_field(random, block_stride * n_rows);
  std::vector<float> first;
  for (const std::int64_t target : tests::vector_targets()) {
    if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) == 0)
      continue;
    const tests::ForcedVectors forced(target);
    std::vector<float> forces(block_stride * n_rows);
    apply_blocks(A, 0, n_rows, u.data(), forces.data());
    for (std::size_t i = 3; i < forces.size(); i += block_stride)
      forces[i] = 0; // does not count
    if (first.empty())
      first = forces;
    EXPECT_EQ(forces, first) << target;
  }
}

} // namespace
} // namespace maille::deform
