#include "elastic/masked/slabs.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// First planes of slabs of about as much matter each, and the end.
std::vector<int> cuts(const Specimen& body, int n_slabs) {
  const Grid& grid = body.grid;
  const int layers = grid.cells()[2], units = layers / Slabs::planes_per_unit;
  const std::int64_t in_layer = grid.n_cells() / layers;
  std::vector<std::int64_t> before(1, 0); // cells of matter, by unit
  for (int unit = 0; unit < units; ++unit) {
    const int first = unit * Slabs::planes_per_unit,
              end = unit + 1 == units ? layers : first + Slabs::planes_per_unit;
    std::int64_t n = before.back();
    for (std::int64_t cell = first * in_layer; cell < end * in_layer; ++cell)
      n += body.is_matter(cell) ? 1 : 0;
    before.push_back(n);
  }
  std::vector<int> first(1, 0);
  for (int slab = 1; slab < n_slabs; ++slab) {
    const auto near = static_cast<int>(
        std::ranges::lower_bound(before, before.back() * slab / n_slabs) - before.begin());
    const int unit = std::clamp(near, first.back() / Slabs::planes_per_unit + 1, units - n_slabs + slab);
    first.push_back(unit * Slabs::planes_per_unit);
  }
  first.push_back(layers + 1);
  return first;
}

} // namespace

Slabs::Slabs(const Specimen& body, Communicator* all) : all_(all), first_{0, body.grid.nodes()[2]} {
  if (all_ != nullptr)
    first_ = cuts(body, all_->size());
}

LayerRange Slabs::layers() const {
  return {std::max(0, own().first - layers_below), std::min(n_planes() - 1, own().end + layers_above)};
}

LayerRange Slabs::layers_of_own() const {
  return {std::max(0, own().first - 1), std::min(n_planes() - 1, own().end)};
}

double Slabs::total(std::span<const double> of_own) const {
  if (!are_shared())
    return std::accumulate(of_own.begin(), of_own.end(), 0.0);
  std::vector<double> numbers(static_cast<std::size_t>(n_planes()));
  const auto of_rank = [&](int rank) {
    const PlaneRange planes = own_of(rank);
    return std::as_writable_bytes(std::span(numbers).subspan(
        static_cast<std::size_t>(planes.first), static_cast<std::size_t>(planes.end - planes.first)));
  };
  std::ranges::copy(of_own, numbers.begin() + own().first);
  std::vector<Communicator::Part> to, from;
  for (int other = 0; other < all_->size(); ++other)
    if (other != rank()) {
      to.push_back({other, of_rank(rank())});
      from.push_back({other, of_rank(other)});
    }
  all_->exchange(to, from);
  return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

std::vector<double> Slabs::of_ranks(double of_own) const {
  return are_shared() ? from_every_rank(*all_, of_own) : std::vector<double>(1, of_own);
}

double Slabs::largest(double of_own) const {
  return std::ranges::max(of_ranks(of_own));
}

double Slabs::sum(double of_own) const {
  const std::vector<double> numbers = of_ranks(of_own);
  return std::accumulate(numbers.begin(), numbers.end(), 0.0);
}

std::pair<std::int64_t, std::int64_t> Slabs::before_and_all(std::int64_t of_own) const {
  const std::vector<double> numbers = of_ranks(static_cast<double>(of_own));
  return {static_cast<std::int64_t>(std::accumulate(numbers.begin(), numbers.begin() + rank(), 0.0)),
          static_cast<std::int64_t>(std::accumulate(numbers.begin(), numbers.end(), 0.0))};
}

void Slabs::gather_planes(std::span<double> field) const {
  if (!are_shared())
    return;
  const std::size_t in_plane = field.size() / static_cast<std::size_t>(n_planes());
  std::vector<Communicator::Part> to, from;
  for (int other = 1; other < all_->size(); ++other) {
    const PlaneRange planes = own_of(other);
    const auto of_rank =
        std::as_writable_bytes(field.subspan(static_cast<std::size_t>(planes.first) * in_plane,
                                             static_cast<std::size_t>(planes.end - planes.first) * in_plane));
    if (is_first())
      from.push_back({other, of_rank});
    else if (other == rank())
      to.push_back({0, of_rank});
  }
  all_->exchange(to, from);
}

void Slabs::exchange_borders(const MaskedRows& rows, std::int64_t stride, float* field) const {
  if (!are_shared())
    return;
  struct Border {
    int rank, own, other; ///< planes
    std::vector<float> out, in;
  };
  std::vector<Border> borders;
  if (rank() > 0)
    borders.push_back({rank() - 1, own().first, own().first - 1, {}, {}});
  if (!is_last())
    borders.push_back({rank() + 1, own().end - 1, own().end, {}, {}});
  const auto for_rows = [&](int plane, const auto& visit) {
    const auto n = static_cast<std::size_t>(rows.first_slot(plane + 1) - rows.first_slot(plane));
    for (std::size_t c = 0; c < 3; ++c)
      visit(c * n, n, field + static_cast<std::int64_t>(c) * stride + rows.first_slot(plane));
    return 3 * n;
  };
  std::vector<Communicator::Part> to, from;
  for (Border& border : borders) {
    border.out.resize(for_rows(border.own, [](std::size_t, std::size_t, const float*) {}));
    border.in.resize(for_rows(border.other, [](std::size_t, std::size_t, const float*) {}));
    for_rows(border.own, [&](std::size_t at, std::size_t n, const float* row) {
      std::copy_n(row, n, border.out.data() + at);
    });
    to.push_back({border.rank, bytes_of(border.out)});
    from.push_back({border.rank, bytes_of(border.in)});
  }
  all_->exchange(to, from);
  for (const Border& border : borders)
    for_rows(border.other, [&](std::size_t at, std::size_t n, float* row) {
      std::copy_n(border.in.data() + at, n, row);
    });
}

/// Vertices have numbers in the order of the first pieces that have them, so of what is known alike on two
/// ranks they differ by as much as there are on earlier ranks.
SharedPieces::SharedPieces(const Slabs& slabs, const Coarsened& coarsened)
    : slabs_(slabs),
      field_(block_stride * static_cast<std::size_t>(coarsened.complex.n_vertices) + 16) {
  const auto& cells = coarsened.complex.cells;
  const PlaneRange own = slabs.own_coarse();
  const auto first_from = [&](int plane) {
    return static_cast<std::size_t>(
        std::ranges::lower_bound(cells, plane, {}, [](const ComplexCell& c) { return c.at[2]; }) -
        cells.begin());
  };
  first_known_ = first_from(own.first - 1);
  first_piece_ = first_from(own.first);
  end_piece_ = first_from(own.end);
  const auto vertices_until = [&](std::size_t end) {
    std::int32_t n = 0;
    for (std::size_t i = 0; i < end; ++i)
      n = std::max(n, *std::ranges::max_element(cells[i].vertex) + 1);
    return n;
  };
  of_earlier_ = vertices_until(first_piece_);
  const auto [before, all] = slabs.before_and_all(vertices_until(end_piece_) - of_earlier_);
  first_vertex_ = static_cast<std::int32_t>(before);
  n_vertices_ = static_cast<std::int32_t>(all);
  List<std::uint8_t> place(static_cast<std::size_t>(coarsened.complex.n_vertices), 0); // bits: row, needed
  for (const ComplexCell& cell : cells) {
    std::ranges::copy(cell.vertex, pieces_.emplace_back().vertex);
    for (int corner = 0; corner < 8; ++corner) {
      const int plane = cell.at[2] + (corner >> 2);
      place[static_cast<std::size_t>(cell.vertex[corner])] = static_cast<std::uint8_t>(
          (plane >= own.first && plane < own.end ? 1 : 0) | (plane >= own.first && plane <= own.end ? 2 : 0));
    }
  }
  List<std::int32_t> rows, needed; // in the first rank's numbers
  for (std::int32_t v = 0; v < coarsened.complex.n_vertices; ++v) {
    const std::uint8_t of = place[static_cast<std::size_t>(v)];
    if ((of & 1) != 0) {
      rows_.push_back(v);
      rows.push_back(number(v));
    }
    if ((of & 2) != 0) {
      needed_.push_back(v);
      needed.push_back(number(v));
    }
  }
  rows_of_ = slabs.gather(rows);
  needed_of_ = slabs.gather(needed);
}

CellComplex SharedPieces::complex(const Coarsened& coarsened) const {
  List<ComplexCell> own(coarsened.complex.cells.begin() + static_cast<std::ptrdiff_t>(first_piece_),
                        coarsened.complex.cells.begin() + static_cast<std::ptrdiff_t>(end_piece_));
  for (ComplexCell& cell : own)
    for (std::int32_t& vertex : cell.vertex)
      vertex = number(vertex);
  CellComplex complex;
  complex.n_vertices = slabs_.is_first() ? n_vertices_ : 0;
  for (List<ComplexCell>& cells : slabs_.gather(own)) {
    complex.cells.insert(complex.cells.end(), cells.begin(), cells.end());
    cells = {};
  }
  return complex;
}

List<std::uint64_t> SharedPieces::gather(const List<std::uint64_t>& of_known) const {
  const List<std::uint64_t> own(of_known.begin() + static_cast<std::ptrdiff_t>(first_piece_ - first_known_),
                                of_known.end());
  List<std::uint64_t> whole;
  for (const List<std::uint64_t>& numbers : slabs_.gather(own))
    whole.insert(whole.end(), numbers.begin(), numbers.end());
  return whole;
}

BlockMatrix SharedPieces::gather(const BlockMatrix& A) const {
  List<std::int32_t> length, column;
  for (const std::int32_t row : rows_) {
    const auto v = static_cast<std::size_t>(row);
    length.push_back(A.first[v + 1] - A.first[v]);
    for (std::int32_t i = A.first[v]; i < A.first[v + 1]; ++i)
      column.push_back(number(A.column[static_cast<std::size_t>(i)]));
  }
  BlockMatrix whole;
  whole.first.assign(1, 0);
  const auto lengths = slabs_.gather(length);
  if (slabs_.is_first()) {
    whole.first.assign(static_cast<std::size_t>(n_vertices_) + 1, 0);
    for (std::size_t rank = 0; rank < lengths.size(); ++rank)
      for (std::size_t i = 0; i < lengths[rank].size(); ++i)
        whole.first[static_cast<std::size_t>(rows_of_[rank][i]) + 1] = lengths[rank][i];
    std::partial_sum(whole.first.begin(), whole.first.end(), whole.first.begin());
    whole.column.resize(static_cast<std::size_t>(whole.first.back()));
    whole.blocks = AlignedArray<float>(9 * whole.column.size() + 16);
  }
  /// Calls put(place in the matrix, place in the list) for all blocks of a rank's rows.
  const auto for_each_block = [&](std::size_t rank, const auto& put) {
    std::size_t from = 0;
    for (const std::int32_t row : rows_of_[rank])
      for (std::int32_t to = whole.first[static_cast<std::size_t>(row)];
           to < whole.first[static_cast<std::size_t>(row) + 1]; ++to)
        put(static_cast<std::size_t>(to), from++);
  };
  const auto columns = slabs_.gather(column);
  for (std::size_t rank = 0; rank < columns.size(); ++rank)
    for_each_block(rank, [&](std::size_t to, std::size_t from) { whole.column[to] = columns[rank][from]; });
  // The first rank has those of one rank beside the matrix, not those of all.
  const auto blocks_of = [&](std::size_t row, const BlockMatrix& of) {
    const auto v = static_cast<std::size_t>(rows_[row]);
    return std::span(of.blocks.data() + 9 * static_cast<std::size_t>(of.first[v]),
                     9 * static_cast<std::size_t>(of.first[v + 1] - of.first[v]));
  };
  List<float> blocks;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    const auto of_row = blocks_of(row, A);
    blocks.insert(blocks.end(), of_row.begin(), of_row.end());
  }
  for (int rank = 0; rank < slabs_.ranks().size(); ++rank) {
    const auto at = static_cast<std::size_t>(rank);
    if (slabs_.is_first() && rank > 0) {
      blocks.assign(9 * columns[at].size(), 0);
      const Communicator::Part from{rank, bytes_of(blocks)};
      slabs_.ranks().exchange({}, std::span(&from, 1));
    } else if (rank > 0 && rank == slabs_.ranks().rank()) {
      const Communicator::Part to{0, bytes_of(blocks)};
      slabs_.ranks().exchange(std::span(&to, 1), {});
    }
    if (slabs_.is_first())
      for_each_block(at, [&](std::size_t to, std::size_t from) {
        std::copy_n(blocks.data() + 9 * from, 9, whole.blocks.data() + 9 * to);
      });
  }
  return whole;
}

List<float> SharedPieces::values_at(const List<std::int32_t>& vertices, const float* field) const {
  List<float> values(block_stride * vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i)
    std::copy_n(field + std::int64_t{block_stride} * vertices[i], block_stride,
                values.data() + block_stride * i);
  return values;
}

namespace {

void put_values(const List<float>& values, const List<std::int32_t>& vertices, float* field) {
  for (std::size_t i = 0; i < vertices.size(); ++i)
    std::copy_n(values.data() + block_stride * i, block_stride,
                field + std::int64_t{block_stride} * vertices[i]);
}

} // namespace

void SharedPieces::collect(float* f) {
  const auto of_ranks = slabs_.gather(values_at(rows_, field_.data()));
  for (std::size_t rank = 0; rank < of_ranks.size(); ++rank)
    put_values(of_ranks[rank], rows_of_[rank], f);
}

void SharedPieces::hand_out(const float* u) {
  List<float> own(block_stride * needed_.size());
  std::vector<List<float>> out;
  out.reserve(needed_of_.size()); // messages know where they lie
  std::vector<Communicator::Part> to, from;
  for (std::size_t rank = 0; rank < needed_of_.size(); ++rank) {
    out.push_back(values_at(needed_of_[rank], u));
    if (rank > 0)
      to.push_back({static_cast<int>(rank), bytes_of(out.back())});
  }
  if (!slabs_.is_first())
    from.push_back({0, bytes_of(own)});
  slabs_.ranks().exchange(to, from);
  put_values(slabs_.is_first() ? out.front() : own, needed_, field_.data());
}

} // namespace maille::deform
