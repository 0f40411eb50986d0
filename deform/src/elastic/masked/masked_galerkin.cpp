#include "elastic/masked/masked_level.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Planes of pieces that are added up in one go: those of every second slab share no row, not even at hinges.
constexpr int planes_per_slab = 4;
constexpr std::size_t most_kinds_remembered = 64;
/// Of cells in a block; of the commonest kind the sums over each are remembered, too: 4.6 KB each.
constexpr std::size_t n_patterns = 256;

/// Which coarse vertices the fine ones of a piece are interpolated from.
struct Piece {
  List<std::int32_t> vertices; ///< its own eight first
  std::int32_t local(std::int32_t vertex) const {
    return static_cast<std::int32_t>(std::ranges::find(vertices, vertex) - vertices.begin());
  }
};

/// Rows and columns: 3 local vertex + component.
using PieceMatrix = Eigen::MatrixXd;

class CellProducts {
public:
  CellProducts(const MaskedLevel& level, const LatticeElasticity& elasticity, const Grid& grid,
               const CellComplex& fine, const Coarsened& coarsened)
      : level_(level), elasticity_(elasticity), grid_(grid), fine_(fine), coarsened_(coarsened),
        remembered_(elasticity.kinds().size() <= most_kinds_remembered ? 8 * elasticity.kinds().size() : 0) {
    find_cells();
    find_plain_slots();
    for (std::size_t octant = 0; octant < 8; ++octant)
      regular_[octant] = regular_weights(octant);
    for (std::size_t kind = 0; 8 * kind < remembered_.size(); ++kind)
      for (std::size_t octant = 0; octant < 8; ++octant)
        remembered_[8 * kind + octant] = regular_product(kind, octant);
    if (!remembered_.empty() && !elasticity.has_weights())
      sum_up_patterns();
  }
  std::size_t n_pieces() const { return coarsened_.complex.cells.size(); }
  Piece piece(std::size_t number) const;
  /// Column after column. @param sum memory for pieces that no pattern is known of
  const double* matrix(std::size_t number, const Piece& piece, PieceMatrix& sum) const;

private:
  void find_cells();
  void find_plain_slots();
  void sum_up_patterns();
  const CellMatrix* remembered_pattern(std::size_t number) const;
  CellMatrix cell_matrix_of(std::size_t kind) const {
    return cell_matrix(
        coefficients_of(elasticity_.kinds()[kind], grid_.spacing(), level_.scale(), level_.unit()));
  }
  std::size_t kind_of(const ComplexCell& cell) const {
    return static_cast<std::size_t>(elasticity_.kind_number(grid_.cell(cell.at)));
  }
  static Eigen::Matrix<double, 8, 8> regular_weights(std::size_t octant);
  static std::size_t octant(const ComplexCell& cell) {
    return static_cast<std::size_t>(cell.at[0] % 2 + 2 * (cell.at[1] % 2) + 4 * (cell.at[2] % 2));
  }
  CellMatrix regular_product(std::size_t kind, std::size_t octant) const;
  bool is_fixed(std::int32_t slot, int component) const {
    return level_.inverse()[component * level_.component_stride() + slot] == 0;
  }
  bool is_hinge(std::int32_t slot) const { return coarsened_.is_hinge[static_cast<std::size_t>(slot)] != 0; }
  bool is_plain(const ComplexCell& cell) const {
    return std::ranges::all_of(
        cell.vertex, [&](std::int32_t slot) { return is_plain_[static_cast<std::size_t>(slot)] != 0; });
  }
  void add_cell(std::size_t number, const Piece& piece, PieceMatrix& sum) const;

  const MaskedLevel& level_;
  const LatticeElasticity& elasticity_;
  const Grid& grid_;
  const CellComplex& fine_;
  const Coarsened& coarsened_;
  List<std::int32_t> first_, cells_; ///< of pieces
  std::array<Eigen::Matrix<double, 8, 8>, 8> regular_;
  List<std::uint8_t> is_plain_;  ///< per slot: nothing fixed, interpolated from one piece's vertices alone
  List<CellMatrix> remembered_;  ///< products of plain cells
  std::size_t commonest_ = 0;    ///< kind
  List<CellMatrix> of_patterns_; ///< their sums for that kind, by the bits of cells in a block; or empty
};

void CellProducts::find_cells() {
  first_.assign(n_pieces() + 1, 0);
  for (const std::int32_t piece : coarsened_.cell_of)
    ++first_[static_cast<std::size_t>(piece) + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  cells_.resize(coarsened_.cell_of.size());
  std::vector<std::int32_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < cells_.size(); ++i)
    cells_[static_cast<std::size_t>(next[static_cast<std::size_t>(coarsened_.cell_of[i])]++)] =
        static_cast<std::int32_t>(i);
}

/// Of the corners of a cell (rows) from those of the coarse cell that it is an eighth of.
Eigen::Matrix<double, 8, 8> CellProducts::regular_weights(std::size_t octant) {
  Eigen::Matrix<double, 8, 8> weights;
  for (std::size_t corner = 0; corner < 8; ++corner)
    for (std::size_t k = 0; k < 8; ++k) {
      double weight = 1;
      for (std::size_t a = 0; a < 3; ++a) {
        const double along = 0.5 * static_cast<double>((octant >> a & 1) + (corner >> a & 1));
        weight *= (k >> a & 1) != 0 ? along : 1 - along;
      }
      weights(static_cast<Eigen::Index>(corner), static_cast<Eigen::Index>(k)) = weight;
    }
  return weights;
}

CellMatrix CellProducts::regular_product(std::size_t kind, std::size_t octant) const {
  const Eigen::Matrix<double, 8, 8>& weights = regular_[octant];
  CellMatrix P = CellMatrix::Zero();
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      for (int c = 0; c < 3; ++c)
        P(3 * i + c, 3 * j + c) = weights(i, j);
  return P.transpose() * (cell_matrix_of(kind) * P).eval();
}

Piece CellProducts::piece(std::size_t number) const {
  const ComplexCell& coarse = coarsened_.complex.cells[number];
  Piece piece{{coarse.vertex, coarse.vertex + 8}};
  const Weights& P = coarsened_.interpolation;
  for (auto i = static_cast<std::size_t>(first_[number]); i < static_cast<std::size_t>(first_[number + 1]);
       ++i)
    for (const std::int32_t slot : fine_.cells[static_cast<std::size_t>(cells_[i])].vertex)
      for (auto k = static_cast<std::size_t>(P.first[static_cast<std::size_t>(slot)]);
           is_hinge(slot) && k < static_cast<std::size_t>(P.first[static_cast<std::size_t>(slot) + 1]); ++k)
        if (std::ranges::find(piece.vertices, P.column[k]) == piece.vertices.end())
          piece.vertices.push_back(P.column[k]);
  return piece;
}

void CellProducts::find_plain_slots() {
  is_plain_.assign(coarsened_.is_hinge.size(), 0);
  for (std::size_t slot = 0; slot < is_plain_.size(); ++slot) {
    const auto at = static_cast<std::int32_t>(slot);
    is_plain_[slot] = !is_hinge(at) && !is_fixed(at, 0) && !is_fixed(at, 1) && !is_fixed(at, 2);
  }
}

void CellProducts::sum_up_patterns() {
  std::vector<std::int64_t> cells_of_kind(elasticity_.kinds().size(), 0);
  for (const ComplexCell& cell : fine_.cells)
    ++cells_of_kind[kind_of(cell)];
  commonest_ = static_cast<std::size_t>(std::ranges::max_element(cells_of_kind) - cells_of_kind.begin());
  of_patterns_.assign(n_patterns, CellMatrix::Zero());
  for (std::size_t pattern = 1; pattern < n_patterns; ++pattern) {
    const auto octant = static_cast<std::size_t>(std::countr_zero(pattern));
    of_patterns_[pattern] =
        of_patterns_[pattern ^ std::size_t{1} << octant] + remembered_[8 * commonest_ + octant];
  }
}

/// Of a piece whose cells are all plain and of the commonest kind.
const CellMatrix* CellProducts::remembered_pattern(std::size_t number) const {
  if (of_patterns_.empty())
    return nullptr;
  std::size_t pattern = 0;
  for (auto i = static_cast<std::size_t>(first_[number]); i < static_cast<std::size_t>(first_[number + 1]);
       ++i) {
    const ComplexCell& cell = fine_.cells[static_cast<std::size_t>(cells_[i])];
    if (!is_plain(cell) || kind_of(cell) != commonest_)
      return nullptr;
    pattern |= std::size_t{1} << octant(cell);
  }
  return &of_patterns_[pattern];
}

const double* CellProducts::matrix(std::size_t number, const Piece& piece, PieceMatrix& sum) const {
  if (const CellMatrix* const known = remembered_pattern(number))
    return known->data();
  const auto n = static_cast<Eigen::Index>(3 * piece.vertices.size());
  sum.setZero(n, n);
  for (auto i = static_cast<std::size_t>(first_[number]); i < static_cast<std::size_t>(first_[number + 1]);
       ++i)
    add_cell(static_cast<std::size_t>(cells_[i]), piece, sum);
  return sum.data();
}

void CellProducts::add_cell(std::size_t number, const Piece& piece, PieceMatrix& sum) const {
  const ComplexCell& cell = fine_.cells[number];
  const std::size_t kind = kind_of(cell);
  const double of_cell = elasticity_.weight(grid_.cell(cell.at));
  if (!remembered_.empty() && is_plain(cell)) {
    sum.topLeftCorner<24, 24>() += of_cell * remembered_[8 * kind + octant(cell)];
    return;
  }
  CellMatrix K = of_cell * cell_matrix_of(kind);
  for (int i = 0; i < 24; ++i)
    if (is_fixed(cell.vertex[i / 3], i % 3)) {
      K.row(i).setZero();
      K.col(i).setZero();
    }
  const Weights& P = coarsened_.interpolation;
  Eigen::Matrix<double, 24, Eigen::Dynamic> KP =
      Eigen::Matrix<double, 24, Eigen::Dynamic>::Zero(24, sum.cols());
  const auto for_each_weight = [&](const auto& visit) {
    for (int corner = 0; corner < 8; ++corner) {
      const auto slot = static_cast<std::size_t>(cell.vertex[corner]);
      for (auto k = static_cast<std::size_t>(P.first[slot]); k < static_cast<std::size_t>(P.first[slot + 1]);
           ++k)
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

/// Which blocks there are: pairs of vertices of one piece.
BlockMatrix empty_matrix(const List<Piece>& pieces, std::int32_t n_vertices) {
  const auto n = static_cast<std::size_t>(n_vertices);
  List<std::int32_t> first(n + 1, 0), pieces_at;
  for (const Piece& piece : pieces)
    for (const std::int32_t v : piece.vertices)
      ++first[static_cast<std::size_t>(v) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  pieces_at.resize(static_cast<std::size_t>(first.back()));
  List<std::int32_t> next(first.begin(), first.end() - 1);
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (const std::int32_t v : pieces[i].vertices)
      pieces_at[static_cast<std::size_t>(next[static_cast<std::size_t>(v)]++)] = static_cast<std::int32_t>(i);
  BlockMatrix matrix;
  matrix.first.push_back(0);
  List<std::int32_t> seen_by(n, -1), row;
  for (std::int32_t v = 0; v < n_vertices; ++v) {
    row.clear();
    for (std::int32_t i = first[static_cast<std::size_t>(v)]; i < first[static_cast<std::size_t>(v) + 1]; ++i)
      for (const std::int32_t other :
           pieces[static_cast<std::size_t>(pieces_at[static_cast<std::size_t>(i)])].vertices)
        if (std::exchange(seen_by[static_cast<std::size_t>(other)], v) != v)
          row.push_back(other);
    std::ranges::sort(row);
    matrix.column.insert(matrix.column.end(), row.begin(), row.end());
    matrix.first.push_back(static_cast<std::int32_t>(matrix.column.size()));
  }
  matrix.blocks = AlignedArray<float>(9 * matrix.column.size() + 16);
  return matrix;
}

/// @param local column after column @param order memory
void add_piece(const Piece& piece, const double* local, std::vector<std::size_t>& order,
               BlockMatrix& matrix) {
  const std::size_t n = piece.vertices.size();
  order.resize(n);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return piece.vertices[i]; });
  for (std::size_t i = 0; i < n; ++i) {
    auto at = static_cast<std::size_t>(matrix.first[static_cast<std::size_t>(piece.vertices[i])]);
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

} // namespace

BlockMatrix MaskedLevel::galerkin_product(const CellComplex& fine, const Coarsened& coarsened,
                                          ThreadTeam& team) const {
  const CellProducts products(*this, elasticity_, scene_.specimen.grid, fine, coarsened);
  const auto& cells = coarsened.complex.cells;
  List<Piece> pieces(products.n_pieces());
  const int planes = cells.empty() ? 0 : cells.back().at[2] + 1,
            slabs = (planes + planes_per_slab - 1) / planes_per_slab;
  const auto first_of_slab = [&](int slab) {
    return static_cast<std::size_t>(std::ranges::lower_bound(cells, slab * planes_per_slab, {},
                                                             [](const ComplexCell& c) { return c.at[2]; }) -
                                    cells.begin());
  };
  team.run(slabs, [&](int slab, int) {
    for (std::size_t i = first_of_slab(slab); i < first_of_slab(slab + 1); ++i)
      pieces[i] = products.piece(i);
  });
  BlockMatrix matrix = empty_matrix(pieces, coarsened.complex.n_vertices);
  for (const int parity : {0, 1})
    team.run((slabs - parity + 1) / 2, [&](int item, int) {
      const int slab = 2 * item + parity;
      PieceMatrix sum;
      std::vector<std::size_t> order;
      for (std::size_t i = first_of_slab(slab); i < first_of_slab(slab + 1); ++i)
        add_piece(pieces[i], products.matrix(i, pieces[i], sum), order, matrix);
    });
  return matrix;
}

} // namespace maille::deform
