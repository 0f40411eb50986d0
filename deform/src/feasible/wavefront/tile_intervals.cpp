#include "feasible/wavefront/tile_intervals.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

constexpr std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// The kinds of the cells at base - 1 ... base + 7 (along z: + layers - 1).
CellBox kinds_around(const Tiling& tiling, const LinkLimits& limits, const Index3& base) {
  const Specimen& body = tiling.specimen();
  const Index3& cells = body.grid.cells();
  const bool is_homogeneous = limits.is_homogeneous();
  CellBox box{};
  const auto first = [&](int a) { return std::max(0, 1 - base[index(a)]); };
  const auto end = [&](int a, int size) { return std::min(size, cells[index(a)] - base[index(a)] + 1); };
  for (int z = first(2); z < end(2, tiling.layers() + 1); ++z)
    for (int y = first(1); y < end(1, CellBox::edge); ++y) {
      CellBox::Row& row = box.kind[index(z)][index(y)];
      const std::int64_t cell = body.grid.cell({0, base[1] + y - 1, base[2] + z - 1}) + base[0] - 1;
      for (int x = first(0); x < end(0, CellBox::edge); ++x)
        if (body.is_matter(cell + x))
          row[index(x)] = is_homogeneous ? 1 : 1 + limits.kind_of(cell + x);
    }
  return box;
}

/// The kind of all cells of the box, if they are all matter of one kind; else 0. In 2D the box has no
/// cells below its one layer.
std::int32_t only_kind(const CellBox& box, int layers) {
  const std::size_t first = layers == 1 ? 1 : 0;
  const std::int32_t kind = box.kind[first][0][0];
  for (std::size_t z = first; z < index(layers + 1); ++z)
    for (const CellBox::Row& row : box.kind[z])
      for (std::size_t x = 0; x < CellBox::edge; ++x)
        if (row[x] != kind)
          return 0;
  return kind;
}

/// Outward, to whole quanta, and no further than matters.
std::int32_t rounded_down(double value) {
  return static_cast<std::int32_t>(std::max(std::floor(value), -static_cast<double>(no_link)));
}
std::int32_t rounded_up(double value) {
  return static_cast<std::int32_t>(std::min(std::ceil(value), static_cast<double>(no_link)));
}

/// The mean slack of links, one way [m], from a sample of one or a few hundred nodes.
double mean_slack(const Tiling& tiling, const LinkLimits& limits, int component) {
  constexpr std::int32_t sample = 200;
  double sum = 0;
  int n = 0;
  for (std::int32_t t = 0; t < tiling.n_tiles(); t += 1 + tiling.n_tiles() / sample) {
    const Index3& base = tiling.base(t);
    for (int axis = 0; axis < tiling.specimen().grid.dimension(); ++axis) {
      // Any node will do, as long as it is not always the corner that blocks of matter may start at.
      const Index3 at{base[0] + t % 3, base[1] + t % 5, base[2] + t % std::min(7, tiling.layers())};
      if (const auto link = limits.intervals(at, axis)) {
        sum += link->high[index(component)] - link->low[index(component)];
        n += 2;
      }
    }
  }
  return n == 0 ? 0 : sum / n;
}

} // namespace

TileIntervals::TileIntervals(const Tiling& tiling, const LinkLimits& limits, int component, double quantum)
    : tiling_(&tiling), limits_(&limits), component_(component),
      mean_slack_(mean_slack(tiling, limits, component)), fill_block_(best_fill_block()) {
  set_quantum(quantum);
}

void TileIntervals::set_quantum(double quantum) {
  quantum_ = quantum;
  blocks_.clear();
  block_of_.assign(index(tiling_->n_tiles()), unknown);
  kind_of_.assign(index(tiling_->n_tiles()), 0);
  const auto axes = static_cast<std::size_t>(tiling_->specimen().grid.dimension());
  const auto b = index(component_);
  for (std::size_t a = 0; a < 3; ++a) {
    auto &low = of_kind_.low[a], &high = of_kind_.high[a];
    for (auto* const of_kind : {&low, &high})
      of_kind->reserve(1 + limits_->kinds().size());
    low.assign(1, -no_link);
    high.assign(1, no_link);
    for (const LinkLimits::OfCell& cell : limits_->kinds()) { // no links along axes that the scene has not
      low.push_back(a < axes ? rounded_down(cell[a].low[b] / quantum) : -no_link);
      high.push_back(a < axes ? rounded_up(cell[a].high[b] / quantum) : no_link);
    }
  }
  mean_length_ = static_cast<std::int32_t>(std::min(mean_slack_ / quantum, static_cast<double>(no_link)));
}

const std::int32_t* TileIntervals::make_block(std::int32_t tile) {
  const int layers = tiling_->layers();
  const CellBox box = kinds_around(*tiling_, *limits_, tiling_->base(tile));
  if (const std::int32_t only = only_kind(box, layers); only != 0) {
    block_of_[index(tile)] = is_even;
    kind_of_[index(tile)] = only;
    return nullptr;
  }
  block_of_[index(tile)] = static_cast<std::int32_t>(blocks_.size());
  const auto size = index(layout().size());
  std::int32_t* const block = blocks_.emplace_back(size).data();
  LinkIntervals<const std::int32_t*> of_kinds;
  for (std::size_t a = 0; a < 3; ++a) {
    of_kinds.low[a] = of_kind_.low[a].data();
    of_kinds.high[a] = of_kind_.high[a].data();
  }
  fill_block_(box, of_kinds, layers, block);
  return block;
}

double slack_across(const Grid& grid, const LinkLimits& limits, int component) {
  double sum = 0;
  for (int a = 0; a < grid.dimension(); ++a) {
    double largest = 0;
    for (const LinkLimits::OfCell& cell : limits.kinds())
      largest = std::max({largest, cell[a].high[index(component)], -cell[a].low[index(component)]});
    sum += largest * (grid.nodes()[a] - 1);
  }
  return sum;
}

} // namespace maille::deform
