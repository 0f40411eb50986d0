#include "elastic/elastic_methods.hpp"

#include "control/method.hpp"
#include "elastic/box/box_level.hpp"
#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/direct/direct_system.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/ladder/ladder.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_rows.hpp"
#include "elastic/model/thin_cells.hpp"
#include "lattice/field_memory.hpp"
#include "maille/scene/block_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <ranges>
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
  beside = 512,   ///< the answer, while a masked body's fields are needed
  alone = 1024,   ///< the answer is made when they are gone
};

/// What a row of the table is counted per.
enum Unit : std::size_t {
  component, ///< of a grid node
  grid_node,
  matter_node,
  slot,         ///< of a masked body's rows, which are rounded up
  earlier_slot, ///< in each of the rounds of float32 before the last
  cell,         ///< of the grid
  matter_cell,
  odd_block,    ///< of 2 x 2 x 2 cells, like few others where most are like many
  hinged_block, ///< one of them where pieces meet in hinges
  row,          ///< of nodes along x
  along_axes,   ///< the sum of the nodes along all axes
  plane_node,   ///< of one plane of nodes
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
    {relaxed | box | flat, nothing, component, 8}, // the answer
    {masked, beside, component, 8},
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
    // Fields in blocks of nodes and what rounds have found, the coarser grids' matrices, and while they are
    // made the cells and what they share; displacements and forces of some planes in float64; blocks that are
    // like many others share matrices on the finest of the coarser grids; coefficients of every cell where
    // fibres turn.
    {masked, nothing, whole_body, 1 << 20}, // the inverse on the coarsest level
    {masked, limits, whole_body, 4 << 19},
    {masked, nothing, cell, 2},
    {masked, nothing, plane_node, 10 * 24},
    {masked, nothing, matter_node, 70},
    {masked, nothing, odd_block, 1400},
    {masked, nothing, hinged_block, 2600},
    {masked, unlike, matter_node, 296},
    {masked, nothing, slot, 90},
    {masked, alone, earlier_slot, 12},
    {masked, loads, component, 8},
    {masked, fibres, matter_cell, 400},
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

/// What there is of a masked body once its answer is made and its fields are gone: the state and what earlier
/// rounds have found, diagonals, forces of some planes, and what cells are of.
constexpr MemoryRow table_of_end[]{
    {masked, nothing, component, 8}, {masked, nothing, prescribed, 4 * 24},
    {masked, nothing, slot, 60},     {masked, nothing, plane_node, 5 * 24},
    {masked, nothing, cell, 4},      {masked, nothing, whole_body, 3 << 19},
    {masked, loads, component, 8},   {masked, fibres, matter_cell, 300},
};

/// Blocks of 2 x 2 x 2 cells with matter.
struct Blocks {
  std::int64_t all = 0, odd = 0, hinged = 0; ///< of the odd ones some are hinged
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

/// Marks of nodes.
constexpr std::uint8_t is_prescribed = 1, is_hinge = 2;

/// Whether cells about a node do not hang together by faces even within the blocks about it.
bool is_hinge_at(const Specimen& body, const Index3& node) {
  const auto along = [&](int a, int at) {
    return body.grid.cells()[static_cast<std::size_t>(a)] > at && at >= 0;
  };
  Index3 first{};
  for (std::size_t a = 0; a < 3; ++a)
    first[a] = (node[a] + 1) / 2 * 2 - 2;
  std::uint64_t matter = 0, about = 0; // bits x + 4 y + 16 z
  for (int bit = 0; bit < 64; ++bit) {
    const Index3 of{bit & 3, bit >> 2 & 3, bit >> 4},
        at{first[0] + of[0], first[1] + of[1], first[2] + of[2]};
    const auto is_near = [&](std::size_t a) { return at[a] == node[a] || at[a] == node[a] - 1; };
    const auto is_in_blocks = [&](std::size_t a) { return at[a] < node[a] / 2 * 2 + 2; };
    if (!along(0, at[0]) || !along(1, at[1]) || !along(2, at[2]) || !body.is_matter(body.grid.cell(at)) ||
        !is_in_blocks(0) || !is_in_blocks(1) || !is_in_blocks(2))
      continue;
    matter |= std::uint64_t{1} << bit;
    about |= std::uint64_t{is_near(0) && is_near(1) && is_near(2)} << bit;
  }
  constexpr std::uint64_t not_first_x = 0xeeeeeeeeeeeeeeeeU, not_first_y = 0xfff0fff0fff0fff0U;
  std::uint64_t reached = about & (~about + 1);
  for (std::uint64_t before = 0; before != reached;) {
    before = reached;
    reached |= ((reached << 1 & not_first_x) | (reached & not_first_x) >> 1 | (reached << 4 & not_first_y) |
                (reached & not_first_y) >> 4 | reached << 16 | reached >> 16) &
               matter;
  }
  return (about & ~reached) != 0;
}

/// Marks nodes about which matter does not hang together by faces: pieces meet in hinges there.
void mark_hinges(const Specimen& body, List<std::uint8_t>& mark) {
  std::array<bool, 256> hangs{};
  for (unsigned cells = 1; cells < hangs.size(); ++cells)
    hangs[cells] = hangs_together(cells);
  const Grid& grid = body.grid;
  const Index3& n = grid.cells();
  for (std::int64_t node = 0; const int z : std::views::iota(0, n[2] + 1))
    for (int y = 0; y <= n[1]; ++y) {
      unsigned cells = 0; // about the node, those below x first
      for (int x = 0; x <= n[0]; ++x, ++node) {
        cells = cells >> 1 & 0x55U;
        for (unsigned row = 0; row < 4 && x < n[0]; ++row) {
          const int across = y - 1 + static_cast<int>(row & 1), up = z - 1 + static_cast<int>(row >> 1);
          if (across >= 0 && across < n[1] && up >= 0 && up < n[2] &&
              body.is_matter(grid.cell({x, across, up})))
            cells |= 2U << 2 * row;
        }
        if (cells != 0 && !hangs[cells] && is_hinge_at(body, {x, y, z}))
          mark[static_cast<std::size_t>(node)] |= is_hinge;
      }
    }
}

/// See MaskedLevel::galerkin_product().
Blocks blocks_of(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  List<std::uint8_t> mark(static_cast<std::size_t>(grid.n_nodes()), 0);
  for (const Prescribed& p : scene.prescribed)
    mark[static_cast<std::size_t>(p.node)] = is_prescribed;
  mark_hinges(body, mark);
  Blocks blocks;
  std::unordered_map<std::uint64_t, std::int64_t> uses;
  const Index3& n = grid.cells();
  for (int z = 0; z < n[2]; z += 2)
    for (int y = 0; y < n[1]; y += 2)
      for (int x = 0; x < n[0]; x += 2) {
        std::uint64_t pattern = 0;
        unsigned cells = 0;
        unsigned marks = 0;
        for (unsigned octant = 0; octant < 8; ++octant) {
          const Index3 at{x + static_cast<int>(octant & 1), y + static_cast<int>(octant >> 1 & 1),
                          z + static_cast<int>(octant >> 2)};
          if (at[0] >= n[0] || at[1] >= n[1] || at[2] >= n[2] || !body.is_matter(grid.cell(at)))
            continue;
          cells |= 1U << octant;
          const std::uint64_t kind = 8 * body.material(grid.cell(at)) + thin_axes(body, at) + 1;
          pattern = (pattern ^ (8 * kind + octant)) * 0x9e3779b97f4a7c15U;
          for (int corner = 0; corner < 8; ++corner)
            marks |= mark[static_cast<std::size_t>(grid.corner(at, corner))];
        }
        if (cells == 0)
          continue;
        ++blocks.all;
        blocks.hinged += (marks & is_hinge) != 0 ? 1 : 0;
        if (marks != 0 || !hangs_together(cells))
          ++blocks.odd;
        else
          ++uses[pattern];
      }
  for (const auto& [pattern, number] : uses)
    blocks.odd += number < fewest_pieces_of_a_pattern ? number : 0;
  return blocks;
}

/// A round takes five digits, some two of which the start may be off beyond the whole of the answer.
std::int64_t earlier_rounds(double tolerance) {
  return std::max(0, static_cast<int>(std::ceil((2 - std::log10(tolerance)) / 5)) - 1);
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
         (in_blocks(scene) ? in_frames : 0U) |
         (binds || !scene.tied.ties.empty() || scene.relaxation.extrapolation != Extrapolation::none ||
                  in_blocks(scene)
              ? beside
              : alone);
}

std::array<std::int64_t, n_units> units_of(const Scene& scene, unsigned solver) {
  const Specimen& body = scene.specimen;
  const Index3& nodes = body.grid.nodes();
  std::array<std::int64_t, n_units> n{};
  n[component] = scene.dimension() * body.grid.n_nodes();
  n[grid_node] = body.grid.n_nodes();
  n[matter_node] = body.n_matter_nodes();
  n[slot] = solver == masked ? MaskedRows(body).n_slots() : 0;
  n[earlier_slot] = n[slot] * earlier_rounds(scene.relaxation.tolerance);
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
    if ((asked & fibres) == 0 && blocks.are_alike()) {
      n[odd_block] = blocks.odd;
      n[hinged_block] = blocks.hinged;
    } else
      asked |= unlike;
  }
  std::int64_t fields = 0, others = 0, end = 0;
  const auto counts = [&](const MemoryRow& of) {
    return (of.solvers & solver) != 0 && (of.asked & ~asked) == 0;
  };
  for (const MemoryRow& of : table)
    if (counts(of))
      (of.unit == field_node ? fields : others) += of.bytes * n[of.unit];
  for (const MemoryRow& of : table_of_end)
    end += counts(of) ? of.bytes * n[of.unit] : 0;
  const std::int64_t field = n[field_node] * std::int64_t{sizeof(float)} * (solver == box ? 3 : 1);
  if (solver == masked)
    others += bytes_for_factor(scene.specimen) +
              (is_very_slender(scene.specimen) ? n[grid_node] * FlexibleGradients::bytes_per_grid_node : 0);
  if (solver == box)
    others += box_coarsest_bytes(scene.object_stiffness(0), scene.specimen.grid);
  if ((asked & limits) != 0)
    others += LinkLimits::bytes_at_most(scene);
  return std::max(
      end, others + in_shared_pages(fields, field, solver == relaxed && (asked & limits) != 0 ? 2 : 1));
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
  return bytes_of_answer(scene) +
         static_cast<std::int64_t>(static_cast<double>(bytes_for_coupled(scene)) * (0.3 + 0.9 / n_ranks));
}

} // namespace maille::deform
