#include "elastic/masked/coarse_operator.hpp"

#include <cstddef>
#include <numeric>
#include <span>

namespace maille::deform {

void PatternedPieces::set_by_pattern(ThreadTeam& team) {
  by_pattern.resize(pieces.size());
  std::iota(by_pattern.begin(), by_pattern.end(), 0);
  team.run(n_slabs(), [&](int slab, int) {
    const auto at = static_cast<std::size_t>(slab);
    std::ranges::stable_sort(
        std::span(by_pattern).subspan(first_of_slab[at], first_of_slab[at + 1] - first_of_slab[at]), {},
        [&](std::int32_t i) { return static_cast<std::uint32_t>(pieces[i].pattern); });
  });
}

CoarseOperator::CoarseOperator(BlockMatrix blocks, PatternedPieces pieces)
    : blocks_(std::move(blocks)), pieces_(std::move(pieces)) {}

void CoarseOperator::round(ThreadTeam& team) {
  rounded_ = rounded(blocks_, team);
  is_rounded_ = true;
}

void CoarseOperator::undo_rounding() {
  blocks_.first = std::move(rounded_.first);
  blocks_.column = std::move(rounded_.column);
  rounded_ = {};
  is_rounded_ = false;
}

/// Calls work(first piece, end) for slabs of planes, as run_slabs() does.
template<class Work>
void CoarseOperator::for_slabs_of_pieces(ThreadTeam& team, const Work& work) const {
  if (has_pieces())
    for_slabs(pieces_.first_of_slab, team, work);
}

void CoarseOperator::copy_diagonal(AlignedArray<float>& to, ThreadTeam& team) const {
  std::ranges::fill(to.all(), 0.0F);
  for_rows(n_rows(), team, [&](std::int32_t first_row, std::int32_t end_row) {
    for (auto row = static_cast<std::size_t>(first_row); row < static_cast<std::size_t>(end_row); ++row) {
      const auto begin = blocks_.column.begin(), end = begin + blocks_.first[row + 1],
                 at = std::lower_bound(begin + blocks_.first[row], end, static_cast<std::int32_t>(row));
      for (std::size_t c = 0; c < 3 && at != end && *at == static_cast<std::int32_t>(row); ++c)
        to[block_stride * row + c] = blocks_.blocks[9 * static_cast<std::size_t>(at - begin) + 4 * c];
    }
  });
  for_slabs_of_pieces(team, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const PatternedPiece& piece = pieces_.pieces[i];
      if (piece.pattern == PatternedPiece::no_pattern)
        continue;
      const float* const matrix =
          pieces_.matrices.data() + static_cast<std::size_t>(piece.pattern) * PatternedPieces::matrix_size;
      for (std::size_t k = 0; k < 8; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          to[block_stride * static_cast<std::size_t>(piece.vertex[k]) + c] +=
              matrix[PatternedPieces::place(3 * k + c, 3 * k + c)];
    }
  });
}

void CoarseOperator::apply(const float* u, float* out, ThreadTeam& team) const {
  for_rows(n_rows(), team, [&](std::int32_t first, std::int32_t end) {
    with_blocks([&](const auto& blocks) { apply_blocks(blocks, first, end, u, out); });
  });
  for_slabs_of_pieces(team,
                      [&](std::size_t first, std::size_t end) { add_pieces(pieces_, first, end, u, out); });
}

} // namespace maille::deform
