#include "elastic/masked/masked_matter.hpp"

#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>

namespace maille::deform {

namespace {

/// Up to this many kinds, cells store a one-byte kind (0: no matter) and share a table of coefficients that
/// stays in the cache. Beyond it, each cell has its own coefficients.
constexpr std::size_t most_kinds_in_table = LatticeElasticity::few_kinds;
static_assert(most_kinds_in_table <= std::numeric_limits<std::uint8_t>::max());
/// Layers of cells per work item.
constexpr int layers_per_slab = MaskedRows::planes_per_slab;

} // namespace

MaskedMatter::MaskedMatter(const Scene& scene, const LatticeElasticity& elasticity, Slabs slabs,
                           ThreadTeam& team)
    : scene_(scene), elasticity_(elasticity), slabs_(std::move(slabs)),
      rows_(scene.specimen, slabs_.layers()) {
  operator_.component_stride = stride_of(rows_.n_slots());
  choose_unit();
  set_coefficients(team);
}

/// Calls work(first layer, end) for slabs of layers of cells, as run_slabs() does.
template<class Work>
void MaskedMatter::for_layers(ThreadTeam& team, const Work& work) const {
  const auto [begin, end] = rows_.layers();
  run_slabs(team, begin / layers_per_slab, (end + layers_per_slab - 1) / layers_per_slab, [&](int slab) {
    work(std::max(begin, slab * layers_per_slab), std::min((slab + 1) * layers_per_slab, end));
  });
}

/// Calls visit(place in the run, cell number) for the cells of matter of a run.
template<class Visit>
void MaskedMatter::for_each_cell(const CellRun& run, const Visit& visit) const {
  const std::int64_t first = scene_.specimen.grid.cell(run.first);
  for (int x = 0; x < run.cells; ++x)
    if (scene_.specimen.is_matter(first + x))
      visit(x, first + x);
}

void MaskedMatter::choose_unit() {
  const Vec3& h = scene_.specimen.grid.spacing();
  const double shortest = *std::ranges::min_element(h);
  for (std::size_t a = 0; a < 3; ++a)
    scale_[a] = h[a] / shortest;
  double stiffest = 0;
  for (const LatticeElasticity::Kind& kind : elasticity_.kinds())
    stiffest = std::max(stiffest, kind.largest_mean());
  unit_ = slabs_.largest(stiffest) / (shortest * shortest);
  factors_ = coefficient_factors(h, scale_, unit_);
}

bool MaskedMatter::has_table() const {
  return elasticity_.n_kinds() <= most_kinds_in_table && !elasticity_.has_weights();
}

void MaskedMatter::set_coefficients(ThreadTeam& team) {
  const auto& kinds = elasticity_.kinds();
  operator_.couples_all = false;
  for (const auto& kind : kinds)
    for (int q = 3; q < 6; ++q)
      for (int p = 0; p < q; ++p)
        operator_.couples_all = operator_.couples_all || kind.mean_at(p, q) != 0;
  operator_.couples_all = slabs_.largest(operator_.couples_all ? 1 : 0) > 0;
  for_layers(team, [&](int first_layer, int end_layer) {
    for (CellRun& run : rows_.runs_of_layers(first_layer, end_layer)) {
      run.bends = false;
      for_each_cell(run, [&](int, std::int64_t cell) {
        run.bends = run.bends || kinds[elasticity_.kind_number(cell)].thin != 0;
      });
    }
  });
  if (has_table())
    set_table(team);
  else
    set_own_coefficients(team);
  operator_.coefficients = coefficients_.data();
}

void MaskedMatter::set_table(ThreadTeam& team) {
  const auto& kinds = elasticity_.kinds();
  const std::size_t n_kinds = kinds.size() + 1; // the first is void
  const auto n_cells = static_cast<std::size_t>(rows_.n_cell_slots());
  coefficients_ = AlignedArray<float>(MaskedOperator::most_coefficients * n_kinds);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const CellCoefficients c = coefficients_of(kinds[i]);
    for (std::size_t k = 0; k < c.size(); ++k)
      coefficients_[k * n_kinds + i + 1] = static_cast<float>(c[k]);
  }
  kind_ = AlignedArray<std::uint8_t>(n_cells + MaskedRows::block);
  for_layers(team, [&](int first_layer, int end_layer) {
    for (const CellRun& run : rows_.runs_of_layers(first_layer, end_layer))
      for_each_cell(run, [&](int x, std::int64_t cell) {
        kind_[run.cell_slot + x] = static_cast<std::uint8_t>(elasticity_.kind_number(cell) + 1);
      });
  });
  block_kind_ = AlignedArray<std::uint8_t>(n_cells / MaskedRows::block);
  set_kinds_of_blocks(team);
  operator_.block_kind = block_kind_.data();
  operator_.kind = kind_.data();
  operator_.n_kinds = static_cast<std::int32_t>(n_kinds);
}

void MaskedMatter::set_own_coefficients(ThreadTeam& team) {
  constexpr std::size_t block = MaskedRows::block;
  std::int32_t n_blocks = 0;
  for (CellRun& run : rows_.runs_of_layers(rows_.layers().first, rows_.layers().end)) {
    run.cell_slot = n_blocks;
    n_blocks += run.blocks() * MaskedOperator::coefficients_of(run.bends);
  }
  coefficients_ = AlignedArray<float>(block * static_cast<std::size_t>(n_blocks));
  for_layers(team, [&](int first_layer, int end_layer) {
    for (const CellRun& run : rows_.runs_of_layers(first_layer, end_layer)) {
      const auto n = static_cast<std::size_t>(MaskedOperator::coefficients_of(run.bends));
      float* const of_run = coefficients_.data() + block * static_cast<std::size_t>(run.cell_slot);
      for_each_cell(run, [&](int x, std::int64_t cell) {
        const CellCoefficients c = coefficients_of(elasticity_.kinds()[elasticity_.kind_number(cell)]);
        const auto at = static_cast<std::size_t>(x);
        float* const to = of_run + at / block * n * block + at % block;
        for (std::size_t k = 0; k < n; ++k)
          to[k * block] = static_cast<float>(elasticity_.weight(cell) * c[k]);
      });
    }
  });
}

void MaskedMatter::set_kinds_of_blocks(ThreadTeam& team) {
  for_parts(block_kind_.size(), team, [&](std::size_t first, std::size_t end, std::size_t) {
    for (std::size_t b = first; b < end; ++b) {
      std::uint8_t least = 0, most = 0;
      for (const std::uint8_t kind : kind_.all().subspan(b * MaskedRows::block, MaskedRows::block))
        if (kind > 0) {
          least = least == 0 ? kind : std::min(least, kind);
          most = std::max(most, kind);
        }
      block_kind_[b] = least == most ? most : std::uint8_t{0};
    }
  });
}

void MaskedMatter::invert_diagonal(AlignedArray<float>& inverse, ThreadTeam& team) const {
  const Grid& grid = scene_.specimen.grid;
  const auto n = static_cast<std::size_t>(rows_.n_slots());
  List<double> diagonal(3 * n, 0);
  const auto of_kind = [&](std::size_t kind) {
    const LatticeElasticity::Kind& of = elasticity_.kinds()[kind];
    return cell_diagonal(coefficients_of(of), of.thin != 0);
  };
  std::vector<CellDiagonal> few;
  for (std::size_t kind = 0; kind < elasticity_.kinds().size() && has_table(); ++kind)
    few.push_back(of_kind(kind));
  for_layers(team, [&](int first_layer, int end_layer) {
    for (const CellRun& run : rows_.runs_of_layers(first_layer, end_layer))
      for_each_cell(run, [&](int x, std::int64_t cell) {
        const auto kind = static_cast<std::size_t>(elasticity_.kind_number(cell));
        const CellDiagonal own = few.empty() ? of_kind(kind) : CellDiagonal{};
        const CellDiagonal& of_cell = few.empty() ? own : few[kind];
        const double weight = elasticity_.weight(cell);
        for (std::size_t row = 0; row < 4; ++row) { // of two corners
          double more[6];
          for (std::size_t i = 0; i < 6; ++i)
            more[i] = weight * of_cell[6 * row + i];
          double* const to = diagonal.data() + 3 * static_cast<std::size_t>(run.node_slot[row] + x);
          for (std::size_t i = 0; i < 6; ++i)
            to[i] += more[i];
        }
      });
  });
  for (const NodalSpring& spring : elasticity_.springs())
    for (std::size_t c = 0; c < 3; ++c)
      diagonal[3 * static_cast<std::size_t>(rows_.slot(grid.node_at(spring.node))) + c] +=
          spring.stiffness(static_cast<Eigen::Index>(c), static_cast<Eigen::Index>(c)) /
          (unit_ * scale_[c] * scale_[c]);
  for_parts(n, team, [&](std::size_t first, std::size_t end, std::size_t) {
    for (std::size_t slot = first; slot < end; ++slot)
      for (std::size_t c = 0; c < 3; ++c)
        if (const double value = diagonal[3 * slot + c]; value > 0)
          inverse[c * static_cast<std::size_t>(operator_.component_stride) + slot] =
              static_cast<float>(1 / value);
  });
}

std::int32_t MaskedMatter::slot_if_known(std::int64_t number) const {
  const Index3 node = scene_.specimen.grid.node_at(number);
  const auto [first, end] = rows_.layers();
  const bool is_known = scene_.specimen.is_node(node) && (node[2] > first || first == 0) &&
                        node[2] >= first &&
                        (node[2] < end || (node[2] == end && end == scene_.specimen.grid.cells()[2]));
  return is_known ? rows_.slot(node) : no_index;
}

CellComplex MaskedMatter::complex(ThreadTeam& team) const {
  const int begin = rows_.layers().first, layers = rows_.layers().end - begin;
  std::vector<std::size_t> first(static_cast<std::size_t>(layers) + 1, 0); // of layers
  team.run(layers, [&](int z, int) {
    std::size_t n = 0;
    for (const CellRun& run : rows_.runs_of_layer(begin + z))
      for_each_cell(run, [&](int, std::int64_t) { ++n; });
    first[static_cast<std::size_t>(z) + 1] = n;
  });
  std::partial_sum(first.begin(), first.end(), first.begin());
  CellComplex complex;
  complex.n_vertices = rows_.n_slots();
  complex.cells.resize(first.back());
  team.run(layers, [&](int z, int) {
    std::size_t next = first[z];
    for (const CellRun& run : rows_.runs_of_layer(begin + z))
      for_each_cell(run, [&](int x, std::int64_t) {
        ComplexCell& cell = complex.cells[next++];
        cell.at = {run.first[0] + x, run.first[1], run.first[2]};
        for (int corner = 0; corner < 8; ++corner)
          cell.vertex[corner] = run.node_slot[corner >> 1] + x + (corner & 1);
      });
  });
  return complex;
}

} // namespace maille::deform
