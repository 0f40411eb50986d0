#include "elastic/masked/masked_level.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace maille::deform {

namespace {

/// Planes of pieces that are added up in one go: those of every second slab share no row, not even at hinges.
constexpr int planes_per_slab = 4;
constexpr std::size_t most_kinds_remembered = 64;

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
    for (std::size_t octant = 0; octant < 8; ++octant)
      regular_[octant] = regular_weights(octant);
    for (std::size_t kind = 0; 8 * kind < remembered_.size(); ++kind)
      for (std::size_t octant = 0; octant < 8; ++octant)
        remembered_[8 * kind + octant] = regular_product(kind, octant);
  }
  std::size_t n_pieces() const { return coarsened_.complex.cells.size(); }
  Piece piece(std::size_t number) const;
  PieceMatrix matrix(std::size_t number, const Piece& piece) const;

private:
  void find_cells();
  CellMatrix cell_matrix_of(std::size_t kind) const {
    return cell_matrix(
        coefficients_of(elasticity_.kinds()[kind], grid_.spacing(), level_.scale(), level_.unit()));
  }
  static Eigen::Matrix<double, 8, 8> regular_weights(std::size_t octant);
  static std::size_t octant(const ComplexCell& cell) {
    return static_cast<std::size_t>(cell.at[0] % 2 + 2 * (cell.at[1] % 2) + 4 * (cell.at[2] % 2));
  }
  CellMatrix regular_product(std::size_t kind, std::size_t octant) const;
  bool is_fixed(std::int32_t slot, int component) const {
    return level_.inverse()[component * level_.component_stride() + slot] == 0;
  }
  bool has_fixed(const ComplexCell& cell) const;
  bool is_regular(const ComplexCell& cell, const Piece& piece) const;
  void add_cell(std::size_t number, const Piece& piece, PieceMatrix& sum) const;

  const MaskedLevel& level_;
  const LatticeElasticity& elasticity_;
  const Grid& grid_;
  const CellComplex& fine_;
  const Coarsened& coarsened_;
  List<std::int32_t> first_, cells_; ///< of pieces
  std::array<Eigen::Matrix<double, 8, 8>, 8> regular_;
  List<CellMatrix> remembered_; ///< products of cells with nothing fixed and no hinge
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
           k < static_cast<std::size_t>(P.first[static_cast<std::size_t>(slot) + 1]); ++k)
        if (std::ranges::find(piece.vertices, P.column[k]) == piece.vertices.end())
          piece.vertices.push_back(P.column[k]);
  return piece;
}

PieceMatrix CellProducts::matrix(std::size_t number, const Piece& piece) const {
  const auto n = static_cast<Eigen::Index>(3 * piece.vertices.size());
  PieceMatrix sum = PieceMatrix::Zero(n, n);
  for (auto i = static_cast<std::size_t>(first_[number]); i < static_cast<std::size_t>(first_[number + 1]);
       ++i)
    add_cell(static_cast<std::size_t>(cells_[i]), piece, sum);
  return sum;
}

bool CellProducts::has_fixed(const ComplexCell& cell) const {
  for (const std::int32_t slot : cell.vertex)
    for (int c = 0; c < 3; ++c)
      if (is_fixed(slot, c))
        return true;
  return false;
}

/// True if the cell's corners are interpolated from the eight vertices of its piece alone.
bool CellProducts::is_regular(const ComplexCell& cell, const Piece& piece) const {
  const Weights& P = coarsened_.interpolation;
  const Eigen::Matrix<double, 8, 8>& expected = regular_[octant(cell)];
  for (int corner = 0; corner < 8; ++corner) {
    const auto slot = static_cast<std::size_t>(cell.vertex[corner]);
    double sum = 0;
    for (auto k = static_cast<std::size_t>(P.first[slot]); k < static_cast<std::size_t>(P.first[slot + 1]);
         ++k) {
      const std::int32_t local = piece.local(P.column[k]);
      if (local >= 8 || expected(corner, local) != double{P.weight[k]})
        return false;
      sum += double{P.weight[k]};
    }
    if (sum != 1)
      return false;
  }
  return true;
}

void CellProducts::add_cell(std::size_t number, const Piece& piece, PieceMatrix& sum) const {
  const ComplexCell& cell = fine_.cells[number];
  const auto kind = static_cast<std::size_t>(elasticity_.kind_number(grid_.cell(cell.at)));
  const double of_cell = elasticity_.weight(grid_.cell(cell.at));
  if (!remembered_.empty() && is_regular(cell, piece) && !has_fixed(cell)) {
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
  List<List<std::int32_t>> pieces_at(n);
  for (std::size_t i = 0; i < pieces.size(); ++i)
    for (const std::int32_t v : pieces[i].vertices)
      pieces_at[static_cast<std::size_t>(v)].push_back(static_cast<std::int32_t>(i));
  BlockMatrix matrix;
  matrix.first.push_back(0);
  std::vector<std::int32_t> row;
  for (const auto& around : pieces_at) {
    row.clear();
    for (const std::int32_t i : around) {
      const auto& vertices = pieces[static_cast<std::size_t>(i)].vertices;
      row.insert(row.end(), vertices.begin(), vertices.end());
    }
    std::ranges::sort(row);
    row.erase(std::unique(row.begin(), row.end()), row.end());
    matrix.column.insert(matrix.column.end(), row.begin(), row.end());
    matrix.first.push_back(static_cast<std::int32_t>(matrix.column.size()));
  }
  matrix.blocks = AlignedArray<float>(9 * matrix.column.size() + 16);
  return matrix;
}

void add_piece(const Piece& piece, const PieceMatrix& local, BlockMatrix& matrix) {
  for (std::size_t i = 0; i < piece.vertices.size(); ++i) {
    const auto row = static_cast<std::size_t>(piece.vertices[i]);
    const auto begin = matrix.column.begin() + matrix.first[row],
               end = matrix.column.begin() + matrix.first[row + 1];
    for (std::size_t j = 0; j < piece.vertices.size(); ++j) {
      const auto at = std::lower_bound(begin, end, piece.vertices[j]) - matrix.column.begin();
      float* const block = matrix.blocks.data() + 9 * at;
      for (int b = 0; b < 3; ++b)
        for (int a = 0; a < 3; ++a)
          block[3 * b + a] += static_cast<float>(
              local(static_cast<Eigen::Index>(3 * i) + a, static_cast<Eigen::Index>(3 * j) + b));
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
      for (std::size_t i = first_of_slab(slab); i < first_of_slab(slab + 1); ++i)
        add_piece(pieces[i], products.matrix(i, pieces[i]), matrix);
    });
  return matrix;
}

} // namespace maille::deform
