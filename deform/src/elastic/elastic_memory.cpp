#include "elastic/elastic_methods.hpp"

#include "control/method.hpp"
#include "elastic/box/box_level.hpp"
#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_rows.hpp"
#include "elastic/model/thin_cells.hpp"
#include "lattice/field_memory.hpp"
#include "maille/scene/block_frames.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <unordered_map>

namespace maille::deform {

namespace {

/// The solvers, each a bit: of `relaxed`, and of `coupled` on boxes, on masked bodies, in 1D and 2D.
enum Solver : unsigned { relaxed = 1, box = 2, masked = 4, flat = 8, coupled = box | masked | flat };

/// What a scene may ask for beside holds and moves. All that a row names must be asked for.
enum Asked : unsigned {
  nothing = 0,
  loads = 1,
  limits = 2,
  kinds = 4,      ///< more than one box of one material
  fibres = 8,     ///< a direction a cell
  slender = 16,   ///< residuals in float64 from the beginning
  nested = 32,    ///< extrapolation
  in_frames = 64, ///< frame = "blocks"
  ties = 128,     ///< between nodes of labels that slide
  unlike = 256,   ///< most blocks of 2 x 2 x 2 cells of a masked body are like few others
};

/// What there is so many of.
enum Unit : std::size_t {
  component, ///< of a grid node
  grid_node,
  matter_node,
  slot, ///< of a masked body's rows, which are rounded up
  cell, ///< of the grid
  matter_cell,
  odd_block,  ///< of 2 x 2 x 2 cells, like few others where most are like many
  row,        ///< of nodes along x
  along_axes, ///< the sum of the nodes along all axes
  plane_node, ///< of one plane of nodes
  prescribed,
  field_node, ///< of a component, rows rounded up: of fields, which share large pages
  whole_body, ///< one: what does not grow
  n_units
};

struct MemoryRow {
  unsigned solvers, asked;
  Unit unit;
  std::int64_t bytes;
};

/// Bytes a unit at the peak, at most; of active limits by what was measured where many links bind. Measured
/// on boxes, sheets, chains, carved bodies and muscles, and checked against the heap by footprint_test.cpp.
constexpr MemoryRow table[]{
    {relaxed | coupled, nothing, component, 8}, // the answer
    {relaxed | coupled, nothing, prescribed, 4 * 24},
    {relaxed | coupled, nothing, whole_body, 32768},
    // One component at a time: eight float32 and half as much on coarser levels; within limits a second
    // hierarchy, its weights, four fields in float64, marks and links.
    {relaxed, nothing, field_node, 48},
    {relaxed, nothing, along_axes, 200},
    {relaxed, kinds, component, 16},
    {relaxed, loads, grid_node, 24},
    {relaxed, limits, field_node, 125},
    {relaxed, limits, grid_node, 80},
    {relaxed, fibres, matter_cell, 72},
    {relaxed, fibres, cell, 4},
    // Five fields of float32, and what coarser levels have of three; pointers to rows, planes of eight
    // threads.
    {box, nothing, field_node, 3 * 4 * (5 + 3)},
    {box, nothing, whole_body, 64 << 10}, // lists of small levels
    {box, limits, whole_body, 1 << 19},
    {box, nothing, row, 2 * 24},
    {box, nothing, plane_node, 8 * 24},
    {box, nothing, grid_node, 2},
    {box, loads, component, 8 + 4},
    {box, slender, component, 4 * 8 + 1},
    {box, slender | loads, component, 8},
    // Fields in blocks of nodes, the coarser grids' matrices, and while they are made the cells and what they
    // share, or forces in float64; blocks that are like many others share matrices on the finest of the
    // coarser grids; coefficients of every cell where fibres turn.
    {masked, nothing, whole_body, 3 << 19}, // the inverse on the coarsest level
    {masked, limits, whole_body, 6 << 19},
    {masked, nothing, cell, 2},
    {masked, nothing, plane_node, 5 * 24}, // forces in float64
    {masked, nothing, matter_node, 80},
    {masked, nothing, odd_block, 1800},
    {masked, unlike, matter_node, 296},
    {masked, nothing, slot, 100},
    {masked, loads, component, 8},
    {masked, fibres, matter_cell, 460},
    // Five fields of float64 of gradients, and what is shared, the diagonal, loads and marks.
    {masked, ties, component, 9 * 8 + 1},
    // The same of `relaxed`, the hierarchies of all three components, and its links; within limits parts and
    // multipliers of links, and fields of rounds.
    {relaxed, ties, component, 9 * 8 + 1 + 3 * 80 + 3 * 40},
    {relaxed | masked, ties | limits, component, 3 * 40 + 3 * 64 + 6 * 8},
    // Five fields of float64, and the hierarchies of all components.
    {flat, nothing, component, 5 * 8},
    {flat, nothing, field_node, 2 * 64},
    {flat, nothing, along_axes, 200},
    {flat, loads, component, 8},
    {coupled, limits, component, 300},
    {masked, limits, component, 30},
    {coupled, nested, component, 16},
    // Six pairs of fields that the descent remembers, and those that it works with; frames.
    {coupled, in_frames, component, (13 + 9) * 8},
    {coupled, in_frames, cell, 2 * 32 + 3 * 13},
    {coupled, in_frames, grid_node, 32},
};

/// Blocks of 2 x 2 x 2 cells with matter.
struct Blocks {
  std::int64_t all = 0, odd = 0;
  bool are_alike() const { return 5 * odd <= 2 * all; }
};

/// Whether cells of a block, a bit each, hang together by faces.
bool hangs_together(unsigned cells) {
  unsigned reached = cells & (~cells + 1);
  for (int step = 0; step < 8; ++step)
    reached |= ((reached & 0x55U) << 1 | (reached & 0xaaU) >> 1 | (reached & 0x33U) << 2 |
                (reached & 0xccU) >> 2 | (reached & 0x0fU) << 4 | (reached & 0xf0U) >> 4) &
               cells;
  return reached == cells;
}

/// See MaskedLevel::galerkin_product(). What hinges there are between blocks is left to the other rows.
Blocks blocks_of(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  List<std::uint8_t> is_fixed(static_cast<std::size_t>(grid.n_nodes()), 0);
  for (const Prescribed& p : scene.prescribed)
    is_fixed[static_cast<std::size_t>(p.node)] = 1;
  Blocks blocks;
  std::unordered_map<std::uint64_t, std::int64_t> uses;
  const Index3& n = grid.cells();
  for (int z = 0; z < n[2]; z += 2)
    for (int y = 0; y < n[1]; y += 2)
      for (int x = 0; x < n[0]; x += 2) {
        std::uint64_t pattern = 0;
        unsigned cells = 0;
        bool holds = false;
        for (unsigned octant = 0; octant < 8; ++octant) {
          const Index3 at{x + static_cast<int>(octant & 1), y + static_cast<int>(octant >> 1 & 1),
                          z + static_cast<int>(octant >> 2)};
          if (at[0] >= n[0] || at[1] >= n[1] || at[2] >= n[2] || !body.is_matter(grid.cell(at)))
            continue;
          cells |= 1U << octant;
          const std::uint64_t kind = 8 * body.material(grid.cell(at)) + thin_axes(body, at) + 1;
          pattern = (pattern ^ (8 * kind + octant)) * 0x9e3779b97f4a7c15U;
          for (int corner = 0; corner < 8 && !holds; ++corner)
            holds = is_fixed[static_cast<std::size_t>(grid.corner(at, corner))] != 0;
        }
        if (cells == 0)
          continue;
        ++blocks.all;
        if (holds || !hangs_together(cells))
          ++blocks.odd;
        else
          ++uses[pattern];
      }
  for (const auto& [pattern, number] : uses)
    blocks.odd += number < fewest_pieces_of_a_pattern ? number : 0;
  return blocks;
}

unsigned solver_of_coupled(const Scene& scene) {
  return is_uniform_box(scene) ? box : scene.dimension() == 3 ? masked : flat;
}

unsigned asked_by(const Scene& scene, unsigned solver) {
  const Specimen& body = scene.specimen;
  const bool binds = solver == relaxed ? scene.limits_bind_relaxed() : scene.limits_bind_coupled(),
             turns = body.has_weights() ||
                     (!body.fibres.empty() && !std::ranges::all_of(scene.materials, [](const Material&m) {
                       return m.elasticity.is_isotropic();
                     }));
  return (scene.has_loads() ? loads : 0U) | (binds ? limits : 0U) |
         (body.material_id.empty() && body.fibres.empty() && !body.has_weights() ? 0U : kinds) |
         (turns ? fibres : 0U) | (scene.tied.ties.empty() ? 0U : ties) |
         (solver == box && needs_float64(scene) ? slender : 0U) |
         (scene.relaxation.extrapolation == Extrapolation::none ? 0U : nested) |
         (in_blocks(scene) ? in_frames : 0U);
}

std::array<std::int64_t, n_units> units_of(const Scene& scene, unsigned solver) {
  const Specimen& body = scene.specimen;
  const Index3& nodes = body.grid.nodes();
  std::array<std::int64_t, n_units> n{};
  n[component] = scene.dimension() * body.grid.n_nodes();
  n[grid_node] = body.grid.n_nodes();
  n[matter_node] = body.n_matter_nodes();
  n[slot] = solver == masked ? MaskedRows(body).n_slots() : 0;
  n[cell] = body.grid.n_cells();
  n[matter_cell] = body.n_matter_cells();
  n[row] = std::int64_t{1} * nodes[1] * nodes[2];
  n[along_axes] = std::accumulate(nodes.begin(), nodes.end(), std::int64_t{0});
  n[plane_node] = std::int64_t{1} * nodes[0] * nodes[1];
  n[prescribed] = std::ssize(scene.prescribed);
  n[field_node] = padded_row(nodes[0]) * n[row];
  n[whole_body] = 1;
  return n;
}

/// What fields take that share large pages (see field_memory.hpp): one that does not fit begins another page,
/// and the last page is not full. @param bytes of all fields; @param field of the largest; @param open pages
std::int64_t in_shared_pages(std::int64_t bytes, std::int64_t field, std::int64_t open) {
  constexpr std::int64_t page{large_page}, mapped{least_mapped}, shared{least_shared};
  if (field < shared)
    return bytes;
  const std::int64_t filled = field < mapped ? page / field * field : page;
  return ((bytes + filled - 1) / filled + open) * page;
}

std::int64_t forecast(const Scene& scene, unsigned solver) {
  std::array<std::int64_t, n_units> n = units_of(scene, solver);
  unsigned asked = asked_by(scene, solver);
  if (solver == masked) {
    const Blocks blocks = blocks_of(scene);
    if ((asked & fibres) == 0 && blocks.are_alike())
      n[odd_block] = blocks.odd;
    else
      asked |= unlike;
  }
  std::int64_t fields = 0, others = 0;
  for (const MemoryRow& of : table)
    if ((of.solvers & solver) != 0 && (of.asked & ~asked) == 0)
      (of.unit == field_node ? fields : others) += of.bytes * n[of.unit];
  const std::int64_t field = n[field_node] * std::int64_t{sizeof(float)} * (solver == box ? 3 : 1);
  if (solver == box)
    others += box_coarsest_bytes(scene.object_stiffness(0), scene.specimen.grid);
  if ((asked & limits) != 0)
    others += LinkLimits::bytes_at_most(scene);
  return others + in_shared_pages(fields, field, solver == relaxed && (asked & limits) != 0 ? 2 : 1);
}

} // namespace

std::int64_t bytes_for_relaxed(const Scene& scene) {
  // The search for the scale of taut limits is over before the answer is made.
  return std::max(forecast(scene, relaxed), scene.limits_bind_relaxed() ? bytes_at_least(scene) : 0);
}

std::int64_t bytes_for_coupled(const Scene& scene) {
  return forecast(scene, solver_of_coupled(scene));
}

std::int64_t bytes_for_coupled(const Scene& scene, int n_ranks) {
  // Measured on gyroids and legs: of 4 ranks the first held 0.4 of what one process does.
  constexpr double on_first = 0.3, shared = 0.9;
  return bytes_of_answer(scene) + static_cast<std::int64_t>(static_cast<double>(bytes_for_coupled(scene)) *
                                                            (on_first + shared / n_ranks));
}

} // namespace maille::deform
