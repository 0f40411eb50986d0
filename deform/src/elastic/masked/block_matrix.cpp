#include "elastic/masked/block_matrix.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

constexpr std::int32_t rows_per_item = 64;

/// Rows of the product, gathered block by block.
struct ProductRows {
  List<std::int32_t> length, column;
  List<double> blocks;
};

/// Sums of blocks of one row, wherever its columns are.
class BlockRow {
public:
  explicit BlockRow(std::int32_t n_columns) : place_(static_cast<std::size_t>(n_columns), -1) {}
  double* at(std::int32_t column) {
    std::int32_t& place = place_[static_cast<std::size_t>(column)];
    if (place < 0) {
      place = static_cast<std::int32_t>(columns_.size());
      columns_.push_back(column);
      sums_.resize(sums_.size() + 9, 0);
    }
    return sums_.data() + 9 * static_cast<std::size_t>(place);
  }
  void move_to(ProductRows& rows) {
    std::vector<std::int32_t> order = columns_;
    std::ranges::sort(order);
    for (const std::int32_t column : order) {
      const double* const sum = at(column);
      rows.column.push_back(column);
      rows.blocks.insert(rows.blocks.end(), sum, sum + 9);
    }
    rows.length.push_back(static_cast<std::int32_t>(order.size()));
    for (const std::int32_t column : columns_)
      place_[static_cast<std::size_t>(column)] = -1;
    columns_.clear();
    sums_.clear();
  }

private:
  std::vector<std::int32_t> place_, columns_;
  std::vector<double> sums_;
};

void add_row(const BlockMatrix& A, const Weights& P, const Weights& P_transposed, std::size_t row,
             BlockRow& sums) {
  for (auto i = static_cast<std::size_t>(P_transposed.first[row]);
       i < static_cast<std::size_t>(P_transposed.first[row + 1]); ++i) {
    const auto fine = static_cast<std::size_t>(P_transposed.column[i]);
    const double of_row = double{P_transposed.weight[i]};
    for (auto j = static_cast<std::size_t>(A.first[fine]); j < static_cast<std::size_t>(A.first[fine + 1]);
         ++j) {
      const auto other = static_cast<std::size_t>(A.column[j]);
      const float* const block = A.blocks.data() + 9 * j;
      for (auto k = static_cast<std::size_t>(P.first[other]);
           k < static_cast<std::size_t>(P.first[other + 1]); ++k) {
        double* const sum = sums.at(P.column[k]);
        const double weight = of_row * double{P.weight[k]};
        for (int e = 0; e < 9; ++e)
          sum[e] += weight * double{block[e]};
      }
    }
  }
}

} // namespace

BlockMatrix galerkin_product(const BlockMatrix& A, const Weights& P, const Weights& P_transposed,
                             ThreadTeam& team) {
  const std::int32_t n = P_transposed.n_rows();
  std::vector<ProductRows> parts(static_cast<std::size_t>((n + rows_per_item - 1) / rows_per_item));
  std::vector<BlockRow> sums(static_cast<std::size_t>(team.threads()), BlockRow(n));
  team.run(static_cast<int>(parts.size()), [&](int item, int thread) {
    for (std::int32_t row = item * rows_per_item; row < std::min(n, (item + 1) * rows_per_item); ++row) {
      add_row(A, P, P_transposed, static_cast<std::size_t>(row), sums[static_cast<std::size_t>(thread)]);
      sums[static_cast<std::size_t>(thread)].move_to(parts[static_cast<std::size_t>(item)]);
    }
  });
  BlockMatrix product;
  product.first.push_back(0);
  for (const ProductRows& part : parts) {
    for (const std::int32_t length : part.length)
      product.first.push_back(product.first.back() + length);
    product.column.insert(product.column.end(), part.column.begin(), part.column.end());
  }
  product.blocks = AlignedArray<float>(9 * product.column.size() + 16);
  float* out = product.blocks.data();
  for (const ProductRows& part : parts)
    out =
        std::ranges::transform(part.blocks, out, [](double value) { return static_cast<float>(value); }).out;
  return product;
}

void add_to(BlockMatrix& A, const BlockMatrix& S) {
  for (std::size_t row = 0; row < static_cast<std::size_t>(S.n_rows()); ++row) {
    auto at = static_cast<std::size_t>(A.first[row]);
    for (auto j = static_cast<std::size_t>(S.first[row]); j < static_cast<std::size_t>(S.first[row + 1]);
         ++j) {
      while (A.column[at] < S.column[j])
        ++at;
      for (std::size_t k = 0; k < 9; ++k)
        A.blocks[9 * at + k] += S.blocks[9 * j + k];
    }
  }
}

} // namespace maille::deform
