#pragma once
/// How ranks share the finest grid of a body, and the finest of the coarser ones.

#include "elastic/masked/cell_complex.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_rows.hpp"
#include "lattice/field_memory.hpp"
#include "maille/scene/communicator.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

/// Planes of nodes along z are cut into slabs, of about as much matter each; every rank has one, and knows
/// the cells that its planes, and the coarser grid's vertices in them, depend on. One process has all of
/// them. Sums are of planes, in their order: the same bits for any number of ranks.
class Slabs {
public:
  /// Planes that slabs consist of: whole blocks of 2 cells, and what LatticeElasticity::for_each_window()
  /// takes at once.
  static constexpr int planes_per_unit = 4;
  /// Layers of cells below and above a slab's own. Three planes of blocks, or two, tell which of the coarser
  /// grid's vertices at the border are one, and their numbers.
  static constexpr int layers_below = 6, layers_above = 4;

  /// @param all null, or of no more ranks than the body has units: one process
  Slabs(const Specimen& body, Communicator* all);

  bool are_shared() const { return all_ != nullptr; }
  /// Whether coarser grids are here.
  bool is_first() const { return all_ == nullptr || all_->is_first(); }
  Communicator& ranks() const { return *all_; }
  PlaneRange own() const { return own_of(rank()); }           ///< planes of nodes
  LayerRange layers() const;                                  ///< of cells that are known
  LayerRange layers_of_own() const;                           ///< that meet its own planes
  bool is_own(int plane) const { return plane >= own().first && plane < own().end; }
  /// Planes of the coarser grid's vertices, which are twice as far apart.
  PlaneRange own_coarse() const { return {own().first / 2, is_last() ? n_planes() / 2 + 1 : own().end / 2}; }

  /// Of numbers of its own planes from every rank, the sum in the order of planes.
  double total(std::span<const double> of_own) const;
  /// Of one number from every rank.
  double largest(double of_own) const;
  double sum(double of_own) const;
  /// The sums of earlier ranks, and of all.
  std::pair<std::int64_t, std::int64_t> before_and_all(std::int64_t of_own) const;
  /// The planes next to its own become what their owners have.
  /// @param field component after component, `stride` apart
  void exchange_borders(const MaskedRows& rows, std::int64_t stride, float* field) const;
  /// A field of all planes becomes what their owners have, on the first rank.
  void gather_planes(std::span<double> field) const;
  /// Lists of all ranks, by rank, on the first; the others have none.
  template<class Number>
  std::vector<List<Number>> gather(const List<Number>& of_own) const;
  /// What the first rank has; of one process its own.
  template<class Number>
  List<Number> from_first(List<Number> numbers) const;

private:
  int rank() const { return all_ == nullptr ? 0 : all_->rank(); }
  bool is_last() const { return rank() + 2 == static_cast<int>(first_.size()); }
  int n_planes() const { return first_.back(); }
  PlaneRange own_of(int rank) const {
    return {first_[static_cast<std::size_t>(rank)], first_[static_cast<std::size_t>(rank) + 1]};
  }
  std::vector<double> of_ranks(double of_own) const;

  Communicator* all_;
  std::vector<int> first_; ///< plane of every rank, and the end
};

template<class Number>
std::vector<List<Number>> Slabs::gather(const List<Number>& of_own) const {
  std::vector<double> sizes = of_ranks(static_cast<double>(of_own.size()));
  std::vector<List<Number>> lists;
  std::vector<Communicator::Part> to, from;
  if (is_first()) {
    lists.resize(sizes.size());
    lists.front() = of_own;
    for (std::size_t rank = 1; rank < sizes.size(); ++rank) {
      lists[rank].resize(static_cast<std::size_t>(sizes[rank]));
      from.push_back({static_cast<int>(rank), bytes_of(lists[rank])});
    }
  } else
    to.push_back({0, bytes_of(const_cast<List<Number>&>(of_own))}); // is only read
  ranks().exchange(to, from);
  return lists;
}

template<class Number>
List<Number> Slabs::from_first(List<Number> numbers) const {
  if (!are_shared())
    return numbers;
  std::uint64_t size = numbers.size();
  share_from_first(ranks(), std::span(&size, 1));
  numbers.resize(size);
  share_from_first(ranks(), std::span<Number>(numbers));
  return numbers;
}

/// The finest of the coarser grids, which the first rank has whole. Every rank has the pieces of its layers,
/// with numbers of its own; it adds up residuals at the vertices in its planes, and asks for corrections at
/// those that its nodes are interpolated from.
class SharedPieces {
public:
  /// @param coarsened of the cells that the rank knows @pre slabs are shared
  SharedPieces(const Slabs& slabs, const Coarsened& coarsened);

  /// Of all ranks.
  std::int32_t n_vertices() const { return n_vertices_; }
  /// All pieces with the first rank's numbers, there; no cells elsewhere.
  CellComplex complex(const Coarsened& coarsened) const;
  /// The first of the pieces that the rows of its vertices are made of, and the end.
  std::size_t first_known() const { return first_known_; }
  std::size_t end_piece() const { return end_piece_; }
  /// What the first rank's pieces have. @param of_known of the rank's pieces from first_known() on
  List<std::uint64_t> gather(const List<std::uint64_t>& of_known) const;
  /// The matrix of all vertices, there, from rows that ranks have added up for the vertices in their planes.
  BlockMatrix gather(const BlockMatrix& A) const;
  /// field() at the vertices of its planes, of all ranks, becomes f there.
  void collect(float* f);
  /// field() becomes u where the rank needs it.
  void hand_out(const float* u);

  const List<PatternedPiece>& pieces() const { return pieces_; }
  AlignedArray<float>& field() { return field_; }

private:
  std::int32_t number(std::int32_t vertex) const { return vertex - of_earlier_ + first_vertex_; }
  List<float> values_at(const List<std::int32_t>& vertices, const float* field) const;

  const Slabs& slabs_;
  std::size_t first_known_ = 0, first_piece_ = 0, end_piece_ = 0; ///< of its own planes
  std::int32_t n_vertices_ = 0, first_vertex_ = 0, of_earlier_ = 0;
  List<PatternedPiece> pieces_;      ///< with the rank's own numbers
  List<std::int32_t> rows_, needed_; ///< vertices: in its planes, and that its nodes are interpolated from
  std::vector<List<std::int32_t>> rows_of_, needed_of_; ///< of every rank, on the first, in its numbers
  AlignedArray<float> field_;
};

} // namespace maille::deform
