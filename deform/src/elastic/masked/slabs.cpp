#include "elastic/masked/slabs.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>

namespace maille::deform {

namespace {

/// First planes of slabs with about equal matter, and the end.
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
    const auto near =
        static_cast<int>(std::ranges::lower_bound(before, before.back() * slab / n_slabs) - before.begin());
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
  std::vector<double> numbers(n_planes());
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

std::vector<double> Slabs::first_of_ranks(double of_own) const {
  const std::vector<double> numbers = of_ranks(of_own);
  std::vector<double> first(1, 0);
  std::partial_sum(numbers.begin(), numbers.end(), std::back_inserter(first));
  return first;
}

Slabs Slabs::of_pieces() const {
  Slabs pieces = *this;
  for (int& first : pieces.first_)
    first /= 2; // n layers have n + 1 planes, and (n + 1) / 2 planes of pieces
  return pieces;
}

void Slabs::gather_planes(std::span<double> of_own, std::span<double> of_all) const {
  std::vector<Communicator::Part> to, from;
  if (is_first()) {
    std::ranges::copy(of_own, of_all.begin());
    const std::size_t in_plane = of_all.size() / static_cast<std::size_t>(n_planes());
    for (int other = 1; other < all_->size(); ++other) {
      const PlaneRange planes = own_of(other);
      from.push_back({other, std::as_writable_bytes(of_all.subspan(
                                 static_cast<std::size_t>(planes.first) * in_plane,
                                 static_cast<std::size_t>(planes.end - planes.first) * in_plane))});
    }
  } else
    to.push_back({0, std::as_writable_bytes(of_own)});
  all_->exchange(to, from);
}

void Slabs::exchange_borders(const MaskedRows& rows, std::int64_t stride, float* field, int above) const {
  if (!are_shared())
    return;
  struct Border {
    int rank;
    PlaneRange own, other;
    std::vector<float> out, in;
  };
  std::vector<Border> borders;
  const auto [first, end] = own();
  if (rank() > 0)
    borders.push_back({rank() - 1, {first, first + above}, {first - 1, first}, {}, {}});
  if (!is_last())
    borders.push_back({rank() + 1, {end - 1, end}, {end, end + above}, {}, {}});
  const auto for_rows = [&](PlaneRange planes, const auto& visit) {
    const std::int32_t slot = rows.first_slot(planes.first);
    const auto n = static_cast<std::size_t>(rows.first_slot(planes.end) - slot);
    for (std::size_t c = 0; c < 3; ++c)
      visit(c * n, n, field + static_cast<std::int64_t>(c) * stride + slot);
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
    for_rows(border.other,
             [&](std::size_t at, std::size_t n, float* row) { std::copy_n(border.in.data() + at, n, row); });
}

namespace {

std::size_t first_of_plane(const List<ComplexCell>& pieces, int plane) {
  return static_cast<std::size_t>(
      std::ranges::lower_bound(pieces, plane, {}, [](const ComplexCell& c) { return c.at[2]; }) -
      pieces.begin());
}

} // namespace

List<std::int64_t> first_entries_of_planes(const List<ComplexCell>& pieces, PlaneRange planes) {
  List<std::int64_t> first;
  std::int64_t vertices = 0;
  std::size_t next = 0;
  for (int plane = planes.first; plane <= planes.end; ++plane) {
    for (const std::size_t end = first_of_plane(pieces, plane); next < end; ++next)
      vertices = std::max(vertices, std::int64_t{*std::ranges::max_element(pieces[next].vertex)} + 1);
    first.push_back(block_stride * vertices);
  }
  return first;
}

/// Local numbers of two ranks differ by the number of vertices of earlier ranks.
SharedPieces::SharedPieces(const Slabs& slabs, const Coarsened& coarsened)
    : slabs_(slabs), pieces_(slabs.of_pieces()) {
  const List<ComplexCell>& cells = coarsened.complex.cells;
  const PlaneRange own = pieces_.own();
  own_ = {first_of_plane(cells, own.first), first_of_plane(cells, own.end)};
  known_ = {first_of_plane(cells, own.first - 1), first_of_plane(cells, own.end + 1)};
  parts_ = first_entries_of_planes(cells, own);
  of_earlier_ = static_cast<std::int32_t>(parts_.front() / block_stride);
  n_own_ = static_cast<std::int32_t>(parts_.back() / block_stride) - of_earlier_;
  first_of_rank_ = slabs.first_of_ranks(n_own_);
  first_vertex_ = static_cast<std::int32_t>(first_of_rank_[slabs.rank()]);
  n_vertices_ = static_cast<std::int32_t>(first_of_rank_.back());
  const auto around = first_entries_of_planes(cells, {own.first - 2, own.end + 2});
  below_ = slabs.of_ranks(of_earlier_ - static_cast<double>(around.front() / block_stride));
  above_ = slabs.of_ranks(
      slabs.is_last() ? 0 : static_cast<double>((around.back() - parts_.back()) / block_stride));
}

CellComplex SharedPieces::complex(const Coarsened& coarsened) const {
  const auto cells = coarsened.complex.cells.begin();
  List<ComplexCell> own(cells + static_cast<std::ptrdiff_t>(own_.first),
                        cells + static_cast<std::ptrdiff_t>(own_.second));
  for (ComplexCell& cell : own)
    for (std::int32_t& vertex : cell.vertex)
      vertex = number(vertex);
  CellComplex complex;
  complex.n_vertices = slabs_.is_first() ? n_vertices_ : 0;
  for (List<ComplexCell>& of_rank : slabs_.gather(own)) {
    complex.cells.insert(complex.cells.end(), of_rank.begin(), of_rank.end());
    of_rank = {};
  }
  return complex;
}

List<std::uint64_t> SharedPieces::gather(const List<std::uint64_t>& of_known) const {
  const auto first = of_known.begin() + static_cast<std::ptrdiff_t>(own_.first - known_.first);
  const List<std::uint64_t> own(first, first + static_cast<std::ptrdiff_t>(own_.second - own_.first));
  List<std::uint64_t> whole;
  for (const List<std::uint64_t>& numbers : slabs_.gather(own))
    whole.insert(whole.end(), numbers.begin(), numbers.end());
  return whole;
}

BlockMatrix SharedPieces::gather(const BlockMatrix& A) const {
  const auto begin = static_cast<std::size_t>(of_earlier_), n = static_cast<std::size_t>(n_own_);
  const auto at = static_cast<std::size_t>(A.first[begin]),
             n_blocks = static_cast<std::size_t>(A.first[begin + n]) - at;
  BlockMatrix whole;
  List<std::int32_t> numbers(n);
  for (std::size_t i = 0; i < n; ++i)
    numbers[i] = A.first[begin + i + 1] - A.first[begin + i];
  whole.first.assign(1, 0);
  for (const List<std::int32_t>& lengths : slabs_.gather(numbers))
    for (const std::int32_t length : lengths)
      whole.first.push_back(whole.first.back() + length);
  whole.column.reserve(whole.first.back());
  numbers.resize(n_blocks);
  for (std::size_t i = 0; i < n_blocks; ++i)
    numbers[i] = number(A.column[at + i]);
  for (List<std::int32_t>& columns : slabs_.gather(numbers)) {
    whole.column.insert(whole.column.end(), columns.begin(), columns.end());
    columns = {};
  }
  const std::span<float> own(const_cast<float*>(A.blocks.data()) + 9 * at, 9 * n_blocks); // is only read
  std::vector<Communicator::Part> to, from;
  if (slabs_.is_first()) {
    whole.blocks = AlignedArray<float>(9 * whole.column.size() + 16);
    std::ranges::copy(own, whole.blocks.begin());
    for (int rank = 1; rank < slabs_.ranks().size(); ++rank) {
      const auto row = [&](int of) { return static_cast<std::size_t>(first_of_rank_[of]); };
      const auto first = static_cast<std::size_t>(whole.first[row(rank)]),
                 end = static_cast<std::size_t>(whole.first[row(rank + 1)]);
      from.push_back(
          {rank, std::as_writable_bytes(whole.blocks.all().subspan(9 * first, 9 * (end - first)))});
    }
  } else
    to.push_back({0, std::as_writable_bytes(own)});
  slabs_.ranks().exchange(to, from);
  return whole;
}

void SharedPieces::exchange_borders(float* field) const {
  const auto part = [&](int rank, std::int32_t first, double n) {
    return Communicator::Part{rank,
                              std::as_writable_bytes(std::span(field + std::int64_t{block_stride} * first,
                                                               block_stride * static_cast<std::size_t>(n)))};
  };
  const int rank = slabs_.rank();
  const auto own = static_cast<std::size_t>(rank);
  const std::int32_t end = of_earlier_ + n_own_;
  std::vector<Communicator::Part> to, from;
  if (rank > 0) {
    to.push_back(part(rank - 1, of_earlier_, above_[own - 1]));
    from.push_back(part(rank - 1, of_earlier_ - static_cast<std::int32_t>(below_[own]), below_[own]));
  }
  if (!slabs_.is_last()) {
    to.push_back(part(rank + 1, end - static_cast<std::int32_t>(below_[own + 1]), below_[own + 1]));
    from.push_back(part(rank + 1, end, above_[own]));
  }
  slabs_.ranks().exchange(to, from);
}

namespace {

/// The entries of ranks in a field of all.
std::vector<Communicator::Part> parts_of_others(const std::vector<double>& first_of_rank, float* of_all) {
  std::vector<Communicator::Part> parts;
  for (std::size_t rank = 1; rank + 1 < first_of_rank.size(); ++rank) {
    const auto first = static_cast<std::size_t>(first_of_rank[rank]),
               end = static_cast<std::size_t>(first_of_rank[rank + 1]);
    parts.push_back(
        {static_cast<int>(rank),
         std::as_writable_bytes(std::span(of_all + block_stride * first, block_stride * (end - first)))});
  }
  return parts;
}

} // namespace

void SharedPieces::collect(const float* field, float* of_all) const {
  float* const own = const_cast<float*>(field) + std::int64_t{block_stride} * of_earlier_; // is only read
  const std::size_t n = block_stride * static_cast<std::size_t>(n_own_);
  const Communicator::Part part{0, std::as_writable_bytes(std::span(own, n))};
  if (slabs_.is_first()) {
    std::copy_n(own, n, of_all);
    slabs_.ranks().exchange({}, parts_of_others(first_of_rank_, of_all));
  } else
    slabs_.ranks().exchange(std::span(&part, 1), {});
}

void SharedPieces::hand_out(const float* of_all, float* field) const {
  float* const own = field + std::int64_t{block_stride} * of_earlier_;
  const std::size_t n = block_stride * static_cast<std::size_t>(n_own_);
  const Communicator::Part part{0, std::as_writable_bytes(std::span(own, n))};
  if (slabs_.is_first()) {
    std::copy_n(of_all, n, own);
    slabs_.ranks().exchange(parts_of_others(first_of_rank_, const_cast<float*>(of_all)), {});
  } else
    slabs_.ranks().exchange({}, std::span(&part, 1));
}

} // namespace maille::deform
