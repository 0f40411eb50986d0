#include "elastic/masked/masked_level.hpp"
#include "elastic/masked/piece_assembly.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Kinds of material in patterns, which store a byte per cell; 0 is empty.
constexpr std::size_t most_kinds_remembered = 64;
/// If fewer than one kind in this number is thin, a table for thin cells costs more than it saves.
constexpr std::size_t worth_table_of_thin = 6;

/// The contribution of a plain cell to its piece is linear in the coefficients of the cell. This table has
/// the contribution of each coefficient, by octant. It is split by pairs of components, because each pair
/// depends on fewer than half of the coefficients; each pair stores its 8 x 8 corners.
class LinearProducts {
public:
  static constexpr std::pair<int, int> components[] = {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}};
  using OfPair = Eigen::Matrix<float, 8, 8>;
  static constexpr std::size_t n_pairs = std::size(components), pair_size = OfPair::SizeAtCompileTime;
  using Sum = std::array<double, n_pairs * pair_size>;

  LinearProducts() = default;
  LinearProducts(int n_coefficients, ThreadTeam& team) {
    List<CellMatrix> of_one(static_cast<std::size_t>(n_coefficients));
    for (std::size_t k = 0; k < of_one.size(); ++k) {
      CellCoefficients one{};
      one[k] = 1;
      of_one[k] = cell_matrix(one);
      for (std::size_t pair = 0; pair < n_pairs; ++pair)
        if (!of_pair(of_one[k], pair).isZero(0))
          pairs_[pair].coefficients.push_back(k);
    }
    for (Pair& pair : pairs_) {
      pair.first = size_;
      size_ += pair.coefficients.size() * pair_size;
    }
    tables_.resize(8 * size_);
    team.run(8, [&](int octant, int) {
      List<CellMatrix> of_piece = of_one;
      for (CellMatrix& K : of_piece)
        PieceAssembly::take_to_piece(static_cast<std::size_t>(octant), K);
      float* to = tables_.data() + static_cast<std::size_t>(octant) * size_;
      for (std::size_t pair = 0; pair < n_pairs; ++pair)
        for (const std::size_t k : pairs_[pair].coefficients) {
          const OfPair numbers = of_pair(of_piece[k], pair).cast<float>(); // multiples of 2^-8: exact
          to = std::copy_n(numbers.data(), pair_size, to);
        }
    });
  }
  bool is_empty() const { return tables_.empty(); }
  /// @param n coefficients, the others are 0
  void add_cell(std::size_t octant, const CellCoefficients& c, int n, Sum& sum) const {
    const float* const tables = tables_.data() + octant * size_;
    CellCoefficients of_pair;
    for (std::size_t i = 0; i < n_pairs; ++i) {
      int n_of_pair = 0;
      for (const std::size_t k : pairs_[i].coefficients)
        if (k < static_cast<std::size_t>(n)) // they ascend
          of_pair[n_of_pair++] = c[k];
      add_columns(pair_size, n_of_pair, tables + pairs_[i].first, of_pair.data(), sum.data() + i * pair_size);
    }
  }
  static void add_to(PieceMatrix& matrix, const Sum& sum) {
    for (std::size_t pair = 0; pair < n_pairs; ++pair) {
      const Eigen::Map<const Eigen::Matrix<double, 8, 8>> of_pair(sum.data() + pair * pair_size);
      const auto [a, b] = components[pair];
      for (Eigen::Index j = 0; j < 8; ++j)
        for (Eigen::Index i = 0; i < 8; ++i) {
          matrix(3 * i + a, 3 * j + b) += of_pair(i, j);
          if (a != b)
            matrix(3 * j + b, 3 * i + a) += of_pair(i, j);
        }
    }
  }

private:
  static Eigen::Matrix<double, 8, 8> of_pair(const CellMatrix& K, std::size_t pair) {
    const auto [a, b] = components[pair];
    return K(Eigen::seqN(a, 8, 3), Eigen::seqN(b, 8, 3));
  }

  struct Pair {
    List<std::size_t> coefficients; ///< those that are not nothing there
    std::size_t first = 0;          ///< in the table of an eighth
  };
  std::array<Pair, n_pairs> pairs_;
  std::size_t size_ = 0; ///< of a table
  List<float> tables_;   ///< [octant][pair][coefficient][entry]
};

class CellProducts {
public:
  CellProducts(const MaskedLevel& level, const CellComplex& fine, const Coarsened& coarsened,
               ThreadTeam& team);
  /// Kinds of material in the eighths of a piece without fixed vertices or hinges; 0 for other pieces.
  std::uint64_t pattern(std::size_t piece) const;
  CellMatrix matrix(std::uint64_t pattern) const;
  /// The matrix of a piece, column by column, in the memory of `sum`.
  const double* matrix(std::size_t number, const Piece& piece, PieceMatrix& sum) const;

  PieceAssembly assembly;

private:
  void find_plain_slots(ThreadTeam& team);
  CellCoefficients coefficients(std::size_t kind) const {
    return level_.matter().coefficients_of(elasticity_.kinds()[kind]);
  }
  std::size_t kind_of(const ComplexCell& cell) const {
    return static_cast<std::size_t>(elasticity_.kind_number(grid_.cell(cell.at)));
  }
  bool is_fixed(std::int32_t slot, int component) const {
    return level_.inverse()[component * level_.component_stride() + slot] == 0;
  }
  bool is_plain(const ComplexCell& cell) const {
    return std::ranges::all_of(cell.vertex, [&](std::int32_t slot) { return is_plain_[slot] != 0; });
  }
  void add_cell(const ComplexCell& cell, const Piece& piece, PieceMatrix& sum) const;

  const MaskedLevel& level_;
  const LatticeElasticity& elasticity_;
  const Grid& grid_;
  const CellComplex& fine_;
  List<std::uint8_t> is_plain_;    ///< per slot: nothing fixed, interpolated from one piece's vertices alone
  List<CellMatrix> of_kind_;       ///< where kinds are few
  List<CellMatrix> remembered_;    ///< products of plain cells, by kind and octant
  LinearProducts of_coefficients_; ///< of plain cells, where kinds are many
  bool takes_thin_ = true;         ///< of_coefficients_, also the cells whose matter is thin
};

CellProducts::CellProducts(const MaskedLevel& level, const CellComplex& fine, const Coarsened& coarsened,
                           ThreadTeam& team)
    : assembly(fine, coarsened), level_(level), elasticity_(level.matter().elasticity()),
      grid_(level.matter().scene().specimen.grid), fine_(fine) {
  find_plain_slots(team);
  if (elasticity_.n_kinds() > most_kinds_remembered) {
    const auto thin = static_cast<std::size_t>(
        std::ranges::count_if(elasticity_.kinds(), [](const auto& kind) { return kind.thin != 0; }));
    takes_thin_ = thin > elasticity_.kinds().size() / worth_table_of_thin;
    of_coefficients_ = LinearProducts(MaskedOperator::coefficients_of(takes_thin_), team);
    return;
  }
  of_kind_.resize(elasticity_.kinds().size());
  remembered_.resize(8 * of_kind_.size());
  team.run(static_cast<int>(of_kind_.size()), [&](int item, int) {
    const auto kind = static_cast<std::size_t>(item);
    of_kind_[kind] = cell_matrix(coefficients(kind));
    for (std::size_t octant = 0; octant < 8; ++octant)
      PieceAssembly::take_to_piece(octant, remembered_[8 * kind + octant] = of_kind_[kind]);
  });
}

void CellProducts::find_plain_slots(ThreadTeam& team) {
  is_plain_.resize(fine_.n_vertices);
  for_parts(is_plain_.size(), team, [&](std::size_t first, std::size_t end, std::size_t) {
    for (auto slot = static_cast<std::int32_t>(first); slot < static_cast<std::int32_t>(end); ++slot)
      is_plain_[slot] =
          !assembly.is_hinge(slot) && !is_fixed(slot, 0) && !is_fixed(slot, 1) && !is_fixed(slot, 2);
  });
}

std::uint64_t CellProducts::pattern(std::size_t piece) const {
  if (remembered_.empty() || elasticity_.has_weights())
    return 0;
  std::uint64_t pattern = 0;
  for (const std::int32_t number : assembly.cells_of(piece)) {
    const ComplexCell& cell = fine_.cells[number];
    if (!is_plain(cell))
      return 0;
    pattern |= std::uint64_t{kind_of(cell) + 1} << 8 * PieceAssembly::octant(cell);
  }
  return pattern;
}

CellMatrix CellProducts::matrix(std::uint64_t pattern) const {
  CellMatrix sum = CellMatrix::Zero();
  for (std::size_t octant = 0; octant < 8; ++octant)
    if (const std::size_t kind = pattern >> 8 * octant & 0xff; kind > 0)
      sum += remembered_[8 * (kind - 1) + octant];
  return sum;
}

const double* CellProducts::matrix(std::size_t number, const Piece& piece, PieceMatrix& sum) const {
  const auto n = static_cast<Eigen::Index>(3 * piece.vertices.size());
  sum.setZero(n, n);
  LinearProducts::Sum of_plain{};
  for (const std::int32_t i : assembly.cells_of(number)) {
    const ComplexCell& cell = fine_.cells[i];
    const std::size_t kind = kind_of(cell);
    if (of_coefficients_.is_empty() || !is_plain(cell) ||
        (!takes_thin_ && elasticity_.kinds()[kind].thin != 0)) {
      add_cell(cell, piece, sum);
      continue;
    }
    CellCoefficients c = coefficients(kind);
    for (double& coefficient : c)
      coefficient *= elasticity_.weight(grid_.cell(cell.at));
    of_coefficients_.add_cell(PieceAssembly::octant(cell), c,
                              MaskedOperator::coefficients_of(elasticity_.kinds()[kind].thin != 0), of_plain);
  }
  if (!of_coefficients_.is_empty())
    LinearProducts::add_to(sum, of_plain);
  return sum.data();
}

void CellProducts::add_cell(const ComplexCell& cell, const Piece& piece, PieceMatrix& sum) const {
  const std::size_t kind = kind_of(cell);
  const double of_cell = elasticity_.weight(grid_.cell(cell.at));
  if (is_plain(cell) && !remembered_.empty()) {
    sum.topLeftCorner<24, 24>() += of_cell * remembered_[8 * kind + PieceAssembly::octant(cell)];
    return;
  }
  CellMatrix K = of_cell * (of_kind_.empty() ? cell_matrix(coefficients(kind)) : of_kind_[kind]);
  for (int i = 0; i < 24; ++i)
    if (is_fixed(cell.vertex[i / 3], i % 3)) {
      K.row(i).setZero();
      K.col(i).setZero();
    }
  if (std::ranges::none_of(cell.vertex, [&](std::int32_t slot) { return assembly.is_hinge(slot); })) {
    PieceAssembly::take_to_piece(PieceAssembly::octant(cell), K);
    sum.topLeftCorner<24, 24>() += K;
    return;
  }
  assembly.add_cell(cell, K, piece, sum);
}

/// Stores a matrix in the layout of PatternedPieces.
void put_matrix(const CellMatrix& K, float* out) {
  for (std::size_t j = 0; j < 24; ++j)
    for (std::size_t i = 0; i < 24; ++i)
      out[PatternedPieces::place(i, j)] =
          static_cast<float>(K(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)));
}

CellMatrix matrix_of(const PatternedPieces& known, std::int32_t pattern) {
  const float* const from =
      known.matrices.data() + static_cast<std::size_t>(pattern) * PatternedPieces::matrix_size;
  CellMatrix K;
  for (std::size_t j = 0; j < 24; ++j)
    for (std::size_t i = 0; i < 24; ++i)
      K(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          double{from[PatternedPieces::place(i, j)]};
  return K;
}

/// Cache of P^T K P for patterns by octant: the most frequent ones, limited to a small part of the memory of
/// the pieces.
class ProductsOfPatterns {
public:
  ProductsOfPatterns(const PatternedPieces& known, const CellComplex& fine, std::size_t n_pieces,
                     ThreadTeam& team)
      : known_(known), place_(8 * (known.matrices.size() / PatternedPieces::matrix_size), -1) {
    std::vector<std::int32_t> uses(place_.size(), 0);
    for (std::size_t i = 0; i < known.pieces.size(); ++i)
      if (const std::int32_t pattern = known.pieces[i].pattern; pattern != PatternedPiece::no_pattern)
        ++uses[8 * static_cast<std::size_t>(pattern) + PieceAssembly::octant(fine.cells[i])];
    std::vector<std::size_t> order(uses.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return uses[i]; });
    order.resize(std::min(order.size(), n_pieces / 32));
    products_.resize(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
      place_[order[i]] = static_cast<std::int32_t>(i);
    team.run(static_cast<int>(order.size()), [&](int item, int) {
      const auto i = static_cast<std::size_t>(item);
      products_[i] = product(static_cast<std::int32_t>(order[i] / 8), order[i] % 8).cast<float>();
    });
  }
  void add_to(PieceMatrix& sum, std::int32_t pattern, std::size_t octant) const {
    const std::int32_t place = place_[8 * static_cast<std::size_t>(pattern) + octant];
    if (place < 0)
      sum.topLeftCorner<24, 24>() += product(pattern, octant);
    else
      sum.topLeftCorner<24, 24>() += products_[place].cast<double>();
  }

private:
  CellMatrix product(std::int32_t pattern, std::size_t octant) const {
    CellMatrix K = matrix_of(known_, pattern);
    PieceAssembly::take_to_piece(octant, K);
    return K;
  }

  const PatternedPieces& known_;
  List<std::int32_t> place_; ///< per pattern and octant: in products_
  List<Eigen::Matrix<float, 24, 24>> products_;
};

/// Frequent patterns, in the order of first use; none if most pieces have rare patterns.
List<std::uint64_t> common_patterns(const List<std::uint64_t>& of_piece) {
  std::unordered_map<std::uint64_t, std::int32_t> uses;
  List<std::uint64_t> patterns;
  for (const std::uint64_t pattern : of_piece)
    if (pattern != 0 && ++uses[pattern] == fewest_pieces_of_a_pattern)
      patterns.push_back(pattern);
  std::size_t n_alike = 0;
  for (const std::uint64_t pattern : patterns)
    n_alike += static_cast<std::size_t>(uses[pattern]);
  return 2 * n_alike < of_piece.size() ? List<std::uint64_t>() : patterns;
}

} // namespace

CoarseOperator galerkin_product(const MaskedLevel& level, const CellComplex& fine, const Coarsened& coarsened,
                                bool by_patterns, ThreadTeam& team) {
  return galerkin_product(level, fine, coarsened, nullptr, by_patterns, team, coarsened.complex.cells,
                          nullptr);
}

CoarseOperator galerkin_product(const MaskedLevel& level, const CellComplex& fine, const Coarsened& coarsened,
                                const SharedPieces* shared, bool by_patterns, ThreadTeam& team,
                                const List<ComplexCell>& cells_of_all, CoarseOperator* whole) {
  const CellProducts products(level, fine, coarsened, team);
  const PieceAssembly& assembly = products.assembly;
  const List<ComplexCell>& cells = coarsened.complex.cells;
  const auto matrix = [&](std::size_t number, const Piece& piece, PieceMatrix& memory) {
    return products.matrix(number, piece, memory);
  };
  const auto numbered = [](std::size_t first, std::size_t end) {
    List<std::int32_t> numbers(end - first);
    std::iota(numbers.begin(), numbers.end(), static_cast<std::int32_t>(first));
    return numbers;
  };
  const auto slabs_for_threads = [&](const List<ComplexCell>& of, std::size_t first, std::size_t end) {
    return slabs_of(numbered(first, end), of, PieceAssembly::planes_per_slab);
  };
  // Range of the pieces that contribute to the rank's rows.
  const std::size_t first_known = shared == nullptr ? 0 : shared->first_known(),
                    end_known = shared == nullptr ? cells.size() : shared->end_known();
  List<std::uint64_t> of_known(by_patterns ? end_known - first_known : 0), of_all;
  if (by_patterns)
    for_slabs(slabs_for_threads(cells, first_known, end_known), team,
              [&](std::size_t first, std::size_t end) {
                for (std::size_t i = first; i < end; ++i)
                  of_known[i] = products.pattern(first_known + i);
              });
  if (shared != nullptr && by_patterns)
    of_all = shared->gather(of_known);
  const List<std::uint64_t> patterns =
      level.slabs().from_first(common_patterns(shared == nullptr ? of_known : of_all));
  std::unordered_map<std::uint64_t, std::int32_t> numbers;
  for (const std::uint64_t pattern : patterns)
    numbers.emplace(pattern, static_cast<std::int32_t>(numbers.size()));
  /// Pieces of cells; those from `first` on have known patterns.
  const auto pieces_of = [&](const List<ComplexCell>& of, std::size_t first,
                             const List<std::uint64_t>& known) {
    PatternedPieces pieces;
    pieces.first_of_slab = slabs_for_threads(of, 0, of.size());
    pieces.pieces.resize(of.size());
    for (std::size_t i = 0; i < of.size(); ++i)
      std::ranges::copy(of[i].vertex, pieces.pieces[i].vertex);
    if (numbers.empty())
      return pieces;
    for (std::size_t i = 0; i < known.size(); ++i)
      if (const auto number = numbers.find(known[i]); number != numbers.end())
        pieces.pieces[first + i].pattern = number->second;
    pieces.set_by_pattern(team);
    pieces.matrices = AlignedArray<float>(PatternedPieces::matrix_size * numbers.size());
    team.run(static_cast<int>(patterns.size()), [&](int item, int) {
      const auto number = static_cast<std::size_t>(item);
      put_matrix(products.matrix(patterns[number]),
                 pieces.matrices.data() + PatternedPieces::matrix_size * number);
    });
    return pieces;
  };
  List<std::int32_t> others;
  for (std::size_t i = first_known; i < end_known; ++i)
    if (numbers.empty() || !numbers.contains(of_known[i - first_known]))
      others.push_back(static_cast<std::int32_t>(i));
  BlockMatrix blocks = assembly.sum_of_pieces(others, team, matrix);
  if (shared != nullptr) {
    BlockMatrix gathered = shared->gather(blocks);
    if (level.slabs().is_first())
      *whole = CoarseOperator(std::move(gathered), pieces_of(cells_of_all, 0, of_all));
  }
  return CoarseOperator(std::move(blocks), pieces_of(cells, first_known, of_known));
}

CoarseOperator galerkin_product(const CoarseOperator& A, const CellComplex& fine, const Coarsened& coarsened,
                                const Weights& P_transposed, ThreadTeam& team) {
  BlockMatrix of_blocks = galerkin_product(A.blocks(), coarsened.interpolation, P_transposed, team);
  if (!A.has_pieces())
    return CoarseOperator(std::move(of_blocks));
  const PieceAssembly assembly(fine, coarsened);
  const PatternedPieces& known = A.pieces();
  const ProductsOfPatterns products(known, fine, assembly.n_pieces(), team);
  const auto matrix = [&](std::size_t number, const Piece& piece, PieceMatrix& sum) {
    const auto size = static_cast<Eigen::Index>(3 * piece.vertices.size());
    sum.setZero(size, size);
    for (const std::int32_t i : assembly.cells_of(number)) {
      const ComplexCell& cell = fine.cells[i];
      const std::int32_t pattern = known.pieces[i].pattern;
      if (pattern == PatternedPiece::no_pattern)
        continue;
      if (std::ranges::any_of(cell.vertex, [&](std::int32_t v) { return assembly.is_hinge(v); }))
        assembly.add_cell(cell, matrix_of(known, pattern), piece, sum);
      else
        products.add_to(sum, pattern, PieceAssembly::octant(cell));
    }
    return sum.data();
  };
  List<std::int32_t> all(assembly.n_pieces());
  std::iota(all.begin(), all.end(), 0);
  return CoarseOperator(assembly.sum_of_pieces(all, team, matrix, std::move(of_blocks)));
}

} // namespace maille::deform
