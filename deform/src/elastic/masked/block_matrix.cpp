#include "elastic/masked/block_matrix.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

namespace maille::deform {

namespace {

/// Some rows of a product.
struct ProductRows {
  List<std::int32_t> length, column;
  List<float> blocks;
};

/// A block has nine numbers; a tenth makes the loop even.
constexpr std::size_t sum_stride = 10;

/// Accumulates the blocks of one row of a product, in any order of columns.
class BlockRow {
public:
  explicit BlockRow(std::int32_t n_columns) : place_(static_cast<std::size_t>(n_columns), -1) {}
  /// Reads ten numbers of `block`.
  template<class Number>
  void add(std::int32_t column, double weight, const Number* block) {
    double* const sum = at(column);
    double product[sum_stride]; // a copy, because the compiler must assume that block and sum overlap
    for (std::size_t e = 0; e < sum_stride; ++e)
      product[e] = weight * double{block[e]};
    for (std::size_t e = 0; e < sum_stride; ++e)
      sum[e] += product[e];
  }
  /// Calls visit(column, sum) for all sums and clears them.
  template<class Visit>
  void empty_into(const Visit& visit) {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      visit(columns_[i], sums_.data() + sum_stride * i);
      place_[columns_[i]] = -1;
    }
    columns_.clear();
    sums_.clear();
  }
  void move_to(ProductRows& rows) {
    order_.resize(columns_.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    std::ranges::sort(order_, {}, [&](std::size_t i) { return columns_[i]; });
    rows.blocks.resize(rows.blocks.size() + 9 * order_.size());
    float* to = rows.blocks.data() + (rows.blocks.size() - 9 * order_.size());
    for (const std::size_t i : order_) {
      rows.column.push_back(columns_[i]);
      const double* const sum = sums_.data() + sum_stride * i;
      for (std::size_t e = 0; e < 9; ++e)
        *to++ = static_cast<float>(sum[e]);
    }
    rows.length.push_back(static_cast<std::int32_t>(order_.size()));
    empty_into([](std::int32_t, const double*) {});
  }

private:
  double* at(std::int32_t column) {
    std::int32_t& place = place_[column];
    if (place < 0) {
      place = static_cast<std::int32_t>(columns_.size());
      columns_.push_back(column);
      sums_.resize(sums_.size() + sum_stride, 0);
    }
    return sums_.data() + sum_stride * static_cast<std::size_t>(place);
  }

  std::vector<std::int32_t> place_, columns_;
  std::vector<double> sums_;
  std::vector<std::size_t> order_;
};

/// First the rows of A, then their columns: so each fine column has one sum.
void add_row(const BlockMatrix& A, const Weights& P, const Weights& P_transposed, std::size_t row,
             BlockRow& of_fine, BlockRow& sums) {
  for (auto i = static_cast<std::size_t>(P_transposed.first[row]);
       i < static_cast<std::size_t>(P_transposed.first[row + 1]); ++i) {
    const auto fine = static_cast<std::size_t>(P_transposed.column[i]);
    const double weight = double{P_transposed.weight[i]};
    for (auto j = static_cast<std::size_t>(A.first[fine]); j < static_cast<std::size_t>(A.first[fine + 1]);
         ++j)
      of_fine.add(A.column[j], weight, A.blocks.data() + 9 * j);
  }
  of_fine.empty_into([&](std::int32_t other, const double* block) {
    for (auto k = static_cast<std::size_t>(P.first[other]);
         k < static_cast<std::size_t>(P.first[static_cast<std::size_t>(other) + 1]); ++k)
      sums.add(P.column[k], double{P.weight[k]}, block);
  });
}

} // namespace

RoundedBlockMatrix rounded(BlockMatrix& A, ThreadTeam& team) {
  constexpr int exponent_of_largest =
      15; // the largest binary16 is 2^15 (2 - 2^-10); so small entries stay normal numbers
  RoundedBlockMatrix B;
  B.scale.resize(A.n_rows());
  constexpr std::size_t padding = line_of_floats / 2;
  B.blocks = AlignedArray<std::uint16_t>(8 * A.column.size() + padding);
  B.last = AlignedArray<std::uint16_t>(A.column.size() + padding);
  const std::int32_t n = A.n_rows();
  team.run((n + rows_per_item - 1) / rows_per_item, [&](int item, int) {
    for (auto row = static_cast<std::size_t>(item * rows_per_item);
         row < static_cast<std::size_t>(std::min(n, (item + 1) * rows_per_item)); ++row) {
      const auto begin = static_cast<std::size_t>(A.first[row]);
      const std::int32_t n_blocks = A.first[row + 1] - A.first[row];
      const float* const blocks = A.blocks.data() + 9 * begin;
      std::int32_t largest = 0; // absolute values are ordered as their bits
      for (std::int32_t i = 0; i < 9 * n_blocks; ++i)
        largest = std::max(largest, std::bit_cast<std::int32_t>(blocks[i]) & 0x7fffffff);
      int exponent = 0;
      std::frexp(std::bit_cast<float>(largest), &exponent);
      B.scale[row] = std::ldexp(1.0F, exponent - exponent_of_largest);
      round_blocks(blocks, n_blocks, B.scale[row], B.blocks.data() + 8 * begin, B.last.data() + begin);
    }
  });
  B.first = std::move(A.first);
  B.column = std::move(A.column);
  return B;
}

BlockMatrix galerkin_product(const BlockMatrix& A, const Weights& P, const Weights& P_transposed,
                             ThreadTeam& team) {
  const std::int32_t n = P_transposed.n_rows();
  std::vector<ProductRows> parts((n + rows_per_item - 1) / rows_per_item);
  std::vector<BlockRow> sums(team.threads(), BlockRow(n)), of_fine(sums.size(), BlockRow(P.n_rows()));
  team.run(static_cast<int>(parts.size()), [&](int item, int thread) {
    for (std::int32_t row = item * rows_per_item; row < std::min(n, (item + 1) * rows_per_item); ++row) {
      const auto of_thread = static_cast<std::size_t>(thread);
      add_row(A, P, P_transposed, static_cast<std::size_t>(row), of_fine[of_thread], sums[of_thread]);
      sums[of_thread].move_to(parts[item]);
    }
    parts[item].blocks.shrink_to_fit();
  });
  BlockMatrix product;
  product.first.reserve(static_cast<std::size_t>(n) + 1);
  product.first.push_back(0);
  for (const ProductRows& part : parts)
    for (const std::int32_t length : part.length)
      product.first.push_back(product.first.back() + length);
  product.column.resize(product.first.back());
  product.blocks = AlignedArray<float>(9 * product.column.size() + 16);
  team.run(static_cast<int>(parts.size()), [&](int item, int) {
    ProductRows& part = parts[item];
    const auto at = static_cast<std::size_t>(
        product.first[static_cast<std::size_t>(item) * static_cast<std::size_t>(rows_per_item)]);
    std::ranges::copy(part.column, product.column.begin() + static_cast<std::ptrdiff_t>(at));
    std::ranges::copy(part.blocks, product.blocks.data() + 9 * at);
    part = {};
  });
  return product;
}

BlockMatrix sum_of(const BlockMatrix& A, const BlockMatrix& B) {
  BlockMatrix sum;
  sum.first.reserve(A.first.size());
  // Calls visit(column, place in A or none, place in B or none).
  constexpr std::size_t none = static_cast<std::size_t>(-1);
  const auto for_each_block_of_row = [&](std::size_t row, const auto& visit) {
    auto i = static_cast<std::size_t>(A.first[row]), j = static_cast<std::size_t>(B.first[row]);
    const auto end_i = static_cast<std::size_t>(A.first[row + 1]),
               end_j = static_cast<std::size_t>(B.first[row + 1]);
    while (i < end_i || j < end_j) {
      const bool takes_a = i < end_i && (j == end_j || A.column[i] <= B.column[j]),
                 takes_b = j < end_j && (i == end_i || B.column[j] <= A.column[i]);
      visit(takes_a ? A.column[i] : B.column[j], takes_a ? i : none, takes_b ? j : none);
      i += takes_a ? 1 : 0;
      j += takes_b ? 1 : 0;
    }
  };
  sum.first.push_back(0);
  for (std::size_t row = 0; row + 1 < A.first.size(); ++row) {
    std::int32_t length = 0;
    for_each_block_of_row(row, [&](std::int32_t, std::size_t, std::size_t) { ++length; });
    sum.first.push_back(sum.first.back() + length);
  }
  sum.column.reserve(sum.first.back());
  sum.blocks = AlignedArray<float>(9 * static_cast<std::size_t>(sum.first.back()) + 16);
  float* out = sum.blocks.data();
  for (std::size_t row = 0; row + 1 < A.first.size(); ++row)
    for_each_block_of_row(row, [&](std::int32_t column, std::size_t a, std::size_t b) {
      sum.column.push_back(column);
      for (std::size_t e = 0; e < 9; ++e)
        out[e] = (a == none ? 0 : A.blocks[9 * a + e]) + (b == none ? 0 : B.blocks[9 * b + e]);
      out += 9;
    });
  return sum;
}

} // namespace maille::deform
