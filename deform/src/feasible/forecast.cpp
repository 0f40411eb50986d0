#include "feasible/forecast.hpp"

#include "control/method.hpp"
#include "feasible/bounds/algorithm_sizes.hpp"
#include "feasible/box/scan_kernel.hpp"
#include "feasible/wavefront/tile_intervals.hpp"
#include "lattice/body.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <iterator>

namespace maille::deform {

namespace {

// Bytes. Checked against the heap by tests/deform/feasible/footprint_test.cpp.
constexpr std::int64_t of_request = 256, // a prescribed value, and what clipping knows of it
    of_fixed_size = 16384,               // engines, lists of a few entries and the heads of arrays
    of_link_list = 128;                  // a component: an entry in the list of blocks, which doubles
// Bytes of what TileField, TileQueue, TileIntervals and Tiling hold; per component but for a tile itself.
constexpr std::int64_t of_number = sizeof(std::int32_t),            // a value, a tile, a bound: in quanta
    of_tile = sizeof(Index3) + sizeof(std::array<std::int32_t, 6>), // place, neighbours
    of_tile_order = of_number * 4 + sizeof(bool),                   // queue: next, previous, bucket; recorded
    of_tile_links = of_number + of_number,                          // number of its block and of its kind
    of_links = sizeof(LinkIntervals<std::int32_t>),                 // of a kind, or of a node of a block
    of_faces = of_links * tile_edge * tile_edge;                    // of a block: links to other tiles

std::int64_t n_prescribed(const Scene& scene) {
  return std::ssize(scene.prescribed);
}

std::int64_t n_moving_components(const Scene& scene) {
  std::int64_t n = 0; // others visit no tile
  for (int b = 0; b < scene.dimension(); ++b)
    n += std::ranges::any_of(scene.prescribed,
                             [&](const Prescribed& p) { return p.component == b && p.value != 0; });
  return n;
}

Footprint forecast_of_moves_of_tiles(const Scene& scene) {
  const std::int64_t tiles = Tiling::n_tiles_of(scene.specimen), d = n_moving_components(scene),
                     volume = Tiling::volume_for(scene.specimen);
  return {{"link tables", d * tiles * (of_links * volume + of_faces + of_link_list),
           "at most: of tiles at the surface and where kinds meet, once visited"},
          {"clipping", d * tiles * (of_number * volume + of_tile_order),
           "at most: where requests must be cut back"}};
}

/// Rows are rounded up to whole blocks of nodes.
std::int64_t padded(std::int64_t nodes) {
  return (nodes + nodes_per_block - 1) / nodes_per_block * nodes_per_block;
}

std::int64_t bytes_of_slab(const Grid& grid) {
  return (padded(grid.nodes()[0]) + nodes_per_block) * (grid.nodes()[1] + 3) * std::int64_t{sizeof(double)};
}

std::int64_t bytes_of_rows(const Grid& grid) {
  return grid.dimension() * padded(grid.nodes()[0]) * std::int64_t{sizeof(double)};
}

Footprint forecast_of_box(const Scene& scene, const std::array<Algorithm, 3>& algorithms, int threads) {
  const Grid& grid = scene.specimen.grid;
  Footprint arrays{{"cone rows", bytes_of_rows(grid), "what paths add up to along one row, per component"}};
  const bool clips_by_scans = n_prescribed(scene) * n_prescribed(scene) > 8 * grid.n_nodes(),
             scans = std::ranges::find(algorithms, Algorithm::separable_scans) != algorithms.end();
  const std::int64_t n_teams = useful_threads(grid.n_nodes(), threads),
                     slabs = (scans ? 2 * n_teams : 0) + (clips_by_scans ? 1 : 0);
  if (slabs > 0)
    arrays.push_back({"scan slabs", slabs * bytes_of_slab(grid) + 5 * bytes_of_rows(grid),
                      "two bounds for one slab a thread, and one for clipping"});
  return arrays;
}

} // namespace

Footprint forecast_of_tiles(const Scene& scene, const LinkLimits& limits) {
  const std::int64_t d = scene.dimension(), tiles = Tiling::n_tiles_of(scene.specimen),
                     volume = Tiling::volume_for(scene.specimen), kinds = std::ssize(limits.kinds()) + 1;
  return {{"wavefront tiles", tiles * of_tile + Tiling::n_places(scene.specimen) * 4 + tiles * volume / 8,
           fmt::format("{} tiles of {} nodes: place, neighbours, one bit a node", tiles, volume)},
          {"displacement", d * tiles * volume * of_number,
           fmt::format("{} components of 32 bits a node of a tile", d)},
          {"tile queue", d * tiles * of_tile_order, "order, changes, and what to take back, per component"},
          {"bounds of kinds", d * (tiles * of_tile_links + kinds * of_links),
           fmt::format("{} kinds of cells, and which a tile is of", kinds - 1)},
          {"components", of_fixed_size, "everything of fixed size"}};
}

Footprint forecast_of_drag(const Scene& scene, const LinkLimits& limits) {
  if (!limits.is_homogeneous())
    return forecast_of_tiles(scene, limits);
  Footprint arrays = Body::footprint(scene);
  arrays.push_back({"cone rows", bytes_of_rows(scene.specimen.grid) / 2,
                    "what paths add up to along one row, per component"});
  arrays.push_back({"engine", of_fixed_size, "everything of fixed size"});
  return arrays;
}

Footprint forecast_of_limits(const Scene& scene, const LinkLimits& limits,
                             const std::array<Algorithm, 3>& algorithms, int threads) {
  const auto goes = [&](Algorithm algorithm) {
    return std::ranges::find(algorithms, algorithm) != algorithms.end();
  };
  const Grid& grid = scene.specimen.grid;
  Footprint arrays;
  if (goes(Algorithm::wavefront)) {
    arrays = forecast_of_tiles(scene, limits);
    std::ranges::move(forecast_of_moves_of_tiles(scene), std::back_inserter(arrays));
  } else if (goes(Algorithm::dijkstra)) {
    const std::int64_t lengths = 2 * grid.n_nodes() * std::int64_t{sizeof(double)};
    arrays = {{"path lengths", lengths, "from above and from below, float64 a grid point"},
              {"path queue", bytes_of_two_envelopes(scene) - lengths, "at most: the front of the search"}};
  } else {
    arrays = forecast_of_box(scene, algorithms, threads);
  }
  arrays.push_back(
      {"answer", bytes_of_answer(scene),
       fmt::format("{} components of float64 at {} grid points", scene.dimension(), grid.n_nodes())});
  arrays.push_back({"limits", LinkLimits::bytes_at_most(scene),
                    limits.is_homogeneous() ? "one table for all links"
                                            : "a table for each kind of cell and 4 bytes a cell"});
  arrays.push_back(
      {"requests", of_fixed_size / 4 + n_prescribed(scene) * of_request,
       fmt::format("{} prescribed values, and what they leave each other", n_prescribed(scene))});
  return arrays;
}

} // namespace maille::deform
