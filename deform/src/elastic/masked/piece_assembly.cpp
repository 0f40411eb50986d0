#include "elastic/masked/piece_assembly.hpp"

#include <numeric>

namespace maille::deform {

PieceAssembly::PieceAssembly(const CellComplex& fine, const Coarsened& coarsened)
    : fine_(fine), coarsened_(coarsened) {
  first_.assign(n_pieces() + 1, 0);
  for (const std::int32_t piece : coarsened_.cell_of)
    ++first_[static_cast<std::size_t>(piece) + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  cells_.resize(coarsened_.cell_of.size());
  List<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < cells_.size(); ++i)
    cells_[next[coarsened_.cell_of[i]]++] = static_cast<std::int32_t>(i);
}

Piece PieceAssembly::piece(std::size_t number) const {
  const ComplexCell& coarse = coarsened_.complex.cells[number];
  Piece piece{{coarse.vertex, coarse.vertex + 8}};
  const Weights& P = coarsened_.interpolation;
  for (const std::int32_t cell : cells_of(number))
    for (const std::int32_t vertex : fine_.cells[cell].vertex)
      for (auto k = static_cast<std::size_t>(P.first[vertex]);
           is_hinge(vertex) && k < static_cast<std::size_t>(P.first[static_cast<std::size_t>(vertex) + 1]);
           ++k)
        if (std::ranges::find(piece.vertices, P.column[k]) == piece.vertices.end())
          piece.vertices.push_back(P.column[k]);
  return piece;
}

void PieceAssembly::add_cell(const ComplexCell& cell, const CellMatrix& K, const Piece& piece,
                             PieceMatrix& sum) const {
  const Weights& P = coarsened_.interpolation;
  Eigen::Matrix<double, 24, Eigen::Dynamic> KP =
      Eigen::Matrix<double, 24, Eigen::Dynamic>::Zero(24, sum.cols());
  const auto for_each_weight = [&](const auto& visit) {
    for (int corner = 0; corner < 8; ++corner) {
      const auto vertex = static_cast<std::size_t>(cell.vertex[corner]);
      if (const std::int32_t place = coarsened_.place[vertex]; place >= 0) {
        const PlaceWeights& of = place_weights[place % places_of_piece];
        const std::int32_t* const vertices = coarsened_.complex.cells[place / places_of_piece].vertex;
        for (int i = 0; i < of.size; ++i)
          visit(3 * corner, 3 * piece.local(vertices[of.corner[i]]), double{of.weight[i]});
        continue;
      }
      for (auto k = static_cast<std::size_t>(P.first[vertex]);
           k < static_cast<std::size_t>(P.first[vertex + 1]); ++k)
        visit(3 * corner, 3 * piece.local(P.column[k]), double{P.weight[k]});
    }
  };
  for_each_weight([&](int corner, int local, double weight) {
    KP.middleCols<3>(local) += weight * K.middleCols<3>(corner);
  });
  for_each_weight([&](int corner, int local, double weight) {
    sum.middleRows<3>(local) += weight * KP.middleRows<3>(corner);
  });
}

/// Interpolation is linear along one axis after another. A cell on the lower side has the piece's lower
/// corner as its own and the mean of both as its upper one; on the upper side it is the other way round.
void PieceAssembly::take_to_piece(std::size_t octant, CellMatrix& K) {
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t corner = 0; corner < 8; ++corner) {
      if ((corner >> a & 1) != 0)
        continue;
      const bool is_upper = (octant >> a & 1) != 0;
      const auto lower = static_cast<Eigen::Index>(3 * corner),
                 upper = static_cast<Eigen::Index>(3 * (corner | std::size_t{1} << a)),
                 mean = is_upper ? lower : upper, own = is_upper ? upper : lower;
      K.middleCols<3>(mean) *= 0.5;
      K.middleCols<3>(own) += K.middleCols<3>(mean);
      K.middleRows<3>(mean) *= 0.5;
      K.middleRows<3>(own) += K.middleRows<3>(mean);
    }
}

List<std::size_t> slabs_of(std::span<const std::int32_t> pieces, const List<ComplexCell>& cells, int planes) {
  const int slabs = cells.empty() ? 0 : cells.back().at[2] / planes + 1;
  List<std::size_t> first;
  for (int slab = 0; slab <= slabs; ++slab)
    first.push_back(static_cast<std::size_t>(
        std::ranges::lower_bound(pieces, slab * planes, {}, [&](std::int32_t i) { return cells[i].at[2]; }) -
        pieces.begin()));
  return first;
}

namespace {

/// Pieces by vertex.
struct PiecesOfVertices {
  PiecesOfVertices(const List<Piece>& pieces, std::size_t n_vertices) : first(n_vertices + 1, 0) {
    for (const Piece& piece : pieces)
      for (const std::int32_t v : piece.vertices)
        ++first[static_cast<std::size_t>(v) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    pieces_at.resize(first.back());
    List<std::int32_t> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < pieces.size(); ++i)
      for (const std::int32_t v : pieces[i].vertices)
        pieces_at[next[v]++] = static_cast<std::int32_t>(i);
  }
  std::span<const std::int32_t> at(std::int32_t vertex) const {
    const auto v = static_cast<std::size_t>(vertex);
    return std::span(pieces_at).subspan(first[v], static_cast<std::size_t>(first[v + 1] - first[v]));
  }
  List<std::int32_t> first, pieces_at;
};

/// Columns of some rows of a matrix.
struct ColumnsOfRows {
  List<std::int32_t> length, column;
};

} // namespace

BlockMatrix matrix_for(const List<Piece>& pieces, std::int32_t n_vertices, BlockMatrix others,
                       ThreadTeam& team) {
  const auto n = static_cast<std::size_t>(n_vertices);
  const PiecesOfVertices of_vertices(pieces, n);
  std::vector<ColumnsOfRows> parts((n + rows_per_item - 1) / rows_per_item);
  std::vector<List<std::int32_t>> seen(team.threads(), List<std::int32_t>(n, -1));
  const auto rows_of = [&](std::size_t part) {
    const auto begin = static_cast<std::int32_t>(part) * rows_per_item;
    return std::pair(begin, std::min(n_vertices, begin + rows_per_item));
  };
  team.run(static_cast<int>(parts.size()), [&](int item, int thread) {
    ColumnsOfRows& part = parts[item];
    List<std::int32_t>& seen_by = seen[thread];
    const auto [begin, end] = rows_of(static_cast<std::size_t>(item));
    for (std::int32_t v = begin; v < end; ++v) {
      const std::size_t before = part.column.size();
      const auto add = [&](std::int32_t other) {
        if (std::exchange(seen_by[other], v) != v)
          part.column.push_back(other);
      };
      for (const std::int32_t i : of_vertices.at(v))
        std::ranges::for_each(pieces[i].vertices, add);
      if (!others.column.empty())
        std::for_each(others.column.begin() + others.first[v],
                      others.column.begin() + others.first[static_cast<std::size_t>(v) + 1], add);
      std::sort(part.column.begin() + static_cast<std::ptrdiff_t>(before), part.column.end());
      part.length.push_back(static_cast<std::int32_t>(part.column.size() - before));
    }
  });
  BlockMatrix matrix;
  matrix.first.reserve(n + 1);
  matrix.first.push_back(0);
  for (const ColumnsOfRows& part : parts)
    for (const std::int32_t length : part.length)
      matrix.first.push_back(matrix.first.back() + length);
  matrix.column.resize(matrix.first.back());
  matrix.blocks = AlignedArray<float>(9 * matrix.column.size() + 16);
  team.run(static_cast<int>(parts.size()), [&](int item, int) {
    const auto [begin, end] = rows_of(static_cast<std::size_t>(item));
    std::ranges::copy(parts[item].column, matrix.column.begin() + matrix.first[begin]);
    for (auto v = static_cast<std::size_t>(begin);
         v < static_cast<std::size_t>(end) && !others.column.empty(); ++v) {
      auto at = static_cast<std::size_t>(matrix.first[v]);
      for (auto i = static_cast<std::size_t>(others.first[v]);
           i < static_cast<std::size_t>(others.first[v + 1]); ++i) {
        while (matrix.column[at] < others.column[i])
          ++at;
        std::copy_n(others.blocks.data() + 9 * i, 9, matrix.blocks.data() + 9 * at);
      }
    }
  });
  return matrix;
}

void add_piece(const Piece& piece, const double* local, std::vector<std::size_t>& order,
               BlockMatrix& matrix) {
  const std::size_t n = piece.vertices.size();
  order.resize(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return piece.vertices[i]; });
  for (std::size_t i = 0; i < n; ++i) {
    auto at = static_cast<std::size_t>(matrix.first[piece.vertices[i]]);
    for (const std::size_t j : order) {
      while (matrix.column[at] < piece.vertices[j])
        ++at;
      float* const block = matrix.blocks.data() + 9 * at;
      for (std::size_t b = 0; b < 3; ++b)
        for (std::size_t a = 0; a < 3; ++a)
          block[3 * b + a] += static_cast<float>(local[3 * n * (3 * j + b) + 3 * i + a]);
    }
  }
}

} // namespace maille::deform
