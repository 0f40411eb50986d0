#include "elastic/elastic_methods.hpp"

#include "control/method.hpp"
#include "elastic/box/box_level.hpp"
#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/masked/masked_rows.hpp"
#include "elastic/model/cell_moduli.hpp"
#include "maille/scene/block_frames.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

/// What fields take that share large pages (see field_memory.hpp): one that does not fit begins another page,
/// and two pages are not full. @param bytes of all fields; @param field of the largest
std::int64_t in_shared_pages(std::int64_t bytes, std::int64_t field) {
  constexpr std::int64_t page = std::int64_t{2} << 20, least_mapped = page / 4 * 3;
  const std::int64_t filled = field < least_mapped ? page / field * field : page;
  return bytes / filled * page + bytes % filled + 2 * page;
}

/// With limits, where `coupled` stays within some.
std::int64_t bytes_of_elastic_answer(const Scene& scene) {
  return scene.limits_bind_coupled() ? bytes_at_least(scene) : bytes_of_answer(scene);
}

/// Rows are padded; five fields of three float32 components, and what coarser levels have of three if only
/// one axis is coarsened at a time; which components are fixed; pointers to rows, and planes in float64 for a
/// few threads.
std::int64_t bytes_for_coupled_box(const Scene& scene) {
  constexpr std::int64_t line = 16, field = 3 * sizeof(float), fields = 5 + 3, threads = 8, pointers = 2 * 24;
  const Index3& nodes = scene.specimen.grid.nodes();
  const std::int64_t rows = std::int64_t{1} * nodes[1] * nodes[2],
                     padded = (nodes[0] + line - 1) / line * line * rows,
                     plane = std::int64_t{3} * sizeof(double) * nodes[0] * nodes[1];
  const std::int64_t forces = scene.has_loads() ? 3 * std::int64_t{sizeof(double)} : 0;
  // Slender bodies: four fields in float64, the loads once more, and what is fixed.
  const std::int64_t in_float64 =
      needs_float64(scene) ? 4 * 3 * std::int64_t{sizeof(double)} + forces + 1 : 0;
  return bytes_of_elastic_answer(scene) + fields * field * padded + pointers * rows + threads * plane +
         box_coarsest_bytes(scene.object_stiffness(0), scene.specimen.grid) +
         (2 + forces + in_float64) * scene.specimen.grid.n_nodes() + 2 * bytes_of_prescribed(scene);
}

/// A float64 field more than the answer; and what follows the matter: fields in blocks of nodes, the coarser
/// grids' matrices, and while they are made the cells and what they share. Where fibres turn, every cell has
/// coefficients of its own, in float64 too.
/// Measured on boxes, sheets, chains, carved bodies and muscles: 380 to 800 a node at the peak.
std::int64_t bytes_for_coupled_matter(const Scene& scene) {
  constexpr std::int64_t field = 3 * sizeof(double), per_node = 600, per_slot = 200, per_kind = 900;
  const Specimen& body = scene.specimen;
  const bool turns = !body.fibres.empty() && !std::ranges::all_of(scene.materials, [](const Material& m) {
    return m.elasticity.is_isotropic();
  });
  const std::int64_t forces = scene.has_loads() ? field : 0;
  return bytes_of_elastic_answer(scene) + (field + forces) * body.grid.n_nodes() +
         std::int64_t{sizeof(std::int32_t)} * body.grid.n_cells() + per_node * body.n_matter_nodes() +
         per_slot * MaskedRows(body).n_slots() + (turns ? per_kind * body.n_matter_cells() : 0) +
         2 * bytes_of_prescribed(scene);
}

/// Of the search for the least energy within limits, if they turn out to be active, but for the links that
/// bind: seven float64 fields, a hierarchy, marks, and the ranges of links where they are not the same
/// everywhere.
std::int64_t bytes_within_limits(const Scene& scene) {
  if (!scene.limits_bind_coupled())
    return 0;
  const std::int64_t d = scene.dimension(), fields = 5 * std::int64_t{sizeof(double)}, hierarchy = 57,
                     marks = 2, ranges = is_uniform_box(scene) ? 0 : 2 * d * std::int64_t{sizeof(double)};
  return d * (fields + hierarchy + marks + ranges) * scene.specimen.grid.n_nodes();
}

/// Beside `coupled`'s own: six pairs of fields that the descent remembers, and the fields that it works with;
/// a frame per cell and per node; copies of the scene.
std::int64_t bytes_in_blocks(const Scene& scene) {
  if (!in_blocks(scene))
    return 0;
  constexpr std::int64_t fields = 13 + 9, frame = 4 * sizeof(double), copies = 3, fibre = 13;
  const Grid& grid = scene.specimen.grid;
  const std::int64_t link =
      scene.limits_bind_coupled() ? 400 : 0; // of a projection or of multipliers, lists that grow included
  return link * scene.dimension() * grid.n_nodes() +
         fields * scene.dimension() * std::int64_t{sizeof(double)} * grid.n_nodes() +
         frame * (2 * grid.n_cells() + grid.n_nodes()) + copies * fibre * grid.n_cells() +
         copies * bytes_of_prescribed(scene);
}

/// Of the start from a coarser lattice, the answers of two such, and their differences.
std::int64_t bytes_of_extrapolation(const Scene& scene) {
  if (scene.relaxation.extrapolation == Extrapolation::none)
    return 0;
  constexpr std::int64_t fields = 2;
  return fields * scene.dimension() * std::int64_t{sizeof(double)} * scene.specimen.grid.n_nodes();
}

std::int64_t bytes_for_coupled_elastic(const Scene& scene) {
  if (is_uniform_box(scene))
    return bytes_for_coupled_box(scene);
  if (scene.dimension() == 3)
    return bytes_for_coupled_matter(scene);
  // Five more float64 fields than the answer, the hierarchies of all components, and forces.
  const std::int64_t d = scene.dimension(), fields = 5 * std::int64_t{sizeof(double)}, hierarchy = 45,
                     forces = scene.has_loads() ? std::int64_t{sizeof(double)} : 0;
  return bytes_of_elastic_answer(scene) + d * (fields + hierarchy + forces) * scene.specimen.grid.n_nodes() +
         bytes_of_prescribed(scene);
}

} // namespace

std::int64_t bytes_for_relaxed(const Scene& scene) {
  // One component at a time, in padded rows: eight float32 and, where only one axis is coarsened at a time,
  // as much again on the coarser levels; tables along the axes. Where limits may bind, another hierarchy and
  // the weights that it is made of, four fields in float64, marks, and links. Ranges of links where they are
  // not the same everywhere, moduli cell by cell where fibres turn, and forces, where loads pull.
  const Index3& nodes = scene.specimen.grid.nodes();
  constexpr std::int64_t of_levels = 64, of_second = 38, of_weights = 12, fields = 4 * sizeof(double),
                         marks = 3, along_axes = 200;
  const bool is_one_box = scene.specimen.material_id.empty() && scene.specimen.fibres.empty();
  const std::int64_t of_links = is_one_box ? 26 : 8; // on a box the first hierarchy has none
  const std::int64_t of_limits =
      scene.limits_bind_relaxed() ? of_second + of_weights + fields + marks + of_links : 0;
  const std::int64_t n_padded = padded_row(nodes[0]) * nodes[1] * nodes[2];
  const std::int64_t padded =
      in_shared_pages((of_levels + of_limits) * n_padded, std::int64_t{sizeof(float)} * n_padded) +
      along_axes * (nodes[0] + nodes[1] + nodes[2]);
  const std::int64_t per_node = is_one_box ? 0 : 2 * scene.dimension() * std::int64_t{sizeof(double)};
  const std::int64_t forces = scene.has_loads() ? std::int64_t{sizeof(double)} : 0;
  return (scene.limits_bind_relaxed() ? bytes_at_least(scene) : bytes_of_answer(scene)) +
         CellModuli::bytes_for(scene.specimen) + padded +
         (per_node + forces) * scene.specimen.grid.n_nodes() + bytes_of_prescribed(scene);
}

std::int64_t bytes_for_coupled(const Scene& scene) {
  return bytes_for_coupled_elastic(scene) + bytes_within_limits(scene) + bytes_of_extrapolation(scene) +
         bytes_in_blocks(scene);
}

} // namespace maille::deform
