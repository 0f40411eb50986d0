#include "propagate/wavefront_bounds.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// The cells around a tile's nodes, those of its lower neighbours' last links included.
constexpr int box_edge = tile_edge + 1;
constexpr std::int32_t no_kind = -1;
using Box = std::array<std::array<std::array<std::int32_t, box_edge>, box_edge>, box_edge>; // [z][y][x]

constexpr std::size_t index(int i) {
  return static_cast<std::size_t>(i);
}

/// Kinds of the cells at base - 1 ... base + 7 (along z: + layers - 1).
void kinds_around(const Tiling& tiling, const LinkLimits& limits, const Index3& base, Box& kinds) {
  const Specimen& body = tiling.specimen();
  const Index3& cells = body.grid.cells();
  for (auto& layer : kinds)
    for (auto& row : layer)
      row.fill(no_kind);
  const auto first = [&](int a) { return std::max(0, 1 - base[index(a)]); };
  const auto end = [&](int a, int size) { return std::min(size, cells[index(a)] - base[index(a)] + 1); };
  for (int z = first(2); z < end(2, tiling.layers() + 1); ++z)
    for (int y = first(1); y < end(1, box_edge); ++y) {
      const std::int64_t row = body.grid.cell({0, base[1] + y - 1, base[2] + z - 1}) + base[0] - 1;
      for (int x = first(0); x < end(0, box_edge); ++x)
        if (body.is_matter(row + x))
          kinds[index(z)][index(y)][index(x)] = limits.kind_of(row + x);
    }
}

/// The kind of all cells of the box, if they are all matter of one kind; else no_kind. In 2D the box has no
/// cells below its one layer.
std::int32_t only_kind(const Box& kinds, int layers) {
  const std::size_t first = layers == 1 ? 1 : 0;
  const std::int32_t kind = kinds[first][0][0];
  for (std::size_t z = first; z < index(layers + 1); ++z)
    for (const auto& row : kinds[z])
      for (const std::int32_t other : row)
        if (other != kind)
          return no_kind;
  return kind;
}

/// The bounds that a tile's links get along one axis: those of the tightest of the up to four cells around.
class EdgeBounds {
public:
  /// @param of what a cell of a kind grants; @param none the neutral value; @param tighter std::max or std::min
  template<class Of, class Tighter>
  EdgeBounds(const Box& kinds, int axis, std::int32_t none, const Of& of, const Tighter& tighter) {
    for (std::size_t z = 0; z < box_edge; ++z)
      for (std::size_t y = 0; y < box_edge; ++y)
        for (std::size_t x = 0; x < box_edge; ++x)
          value_[z][y][x] = kinds[z][y][x] == no_kind ? none : of(kinds[z][y][x]);
    // Along the two other axes, the cell before a node and the one after it. In place: from the front.
    if (axis != 2)
      for (std::size_t z = 0; z + 1 < box_edge; ++z)
        for (std::size_t y = 0; y < box_edge; ++y)
          for (std::size_t x = 0; x < box_edge; ++x)
            value_[z][y][x] = tighter(value_[z][y][x], value_[z + 1][y][x]);
    if (axis != 1)
      for (std::size_t z = 0; z < box_edge; ++z)
        for (std::size_t y = 0; y + 1 < box_edge; ++y)
          for (std::size_t x = 0; x < box_edge; ++x)
            value_[z][y][x] = tighter(value_[z][y][x], value_[z][y + 1][x]);
    if (axis != 0)
      for (auto& layer : value_)
        for (auto& row : layer)
          for (std::size_t x = 0; x + 1 < box_edge; ++x)
            row[x] = tighter(row[x], row[x + 1]);
  }
  /// The link along `axis` of the tile's node (x, y, z); `axis` coordinate -1: of the lower neighbour's.
  std::int32_t operator()(int axis, int x, int y, int z) const {
    return value_[index(z + (axis == 2))][index(y + (axis == 1))][index(x + (axis == 0))];
  }

private:
  Box value_;
};

/// Writes the tile's own links along `axis` at `own` and the lower neighbour's last ones at `face`.
void write(const EdgeBounds& bounds, int axis, int layers, std::int32_t* own, std::int32_t* face) {
  for (int z = 0; z < layers; ++z)
    for (int y = 0; y < tile_edge; ++y)
      for (int x = 0; x < tile_edge; ++x) // along x the block is [z][x][y]
        own[tile_layer * z + tile_edge * y + x] = axis == 0 ? bounds(0, y, x, z) : bounds(axis, x, y, z);
  const int rows = axis == 2 ? tile_edge : layers;
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < tile_edge; ++i)
      face[tile_edge * j + i] = axis == 0   ? bounds(0, -1, i, j)
                                : axis == 1 ? bounds(1, i, -1, j)
                                            : bounds(2, i, j, -1);
}

/// Outward, to whole quanta, and no further than matters.
std::int32_t rounded_down(double value) {
  return static_cast<std::int32_t>(std::max(std::floor(value), -static_cast<double>(no_link)));
}
std::int32_t rounded_up(double value) {
  return static_cast<std::int32_t>(std::min(std::ceil(value), static_cast<double>(no_link)));
}

} // namespace

TileBounds::TileBounds(const Tiling& tiling, const LinkLimits& limits, int component, double quantum)
    : tiling_(&tiling), limits_(&limits), component_(component) {
  set_quantum(quantum);
}

void TileBounds::set_quantum(double quantum) {
  quantum_ = quantum;
  blocks_.clear();
  block_of_.assign(index(tiling_->n_tiles()), unknown);
  kind_of_.assign(index(tiling_->n_tiles()), no_kind);
  kinds_.clear();
  kinds_.reserve(limits_->kinds().size());
  const auto axes = static_cast<std::size_t>(tiling_->specimen().grid.dimension());
  double sum = 0;
  for (const LinkLimits::Slack& slack : limits_->kinds()) {
    KindBounds& kind = kinds_.emplace_back();
    kind.low.fill(-no_link);
    kind.high.fill(no_link);
    for (std::size_t a = 0; a < axes; ++a) {
      kind.low[a] = rounded_down(slack.low[a][index(component_)] / quantum);
      kind.high[a] = rounded_up(slack.high[a][index(component_)] / quantum);
      sum += static_cast<double>(kind.high[a]) - static_cast<double>(kind.low[a]);
    }
  }
  mean_length_ = static_cast<std::int32_t>(sum / static_cast<double>(2 * axes * kinds_.size()));
}

const std::int32_t* TileBounds::make_block(std::int32_t tile) {
  Box kinds;
  const int layers = tiling_->layers();
  kinds_around(*tiling_, *limits_, tiling_->base(tile), kinds);
  if (const std::int32_t only = only_kind(kinds, layers); only != no_kind) {
    block_of_[index(tile)] = is_even;
    kind_of_[index(tile)] = only;
    return nullptr;
  }
  block_of_[index(tile)] = static_cast<std::int32_t>(blocks_.size());
  const BlockLayout layout{tiling_->volume()};
  std::int32_t* const block =
      blocks_.emplace_back(hwy::AllocateAligned<std::int32_t>(index(layout.size()))).get();
  for (int a = 0; a < 3; ++a) {
    const auto low = [&](std::int32_t kind) { return kinds_[index(kind)].low[index(a)]; };
    const auto high = [&](std::int32_t kind) { return kinds_[index(kind)].high[index(a)]; };
    const auto larger = [](std::int32_t p, std::int32_t q) { return std::max(p, q); };
    const auto smaller = [](std::int32_t p, std::int32_t q) { return std::min(p, q); };
    write(EdgeBounds(kinds, a, -no_link, low, larger), a, layers, block + layout.low(a),
          block + layout.face_low(a));
    write(EdgeBounds(kinds, a, no_link, high, smaller), a, layers, block + layout.high(a),
          block + layout.face_high(a));
  }
  return block;
}

std::int64_t TileBounds::bytes() const {
  return static_cast<std::int64_t>(kinds_.size() * sizeof(KindBounds) +
                                   block_of_.size() * 2 * sizeof(std::int32_t) +
                                   blocks_.size() * index(layout().size()) * sizeof(std::int32_t));
}

double slack_across(const Grid& grid, const LinkLimits& limits, int component) {
  double sum = 0;
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a) {
    double largest = 0;
    for (const LinkLimits::Slack& slack : limits.kinds())
      largest = std::max({largest, slack.high[a][index(component)], -slack.low[a][index(component)]});
    sum += largest * (grid.nodes()[a] - 1);
  }
  return sum;
}

} // namespace maille::deform
