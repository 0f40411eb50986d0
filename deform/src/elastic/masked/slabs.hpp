#pragma once
/// How ranks share the finest grid of a body, and the finest of the coarser ones.

#include "elastic/masked/cell_complex.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_rows.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "lattice/field_memory.hpp"
#include "maille/base/communicator.hpp"

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
  static constexpr int planes_per_unit = LatticeElasticity::planes_per_window;
  /// Layers of cells below and above a slab's own: three planes of blocks tell which of the coarser grid's
  /// vertices at the border are one, and their numbers.
  static constexpr int layers_below = 6, layers_above = layers_below;

  /// @param all null, or of no more ranks than the body has units: one process
  Slabs(const Specimen& body, Communicator* all);

  bool are_shared() const { return all_ != nullptr; }
  /// Whether coarser grids are here.
  bool is_first() const { return rank() == 0; }
  bool is_last() const { return rank() + 2 == static_cast<int>(first_.size()); }
  int rank() const { return all_ == nullptr ? 0 : all_->rank(); }
  Communicator& ranks() const { return *all_; }
  PlaneRange own() const { return own_of(rank()); } ///< planes of nodes
  LayerRange layers() const;                        ///< of cells that are known
  LayerRange layers_of_own() const;                 ///< that meet its own planes
  bool is_own(int plane) const { return plane >= own().first && plane < own().end; }
  /// The same of planes of pieces, blocks of 2 x 2 x 2 cells.
  Slabs of_pieces() const;

  /// Sum over the own planes of every rank, in the order of planes.
  double total(std::span<const double> of_own) const;
  std::vector<double> of_ranks(double of_own) const;
  /// Largest of one number from every rank.
  double largest(double of_own) const;
  /// Sums of those of earlier ranks, by rank, and of all.
  std::vector<double> first_of_ranks(double of_own) const;
  /// Copies the plane below this rank's own, and `above` planes above them, from their owners.
  /// @param field component after component, `stride` apart
  void exchange_borders(const MaskedRows& rows, std::int64_t stride, float* field, int above = 1) const;
  /// Numbers of all planes become what their owners have, on the first rank; the others have none.
  /// @pre slabs are shared
  void gather_planes(std::span<double> of_own, std::span<double> of_all) const;
  /// Lists of all ranks, by rank, on the first; the others have none.
  template<class Number>
  std::vector<List<Number>> gather(const List<Number>& of_own) const;
  /// What the first rank has; of one process its own.
  template<class Number>
  List<Number> from_first(List<Number> numbers) const;

private:
  int n_planes() const { return first_.back(); }
  PlaneRange own_of(int rank) const { return {first_[rank], first_[static_cast<std::size_t>(rank) + 1]}; }
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

/// First entries of a field of the coarser grid of the vertices that pieces of some planes have and none
/// below, and the end: vertices have numbers in the order of the first pieces that have them.
List<std::int64_t> first_entries_of_planes(const List<ComplexCell>& pieces, PlaneRange planes);

/// The finest of the coarser grids. A rank knows the pieces of its layers, with numbers of its own. It has
/// the rows of the vertices whose first piece is in its planes, one after another, and on both sides of them
/// those that rows have columns of, whose owners are asked for their values.
class SharedPieces {
public:
  /// @param slabs outlive this, and are shared @param coarsened of the cells that the rank knows
  SharedPieces(const Slabs& slabs, const Coarsened& coarsened);

  /// Number of vertices over all ranks.
  std::int32_t n_vertices() const { return n_vertices_; }
  bool is_first() const { return slabs_.is_first(); }
  /// All pieces with the numbers of all, on the first rank; no cells elsewhere.
  CellComplex complex(const Coarsened& coarsened) const;
  /// The first of the pieces that its rows are made of, and the end.
  std::size_t first_known() const { return known_.first; }
  std::size_t end_known() const { return known_.second; }
  /// What all pieces have, on the first rank. @param of_known of those that are known
  List<std::uint64_t> gather(const List<std::uint64_t>& of_known) const;
  /// The matrix of all vertices, there, from the rows of all ranks.
  BlockMatrix gather(const BlockMatrix& A) const;

  // Fields have block_stride numbers a vertex.
  /// Its own, by first_entries_of_planes().
  const List<std::int64_t>& parts() const { return parts_; }
  /// What the numbers of entries among all are more than its own.
  std::int64_t offset() const { return block_stride * std::int64_t{first_vertex_ - of_earlier_}; }
  double total(std::span<const double> of_parts) const { return pieces_.total(of_parts); }
  double largest(double of_own) const { return slabs_.largest(of_own); }
  /// Entries on both sides of its own become what their owners have.
  void exchange_borders(float* field) const;
  /// A field of all vertices, there, becomes what their owners have, and the other way round.
  void collect(const float* field, float* of_all) const;
  void hand_out(const float* of_all, float* field) const;

private:
  std::int32_t number(std::int32_t vertex) const { return vertex - of_earlier_ + first_vertex_; }

  const Slabs& slabs_;
  Slabs pieces_;                                    ///< planes of them
  std::pair<std::size_t, std::size_t> known_, own_; ///< pieces
  std::int32_t n_vertices_ = 0, first_vertex_ = 0, of_earlier_ = 0, n_own_ = 0;
  std::vector<double> below_, above_; ///< how many vertices every rank asks of its neighbours
  std::vector<double> first_of_rank_; ///< vertex, and the end
  List<std::int64_t> parts_;
};

} // namespace maille::deform
