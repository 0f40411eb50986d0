#include "elastic/masked/coarsening/cell_complex.hpp"

#include "elastic/masked/coarsening/cell_sets.hpp"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

namespace maille::deform {

namespace {

/// Planes of blocks of 2 x 2 x 2 cells per work item: every second slab shares no vertex.
constexpr int planes_per_slab = 2;

/// Owners of the vertices at hinges: 8 cell + corner.
struct HingeStar {
  std::int32_t vertex = 0, entry = 0;
};

class Coarsening {
public:
  /// @pre cells come plane after plane
  Coarsening(const CellComplex& fine, Joining joining, ThreadTeam& team);
  Coarsened run(bool of_hinges_alone);

private:
  int n_planes() const { return static_cast<int>(first_of_plane_.size()) - 1; } ///< of blocks
  int n_slabs() const { return (n_planes() + planes_per_slab - 1) / planes_per_slab; }
  std::int32_t first_of_slab(int slab) const {
    return first_of_plane_[std::min(slab * planes_per_slab, n_planes())];
  }
  template<class Work>
  void for_slabs_in_turn(const Work& work);
  template<class Visit>
  void for_each_shared_face(std::int32_t cell, bool within, const Visit& visit) const;
  void sort_by_blocks(int plane, List<std::int32_t>& order) const;
  void find_pieces();
  void join_faces(std::int32_t first, std::int32_t end, bool to_next_slab, DisjointSets& sets) const;
  void join_places(DisjointSets& sets) const;
  void find_vertices();
  std::int32_t place_in_piece(std::int32_t cell, int corner) const;
  bool are_the_same(std::int32_t one, std::int32_t other) const;
  template<class Visit>
  void for_each_weight(std::int32_t place, const Visit& visit) const;
  void find_places();
  List<HingeStar> hinges();
  void add_mean(std::span<const HingeStar> star, Weights& weights) const;
  void set_row(std::int32_t place, std::size_t at);
  void interpolate(bool of_hinges_alone);
  const Index3& place(std::int32_t cell) const { return fine_.cells[cell].at; }
  std::int32_t piece(std::int32_t cell) const { return result_.cell_of[cell]; }
  int slab_of_piece(std::int32_t piece) const { return result_.complex.cells[piece].at[2] / planes_per_slab; }

  const CellComplex& fine_;
  Joining joining_;
  ThreadTeam& team_;
  FirstCorners first_corners_;
  List<std::int32_t> first_of_plane_; ///< cell of every plane of blocks, and the end
  Coarsened result_;
};

Index3 half(const Index3& at) {
  return {at[0] / 2, at[1] / 2, at[2] / 2};
}

Coarsening::Coarsening(const CellComplex& fine, Joining joining, ThreadTeam& team)
    : fine_(fine), joining_(joining), team_(team), first_corners_(fine) {
  const int planes = fine.cells.empty() ? 0 : fine.cells.back().at[2] / 2 + 1;
  for (int plane = 0; plane <= planes; ++plane)
    first_of_plane_.push_back(static_cast<std::int32_t>(
        std::ranges::lower_bound(fine.cells, 2 * plane, {}, [](const ComplexCell& c) { return c.at[2]; }) -
        fine.cells.begin()));
}

/// Calls work(first cell, end, slab) as run_slabs() does.
template<class Work>
void Coarsening::for_slabs_in_turn(const Work& work) {
  run_slabs(team_, n_slabs(), [&](int slab) { work(first_of_slab(slab), first_of_slab(slab + 1), slab); });
}

/// Calls visit(other, axis) for the neighbours beyond the upper faces of a cell, within its block or in
/// another.
template<class Visit>
void Coarsening::for_each_shared_face(std::int32_t cell, bool within, const Visit& visit) const {
  const std::int32_t* const vertex = fine_.cells[cell].vertex;
  for (int axis = 0; axis < 3; ++axis) {
    if ((place(cell)[axis] % 2 == 0) != within)
      continue;
    first_corners_.for_each_at(vertex[1 << axis], [&](std::int32_t other) {
      const std::int32_t* const of_other = fine_.cells[other].vertex;
      bool is_shared = true;
      for (int k = 0; k < 8; ++k)
        if (!(k & 1 << axis))
          is_shared = is_shared && vertex[k | 1 << axis] == of_other[k];
      if (is_shared)
        visit(other, axis);
    });
  }
}

/// Sorts the cells of a plane of blocks by block, x fastest, and by their order within a block: counting
/// sort, axis by axis.
void Coarsening::sort_by_blocks(int plane, List<std::int32_t>& order) const {
  const std::int32_t begin = first_of_plane_[plane],
                     end = first_of_plane_[static_cast<std::size_t>(plane) + 1];
  List<std::int32_t> from(static_cast<std::size_t>(end - begin)), to(from.size());
  std::iota(from.begin(), from.end(), begin);
  for (std::size_t a = 0; a < 2; ++a) {
    List<std::size_t> first(1, 0);
    for (std::int32_t cell = begin; cell < end; ++cell) {
      const auto at = static_cast<std::size_t>(place(cell)[a] / 2);
      first.resize(std::max(first.size(), at + 2));
      ++first[at + 1];
    }
    std::partial_sum(first.begin(), first.end(), first.begin());
    for (const std::int32_t cell : from)
      to[first[place(cell)[a] / 2]++] = cell;
    std::swap(from, to);
  }
  std::ranges::copy(from, order.begin() + begin);
}

/// Joins the connected cells of each block into pieces. Pieces are numbered by blocks, plane by plane.
void Coarsening::find_pieces() {
  List<std::int32_t> order(fine_.cells.size()), number(fine_.cells.size(), -1);
  DisjointSets sets(fine_.cells.size());
  result_.cell_of.resize(fine_.cells.size());
  std::vector<std::int32_t> first_piece(static_cast<std::size_t>(n_planes()) + 1, 0); // of planes
  team_.run(n_planes(), [&](int plane, int) {
    sort_by_blocks(plane, order);
    const auto begin = static_cast<std::size_t>(first_of_plane_[plane]),
               end = static_cast<std::size_t>(first_of_plane_[static_cast<std::size_t>(plane) + 1]);
    for (std::size_t i = begin; i < end; ++i)
      if (joining_ == Joining::faces)
        for_each_shared_face(order[i], true, [&](std::int32_t other, int) { sets.join(order[i], other); });
      else if (i > begin && half(place(order[i])) == half(place(order[i - 1])))
        sets.join(order[i], order[i - 1]);
    std::int32_t n = 0;
    for (std::size_t i = begin; i < end; ++i) {
      std::int32_t& piece = number[sets.find(order[i])];
      if (piece < 0)
        piece = n++;
      result_.cell_of[order[i]] = piece;
    }
    first_piece[static_cast<std::size_t>(plane) + 1] = n;
  });
  std::partial_sum(first_piece.begin(), first_piece.end(), first_piece.begin());
  result_.complex.cells.resize(first_piece.back());
  team_.run(n_planes(), [&](int plane, int) {
    const auto at = static_cast<std::size_t>(plane);
    for (std::int32_t cell = first_of_plane_[at]; cell < first_of_plane_[at + 1]; ++cell) {
      std::int32_t& piece = result_.cell_of[cell];
      piece += first_piece[at];
      result_.complex.cells[piece].at = half(place(cell));
    }
  });
}

/// Joins the corners of pieces across shared faces, for the cells from `first` on, within their slab or the
/// next. @param sets of 8 piece + corner
void Coarsening::join_faces(std::int32_t first, std::int32_t end, bool to_next_slab,
                            DisjointSets& sets) const {
  for (std::int32_t cell = first; cell < end; ++cell) {
    const std::int32_t from = piece(cell);
    std::int32_t last[3] = {-1, -1, -1};
    for_each_shared_face(cell, false, [&](std::int32_t other, int axis) {
      const std::int32_t to = piece(other);
      if (last[axis] == to || (slab_of_piece(from) != slab_of_piece(to)) != to_next_slab)
        return;
      last[axis] = to;
      for (int k = 0; k < 8; ++k)
        if (!(k & 1 << axis))
          sets.join(8 * from + (k | 1 << axis), 8 * to + k);
    });
  }
}

void Coarsening::join_places(DisjointSets& sets) const {
  const auto& cells = result_.complex.cells;
  List<std::pair<std::array<int, 3>, std::int32_t>> corners;
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (int k = 0; k < 8; ++k)
      corners.push_back({{cells[i].at[2] + (k >> 2), cells[i].at[1] + (k >> 1 & 1), cells[i].at[0] + (k & 1)},
                         static_cast<std::int32_t>(8 * i) + k});
  std::ranges::sort(corners);
  for (std::size_t i = 1; i < corners.size(); ++i)
    if (corners[i].first == corners[i - 1].first)
      sets.join(corners[i].second, corners[i - 1].second);
}

/// Numbers vertices in the order of pieces.
void Coarsening::find_vertices() {
  auto& cells = result_.complex.cells;
  const std::size_t n = 8 * cells.size();
  DisjointSets sets(n);
  if (joining_ == Joining::faces) {
    team_.run(n_slabs(),
              [&](int slab, int) { join_faces(first_of_slab(slab), first_of_slab(slab + 1), false, sets); });
    for (int slab = 0; slab < n_slabs(); ++slab) {
      const std::int32_t end = first_of_slab(slab + 1);
      std::int32_t first = end; // of the last plane of blocks
      while (first > first_of_slab(slab) && place(first - 1)[2] / 2 % planes_per_slab == planes_per_slab - 1)
        --first;
      join_faces(first, end, true, sets);
    }
  } else
    join_places(sets);
  std::vector<std::int32_t> first_vertex(n_parts_of(n) + 1, 0); // of parts
  for_parts(n, team_, [&](std::size_t first, std::size_t end, std::size_t part) {
    std::int32_t n_roots = 0;
    for (std::size_t i = first; i < end; ++i) {
      const std::int32_t root = sets.seek(static_cast<std::int32_t>(i));
      cells[i / 8].vertex[i % 8] = root;
      n_roots += root == static_cast<std::int32_t>(i) ? 1 : 0;
    }
    first_vertex[part + 1] = n_roots;
  });
  std::partial_sum(first_vertex.begin(), first_vertex.end(), first_vertex.begin());
  result_.complex.n_vertices = first_vertex.back();
  List<std::int32_t> number(n);
  for_parts(n, team_, [&](std::size_t first, std::size_t end, std::size_t part) {
    std::int32_t next = first_vertex[part];
    for (std::size_t i = first; i < end; ++i)
      if (cells[i / 8].vertex[i % 8] == static_cast<std::int32_t>(i))
        number[i] = next++;
  });
  for_parts(n, team_, [&](std::size_t first, std::size_t end, std::size_t) {
    for (std::size_t i = first; i < end; ++i) {
      std::int32_t& vertex = cells[i / 8].vertex[i % 8];
      vertex = number[vertex];
    }
  });
}

/// Place of a cell's corner in its piece: see Coarsened::place.
std::int32_t Coarsening::place_in_piece(std::int32_t cell, int corner) const {
  const Index3& at = place(cell);
  const int halves[3] = {at[0] % 2 + (corner & 1), at[1] % 2 + (corner >> 1 & 1), at[2] % 2 + (corner >> 2)};
  return places_of_piece * piece(cell) + halves[0] + 3 * halves[1] + 9 * halves[2];
}

/// True if two places of one vertex, in two pieces, have the same weights on the same vertices.
bool Coarsening::are_the_same(std::int32_t one, std::int32_t other) const {
  const PlaceWeights &at = place_weights[one % places_of_piece],
                     &there = place_weights[other % places_of_piece];
  const auto& cells = result_.complex.cells;
  const std::int32_t *const vertices = cells[one / places_of_piece].vertex, *const others =
                                                                                cells[other / places_of_piece]
                                                                                    .vertex;
  bool are = at.size == there.size;
  for (int i = 0; i < at.size && are; ++i)
    are = vertices[at.corner[i]] == others[there.corner[i]];
  return are;
}

/// Calls visit(vertex, weight).
template<class Visit>
void Coarsening::for_each_weight(std::int32_t place, const Visit& visit) const {
  const PlaceWeights& of = place_weights[place % places_of_piece];
  const ComplexCell& piece = result_.complex.cells[place / places_of_piece];
  for (int i = 0; i < of.size; ++i)
    visit(piece.vertex[of.corner[i]], of.weight[i]);
}

void Coarsening::find_places() {
  const auto n = static_cast<std::size_t>(fine_.n_vertices);
  result_.is_hinge.assign(n, 0);
  result_.place.assign(n, -1);
  List<std::int32_t> seen(n, -1); // the last piece that asked
  for_slabs_in_turn([&](std::int32_t first, std::int32_t end, int) {
    for (std::int32_t cell = first; cell < end; ++cell)
      for (int corner = 0; corner < 8; ++corner) {
        const auto v = static_cast<std::size_t>(fine_.cells[cell].vertex[corner]);
        if (std::exchange(seen[v], piece(cell)) == piece(cell))
          continue;
        std::int32_t& place = result_.place[v];
        const std::int32_t found = place_in_piece(cell, corner);
        if (place < 0)
          place = found;
        else if (!are_the_same(found, place))
          result_.is_hinge[v] = 1;
      }
  });
}

/// Sorts by vertex, and by cell within a vertex.
List<HingeStar> Coarsening::hinges() {
  std::vector<List<HingeStar>> parts(n_slabs());
  for_slabs_in_turn([&](std::int32_t first, std::int32_t end, int slab) {
    for (std::int32_t cell = first; cell < end; ++cell)
      for (int corner = 0; corner < 8; ++corner) {
        const std::int32_t v = fine_.cells[cell].vertex[corner];
        if (result_.is_hinge[v] != 0)
          parts[slab].push_back({v, 8 * cell + corner});
      }
  });
  List<HingeStar> all;
  for (const List<HingeStar>& part : parts)
    all.insert(all.end(), part.begin(), part.end());
  std::ranges::stable_sort(all, {}, &HingeStar::vertex);
  return all;
}

/// Interpolation weights of a hinge.
void Coarsening::add_mean(std::span<const HingeStar> star, Weights& weights) const {
  List<std::pair<std::int32_t, float>> sum;
  List<std::int32_t> pieces;
  for (const HingeStar& of : star) {
    if (std::ranges::find(pieces, piece(of.entry / 8)) != pieces.end())
      continue;
    pieces.push_back(piece(of.entry / 8));
    for_each_weight(place_in_piece(of.entry / 8, of.entry % 8),
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
  weights.first.push_back(static_cast<std::int32_t>(weights.column.size()));
}

/// Vertices in ascending order. @param at of the row's first weight
void Coarsening::set_row(std::int32_t place, std::size_t at) {
  std::int32_t* const vertices = result_.interpolation.column.data() + at;
  float* const weights = result_.interpolation.weight.data() + at;
  std::ptrdiff_t n = 0;
  for_each_weight(place, [&](std::int32_t vertex, float weight) {
    std::ptrdiff_t i = n++;
    for (; i > 0 && vertices[i - 1] > vertex; --i) {
      vertices[i] = vertices[i - 1];
      weights[i] = weights[i - 1];
    }
    vertices[i] = vertex;
    weights[i] = weight;
  });
}

void Coarsening::interpolate(bool of_hinges_alone) {
  find_places();
  const List<HingeStar> stars = hinges();
  Weights means; // a row for every hinge
  means.first.push_back(0);
  List<std::int32_t> hinge;
  for (std::size_t i = 0, end = 0; i < stars.size(); i = end) {
    while (end < stars.size() && stars[end].vertex == stars[i].vertex)
      ++end;
    hinge.push_back(stars[i].vertex);
    result_.place[stars[i].vertex] = -1;
    add_mean(std::span(stars).subspan(i, end - i), means);
  }
  Weights& weights = result_.interpolation;
  const auto n = static_cast<std::size_t>(fine_.n_vertices);
  weights.first.assign(n + 1, 0);
  for_parts(of_hinges_alone ? 0 : n, team_, [&](std::size_t first, std::size_t end, std::size_t) {
    for (std::size_t v = first; v < end; ++v)
      if (const std::int32_t place = result_.place[v]; place >= 0)
        weights.first[v + 1] = place_weights[place % places_of_piece].size;
  });
  for (std::size_t i = 0; i < hinge.size(); ++i)
    weights.first[static_cast<std::size_t>(hinge[i]) + 1] = means.first[i + 1] - means.first[i];
  std::partial_sum(weights.first.begin(), weights.first.end(), weights.first.begin());
  weights.column.resize(weights.first.back());
  weights.weight.resize(weights.column.size());
  for_parts(of_hinges_alone ? 0 : n, team_, [&](std::size_t first, std::size_t end, std::size_t) {
    for (std::size_t v = first; v < end; ++v)
      if (result_.place[v] >= 0)
        set_row(result_.place[v], static_cast<std::size_t>(weights.first[v]));
  });
  for (std::size_t i = 0; i < hinge.size(); ++i) {
    const std::int32_t to = weights.first[hinge[i]];
    std::copy(means.column.begin() + means.first[i], means.column.begin() + means.first[i + 1],
              weights.column.begin() + to);
    std::copy(means.weight.begin() + means.first[i], means.weight.begin() + means.first[i + 1],
              weights.weight.begin() + to);
  }
}

Coarsened Coarsening::run(bool of_hinges_alone) {
  find_pieces();
  find_vertices();
  interpolate(of_hinges_alone);
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
    for (auto i = static_cast<std::size_t>(first[row]);
         i < static_cast<std::size_t>(first[static_cast<std::size_t>(row) + 1]); ++i) {
      const auto at = static_cast<std::size_t>(next[column[i]]++);
      other.column[at] = row;
      other.weight[at] = weight[i];
    }
  return other;
}

Coarsened coarsen(const CellComplex& fine, Joining joining, ThreadTeam& team, bool of_hinges_alone) {
  return Coarsening(fine, joining, team).run(of_hinges_alone);
}

} // namespace maille::deform
