#include "elastic/masked/masked_multigrid.hpp"

#include <cmath>
#include <tuple>

namespace maille::deform {

namespace {

/// One number of a matrix of links.
struct Entry {
  std::int32_t row = 0, column = 0;
  int component = 0;
  double value = 0;
};

/// Of the links alone, where components may move. Rows and columns are slots.
BlockMatrix matrix_of(const std::vector<SlotLink>& links, const MaskedLevel& level) {
  std::vector<Entry> entries;
  entries.reserve(4 * links.size());
  for (const SlotLink& link : links) {
    const float* const inverse = level.inverse() + link.component * level.component_stride();
    for (const std::int32_t row : {link.near, link.far})
      for (const std::int32_t column : {link.near, link.far})
        if (inverse[row] > 0 && inverse[column] > 0)
          entries.push_back({row, column, link.component, row == column ? link.stiffness : -link.stiffness});
  }
  std::ranges::sort(entries, {}, [](const Entry& e) { return std::tuple(e.row, e.column, e.component); });
  BlockMatrix matrix;
  std::size_t n_blocks = 0;
  for (std::size_t i = 0; i < entries.size(); ++i)
    n_blocks += i == 0 || entries[i].row != entries[i - 1].row || entries[i].column != entries[i - 1].column;
  matrix.blocks = AlignedArray<float>(9 * n_blocks + 16);
  matrix.first.assign(static_cast<std::size_t>(level.rows().n_slots()) + 1, 0);
  matrix.column.reserve(n_blocks);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Entry& entry = entries[i];
    if (i == 0 || entry.row != entries[i - 1].row || entry.column != entries[i - 1].column) {
      matrix.column.push_back(entry.column);
      ++matrix.first[static_cast<std::size_t>(entry.row) + 1];
    }
    matrix.blocks[9 * (matrix.column.size() - 1) + 4 * static_cast<std::size_t>(entry.component)] +=
        static_cast<float>(entry.value);
  }
  for (std::size_t row = 1; row < matrix.first.size(); ++row)
    matrix.first[row] += matrix.first[row - 1];
  return matrix;
}

} // namespace

void MaskedMultigrid::Level::forget_penalties() {
  // The last change first, where there are two of one number.
  for (auto change = changed_blocks.rbegin(); change != changed_blocks.rend(); ++change)
    A.blocks[change->first] = change->second;
  for (auto change = changed_inverse.rbegin(); change != changed_inverse.rend(); ++change)
    inverse[change->first] = change->second;
  changed_blocks.clear();
  changed_inverse.clear();
}

/// A += S. A row's diagonal rises by as much of the absolute sum of its row of S as keeps S's eigenvalues
/// over that part below the largest that relaxation was made for (Gershgorin), so those of all are below it
/// too.
/// @pre blocks of S are where A has some
void MaskedMultigrid::Level::set_penalties(const BlockMatrix& S) {
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
        changed_blocks.emplace_back(place, A.blocks[place]);
        A.blocks[place] += value;
        sum[c] += std::abs(double{value});
        diagonal[c] += static_cast<std::size_t>(S.column[j]) == row ? double{value} : 0;
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t place = block_stride * row + c;
      if (!(sum[c] > 0) || !(inverse[place] > 0))
        continue;
      changed_inverse.emplace_back(place, inverse[place]);
      inverse[place] =
          static_cast<float>(1 / (1 / double{inverse[place]} + std::max(diagonal[c], sum[c] / largest)));
    }
  }
}

void MaskedMultigrid::set_penalties(const std::vector<SlotLink>& links) {
  BlockMatrix S = matrix_of(links, *finest_);
  finest_->set_penalties(links, largest_);
  for (Level& level : coarser_) {
    level.forget_penalties();
    S = galerkin_product(S, level.from_here, level.to_here, team_);
    level.set_penalties(S);
  }
  factor_coarsest();
}

} // namespace maille::deform
