#include "elastic/masked/cell_complex.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>

namespace maille::deform {

namespace {

class DisjointSets {
public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  std::int32_t find(std::int32_t i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      std::int32_t& up = parent_[static_cast<std::size_t>(i)];
      i = up = parent_[static_cast<std::size_t>(up)];
    }
    return i;
  }
  /// The smaller one stands for both.
  void join(std::int32_t i, std::int32_t j) {
    i = find(i), j = find(j);
    parent_[static_cast<std::size_t>(std::max(i, j))] = std::min(i, j);
  }

private:
  List<std::int32_t> parent_;
};

/// Per vertex: 8 cell + corner of the cells that have it.
struct Stars {
  explicit Stars(const CellComplex& complex) : first(static_cast<std::size_t>(complex.n_vertices) + 1, 0) {
    for (const ComplexCell& cell : complex.cells)
      for (const std::int32_t v : cell.vertex)
        ++first[static_cast<std::size_t>(v) + 1];
    std::partial_sum(first.begin(), first.end(), first.begin());
    entries.resize(8 * complex.cells.size());
    List<std::int32_t> next(first.begin(), first.end() - 1);
    for (std::size_t i = 0; i < complex.cells.size(); ++i)
      for (std::size_t k = 0; k < 8; ++k)
        entries[static_cast<std::size_t>(next[static_cast<std::size_t>(complex.cells[i].vertex[k])]++)] =
            static_cast<std::int32_t>(8 * i + k);
  }
  List<std::int32_t> first, entries;
};

class Coarsening {
public:
  Coarsening(const CellComplex& fine, Joining joining) : fine_(fine), joining_(joining), stars_(fine) {}
  Coarsened run();

private:
  template<class Visit>
  void for_each_shared_face(const Visit& visit) const;
  List<std::int32_t> by_blocks() const;
  void find_pieces();
  void find_vertices();
  std::int32_t place_in_piece(std::int32_t cell, int corner) const;
  bool are_the_same(std::int32_t one, std::int32_t other) const;
  template<class Visit>
  void for_each_weight(std::int32_t place, const Visit& visit) const;
  void add_mean(std::span<const std::int32_t> star);
  void add_row(std::int32_t place);
  void interpolate();
  const Index3& place(std::int32_t cell) const { return fine_.cells[static_cast<std::size_t>(cell)].at; }

  const CellComplex& fine_;
  Joining joining_;
  Stars stars_;
  Coarsened result_;
};

Index3 half(const Index3& at) {
  return {at[0] / 2, at[1] / 2, at[2] / 2};
}

/// Calls visit(cell, other, axis) for cells that share the face between them, `other` beyond it along the
/// axis. The pair is found at the face's first vertex.
template<class Visit>
void Coarsening::for_each_shared_face(const Visit& visit) const {
  for (std::size_t v = 0; v < static_cast<std::size_t>(fine_.n_vertices); ++v) {
    const auto begin = stars_.entries.begin() + stars_.first[v],
               end = stars_.entries.begin() + stars_.first[v + 1];
    for (auto two = begin; two != end; ++two)
      for (auto one = *two % 8 == 0 ? begin : end; one != end; ++one) {
        const std::int32_t corner = *one % 8;
        if (corner != 1 && corner != 2 && corner != 4)
          continue;
        const ComplexCell &cell = fine_.cells[static_cast<std::size_t>(*one / 8)],
                          &other = fine_.cells[static_cast<std::size_t>(*two / 8)];
        bool is_shared = true;
        for (std::size_t k = 0; k < 8; ++k)
          if (!(static_cast<std::int32_t>(k) & corner))
            is_shared = is_shared && cell.vertex[k | static_cast<std::size_t>(corner)] == other.vertex[k];
        if (is_shared)
          visit(*one / 8, *two / 8, corner == 1 ? 0 : corner == 2 ? 1 : 2);
      }
  }
}

/// Cells block after block, x fastest; those of one block in their order: sorted by counting, axis after
/// axis.
List<std::int32_t> Coarsening::by_blocks() const {
  List<std::int32_t> order(fine_.cells.size()), next(fine_.cells.size());
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t a = 0; a < 3; ++a) {
    List<std::size_t> first;
    for (const ComplexCell& cell : fine_.cells) {
      const auto at = static_cast<std::size_t>(cell.at[a] / 2);
      first.resize(std::max(first.size(), at + 2));
      ++first[at + 1];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (const std::int32_t cell : order)
      next[first[static_cast<std::size_t>(place(cell)[a] / 2)]++] = cell;
    std::swap(order, next);
  }
  return order;
}

/// Cells of one block of 2 x 2 x 2, as far as they are joined within it, become one. Pieces are numbered by
/// blocks, plane after plane.
void Coarsening::find_pieces() {
  const auto n = static_cast<std::int32_t>(fine_.cells.size());
  DisjointSets sets(fine_.cells.size());
  const List<std::int32_t> order = by_blocks();
  const auto block = [&](std::int32_t cell) { return half(place(cell)); };
  if (joining_ == Joining::faces)
    for_each_shared_face([&](std::int32_t one, std::int32_t two, int) {
      if (half(place(one)) == half(place(two)))
        sets.join(one, two);
    });
  else
    for (std::size_t i = 1; i < order.size(); ++i)
      if (block(order[i]) == block(order[i - 1]))
        sets.join(order[i], order[i - 1]);
  result_.cell_of.assign(fine_.cells.size(), -1);
  List<std::int32_t> number(fine_.cells.size(), -1);
  for (std::int32_t i = 0; i < n; ++i) {
    const std::int32_t cell = order[static_cast<std::size_t>(i)];
    std::int32_t& piece = number[static_cast<std::size_t>(sets.find(cell))];
    if (piece < 0) {
      piece = static_cast<std::int32_t>(result_.complex.cells.size());
      result_.complex.cells.push_back({half(place(cell)), {}});
    }
    result_.cell_of[static_cast<std::size_t>(cell)] = piece;
  }
}

void Coarsening::find_vertices() {
  auto& cells = result_.complex.cells;
  DisjointSets sets(8 * cells.size());
  if (joining_ == Joining::faces) {
    List<std::int32_t> joined(3 * cells.size(),
                              -1); // the last one along an axis: pieces share up to four faces
    for_each_shared_face([&](std::int32_t one, std::int32_t two, int axis) {
      const std::int32_t from = result_.cell_of[static_cast<std::size_t>(one)],
                         to = result_.cell_of[static_cast<std::size_t>(two)];
      std::int32_t& last = joined[3 * static_cast<std::size_t>(from) + static_cast<std::size_t>(axis)];
      if (from == to || last == to)
        return;
      last = to;
      for (int k = 0; k < 8; ++k)
        if (!(k & 1 << axis))
          sets.join(8 * from + (k | 1 << axis), 8 * to + k);
    });
  } else {
    List<std::pair<std::array<int, 3>, std::int32_t>> corners;
    for (std::size_t i = 0; i < cells.size(); ++i)
      for (int k = 0; k < 8; ++k)
        corners.push_back(
            {{cells[i].at[2] + (k >> 2), cells[i].at[1] + (k >> 1 & 1), cells[i].at[0] + (k & 1)},
             static_cast<std::int32_t>(8 * i) + k});
    std::ranges::sort(corners);
    for (std::size_t i = 1; i < corners.size(); ++i)
      if (corners[i].first == corners[i - 1].first)
        sets.join(corners[i].second, corners[i - 1].second);
  }
  List<std::int32_t> number(8 * cells.size(), -1);
  for (std::size_t i = 0; i < number.size(); ++i) {
    std::int32_t& vertex = number[static_cast<std::size_t>(sets.find(static_cast<std::int32_t>(i)))];
    if (vertex < 0)
      vertex = result_.complex.n_vertices++;
    cells[i / 8].vertex[i % 8] = vertex;
  }
}

/// Of a cell's corner: see Coarsened::place.
std::int32_t Coarsening::place_in_piece(std::int32_t cell, int corner) const {
  const Index3& at = place(cell);
  const int halves[3] = {at[0] % 2 + (corner & 1), at[1] % 2 + (corner >> 1 & 1), at[2] % 2 + (corner >> 2)};
  return PlaceWeights::n_places * result_.cell_of[static_cast<std::size_t>(cell)] + halves[0] +
         3 * halves[1] + 9 * halves[2];
}

/// Whether two places, of one vertex in two pieces, have the same weights: then vertices at the corners that
/// count are the same, one after another.
bool Coarsening::are_the_same(std::int32_t one, std::int32_t other) const {
  const PlaceWeights &at = place_weights[static_cast<std::size_t>(one % PlaceWeights::n_places)],
                     &there = place_weights[static_cast<std::size_t>(other % PlaceWeights::n_places)];
  const auto& cells = result_.complex.cells;
  const std::int32_t *const vertices = cells[static_cast<std::size_t>(one / PlaceWeights::n_places)].vertex,
                            *const others =
                                cells[static_cast<std::size_t>(other / PlaceWeights::n_places)].vertex;
  bool are = at.size == there.size;
  for (int i = 0; i < at.size && are; ++i)
    are = vertices[at.corner[i]] == others[there.corner[i]];
  return are;
}

/// Calls visit(vertex, weight).
template<class Visit>
void Coarsening::for_each_weight(std::int32_t place, const Visit& visit) const {
  const PlaceWeights& of = place_weights[static_cast<std::size_t>(place % PlaceWeights::n_places)];
  const ComplexCell& piece = result_.complex.cells[static_cast<std::size_t>(place / PlaceWeights::n_places)];
  for (int i = 0; i < of.size; ++i)
    visit(piece.vertex[of.corner[i]], of.weight[i]);
}

/// Of a vertex that is of several pieces which are not joined there.
void Coarsening::add_mean(std::span<const std::int32_t> star) {
  Weights& weights = result_.interpolation;
  List<std::pair<std::int32_t, float>> sum;
  List<std::int32_t> pieces;
  for (const std::int32_t entry : star) {
    const std::int32_t piece = result_.cell_of[static_cast<std::size_t>(entry / 8)];
    if (std::ranges::find(pieces, piece) != pieces.end())
      continue;
    pieces.push_back(piece);
    for_each_weight(place_in_piece(entry / 8, entry % 8),
                    [&](std::int32_t vertex, float weight) { sum.emplace_back(vertex, weight); });
  }
  std::ranges::stable_sort(sum, {}, &std::pair<std::int32_t, float>::first);
  const std::size_t begin = weights.weight.size();
  for (std::size_t i = 0; i < sum.size(); ++i) {
    if (i == 0 || sum[i].first != sum[i - 1].first) {
      weights.column.push_back(sum[i].first);
      weights.weight.push_back(0);
    }
    weights.weight.back() += sum[i].second;
  }
  for (std::size_t i = begin; i < weights.weight.size(); ++i)
    weights.weight[i] /= static_cast<float>(pieces.size());
}

/// Vertices in ascending order.
void Coarsening::add_row(std::int32_t place) {
  std::int32_t vertices[8];
  float weights[8];
  std::ptrdiff_t n = 0;
  for_each_weight(place, [&](std::int32_t vertex, float weight) {
    std::ptrdiff_t at = n++;
    for (; at > 0 && vertices[at - 1] > vertex; --at) {
      vertices[at] = vertices[at - 1];
      weights[at] = weights[at - 1];
    }
    vertices[at] = vertex;
    weights[at] = weight;
  });
  Weights& all = result_.interpolation;
  all.column.insert(all.column.end(), vertices, vertices + n);
  all.weight.insert(all.weight.end(), weights, weights + n);
}

void Coarsening::interpolate() {
  Weights& weights = result_.interpolation;
  const auto n = static_cast<std::size_t>(fine_.n_vertices);
  weights.first.reserve(n + 1);
  weights.first.push_back(0);
  result_.is_hinge.assign(n, 0);
  result_.place.assign(n, -1);
  for (std::size_t v = 0; v < n; ++v) {
    const auto star = std::span(stars_.entries)
                          .subspan(static_cast<std::size_t>(stars_.first[v]),
                                   static_cast<std::size_t>(stars_.first[v + 1] - stars_.first[v]));
    std::int32_t& place = result_.place[v];
    for (const std::int32_t entry : star) {
      if (place >= 0 &&
          place / PlaceWeights::n_places == result_.cell_of[static_cast<std::size_t>(entry / 8)])
        continue;
      const std::int32_t found = place_in_piece(entry / 8, entry % 8);
      if (place >= 0 && !are_the_same(found, place)) {
        result_.is_hinge[v] = 1;
        break;
      }
      place = found;
    }
    if (result_.is_hinge[v] != 0) {
      place = -1;
      add_mean(star);
    } else if (place >= 0)
      add_row(place);
    weights.first.push_back(static_cast<std::int32_t>(weights.column.size()));
  }
  weights.column.shrink_to_fit(); // they stay as long as the hierarchy
  weights.weight.shrink_to_fit();
}

Coarsened Coarsening::run() {
  find_pieces();
  find_vertices();
  interpolate();
  return std::move(result_);
}

} // namespace

Weights Weights::transposed(std::int32_t n_columns) const {
  Weights other;
  other.first.assign(static_cast<std::size_t>(n_columns) + 1, 0);
  for (const std::int32_t c : column)
    ++other.first[static_cast<std::size_t>(c) + 1];
  std::partial_sum(other.first.begin(), other.first.end(), other.first.begin());
  other.column.resize(column.size());
  other.weight.resize(column.size());
  List<std::int32_t> next(other.first.begin(), other.first.end() - 1);
  for (std::int32_t row = 0; row < n_rows(); ++row)
    for (auto i = static_cast<std::size_t>(first[static_cast<std::size_t>(row)]);
         i < static_cast<std::size_t>(first[static_cast<std::size_t>(row) + 1]); ++i) {
      const auto at = static_cast<std::size_t>(next[static_cast<std::size_t>(column[i])]++);
      other.column[at] = row;
      other.weight[at] = weight[i];
    }
  return other;
}

Coarsened coarsen(const CellComplex& fine, Joining joining) {
  return Coarsening(fine, joining).run();
}

} // namespace maille::deform
