#pragma once
/// Look-up tables of coarsening: connected parts (union and find), and the cell that starts at a vertex.

#include "elastic/masked/coarsening/cell_complex.hpp"

#include "maille/base/arena.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>

namespace maille::deform {

class DisjointSets {
public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t find(std::int32_t i) {
    while (parent_[i] != i) {
      std::int32_t& up = parent_[i];
      i = up = parent_[up];
    }
    return i;
  }
  /// The same without path compression, for several threads after the last join.
  std::int32_t seek(std::int32_t i) const {
    while (parent_[i] != i)
      i = parent_[i];
    return i;
  }
  /// The smallest number represents a set, in any order of joins.
  void join(std::int32_t i, std::int32_t j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

private:
  List<std::int32_t> parent_;
};

/// The cells that have a vertex as their first corner, one after another.
class FirstCorners {
public:
  explicit FirstCorners(const CellComplex& complex)
      : first_(static_cast<std::size_t>(complex.n_vertices), -1), next_(complex.cells.size()) {
    for (std::size_t i = complex.cells.size(); i-- > 0;) {
      std::int32_t& first = first_[complex.cells[i].vertex[0]];
      next_[i] = std::exchange(first, static_cast<std::int32_t>(i));
    }
  }
  template<class Visit>
  void for_each_at(std::int32_t vertex, const Visit& visit) const {
    for (std::int32_t i = first_[vertex]; i >= 0; i = next_[i])
      visit(i);
  }

private:
  List<std::int32_t> first_, next_;
};

} // namespace maille::deform
