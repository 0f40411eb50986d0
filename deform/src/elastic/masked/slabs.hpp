#pragma once
/// Domain decomposition: how ranks share the finest grid of a body and the first coarser one.

#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/coarsening/cell_complex.hpp"
#include "elastic/masked/masked_rows.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "lattice/field_memory.hpp"
#include "maille/base/communicator.hpp"

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

/// Cuts the planes of nodes along z into slabs of about equal matter, one for each rank. A rank stores the
/// cells that its planes, and the coarse vertices in them, depend on. Without ranks one process has all
/// planes. Sums go over planes in their order, so bits do not depend on the number of ranks.
class Slabs {
public:
  /// Slabs are multiples of this many planes: whole blocks of 2 cells, and whole windows of
  /// LatticeElasticity.
  static constexpr int planes_per_unit = LatticeElasticity::planes_per_window;
  /// Layers of cells stored below and above a slab's own. Three planes of blocks determine which coarse
  /// vertices at the border are shared, and their numbers.
  static constexpr int layers_below = 6, layers_above = layers_below;

  /// @param all null for one process; at most as many ranks as the body has units
  Slabs(const Specimen& body, Communicator* all);

  bool are_shared() const { return all_ != nullptr; }
  /// True on the rank that has the coarser grids.
  bool is_first() const { return rank() == 0; }
  bool is_last() const { return rank() + 2 == static_cast<int>(first_.size()); }
  int rank() const { return all_ == nullptr ? 0 : all_->rank(); }
  Communicator& ranks() const { return *all_; }
  PlaneRange own() const { return own_of(rank()); } ///< planes of nodes
  LayerRange layers() const;                        ///< of cells that are known
  LayerRange layers_of_own() const;                 ///< that meet its own planes
  bool is_own(int plane) const { return plane >= own().first && plane < own().end; }
  /// The slabs of the coarser grid, in planes of pieces.
  Slabs of_pieces() const;

  /// Sum over the own planes of every rank, in the order of planes.
  double total(std::span<const double> of_own) const;
  std::vector<double> of_ranks(double of_own) const;
  /// Largest of one number from every rank.
  double largest(double of_own) const;
  /// Sums over the earlier ranks, by rank, and the total.
  std::vector<double> first_of_ranks(double of_own) const;
  /// Copies the plane below this rank's own, and `above` planes above them, from their owners.
  /// @param field component after component, `stride` apart
  void exchange_borders(const MaskedRows& rows, std::int64_t stride, float* field, int above = 1) const;
  /// Gathers the numbers of all planes on the first rank; `of_all` is unused on other ranks. @pre slabs are
  /// shared
  void gather_planes(std::span<double> of_own, std::span<double> of_all) const;
  /// Gathers the lists of all ranks on the first rank, by rank; other ranks get an empty result.
  template<class Number>
  std::vector<List<Number>> gather(const List<Number>& of_own) const;
  /// Broadcasts the list of the first rank.
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

/// Ranges of a coarse field by planes of pieces: the first entry of each plane, and the end. Vertices are
/// numbered by the first piece that has them.
List<std::int64_t> first_entries_of_planes(const List<ComplexCell>& pieces, PlaneRange planes);

/// The first coarser grid where ranks share it. A rank knows the pieces of its layers under local numbers. It
/// owns the rows of the vertices whose first piece lies in its planes; these are contiguous. The columns that
/// its rows need from neighbours lie on both sides of them.
class SharedPieces {
public:
  /// @param slabs outlive this, and are shared @param coarsened of the cells that the rank knows
  SharedPieces(const Slabs& slabs, const Coarsened& coarsened);

  /// Number of vertices over all ranks.
  std::int32_t n_vertices() const { return n_vertices_; }
  bool is_first() const { return slabs_.is_first(); }
  /// All pieces with global numbers on the first rank; no cells elsewhere.
  CellComplex complex(const Coarsened& coarsened) const;
  /// Range of the pieces that contribute to its rows.
  std::size_t first_known() const { return known_.first; }
  std::size_t end_known() const { return known_.second; }
  /// Gathers one number per piece on the first rank. @param of_known numbers of the known pieces
  List<std::uint64_t> gather(const List<std::uint64_t>& of_known) const;
  /// Gathers the matrix of all vertices on the first rank.
  BlockMatrix gather(const BlockMatrix& A) const;

  // Fields have block_stride numbers a vertex.
  /// Ranges of its own entries; see first_entries_of_planes().
  const List<std::int64_t>& parts() const { return parts_; }
  /// Global minus local number of an entry.
  std::int64_t offset() const { return block_stride * std::int64_t{first_vertex_ - of_earlier_}; }
  double total(std::span<const double> of_parts) const { return pieces_.total(of_parts); }
  double largest(double of_own) const { return slabs_.largest(of_own); }
  /// Copies the entries on both sides of its own from their owners.
  void exchange_borders(float* field) const;
  /// Gathers a field of all vertices on the first rank, or scatters it.
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
