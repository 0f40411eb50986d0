#include "elastic/elastic_methods.hpp"

/// Memory of `relaxed` and `coupled` at the peak, by bytes a node and a cell.
///
/// Measured on boxes, sheets, columns, carved and porous bodies, with fibres, limits, ties and blocks;
/// checked against the heap by footprint_test.cpp. A forecast is 1 to 3 times the peak; up to 7 times where
/// limits do not bind; and half of the peak where pieces meet in many hinges. It refuses scenes that are far
/// too large before they start; the limit of the arena ends the others.

#include "control/method.hpp"
#include "elastic/box/box_level.hpp"
#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/direct/direct_system.hpp"
#include "elastic/krylov/coupled_task.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/ladder/ladder.hpp"
#include "maille/scene/block_frames.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

constexpr double headroom = 1.1;

double bytes_of_components(const Scene& scene, double each) {
  return each * scene.dimension() * static_cast<double>(scene.specimen.grid.n_nodes());
}

/// For each node of the grid, in rows of whole vectors.
double bytes_of_fields(const Scene& scene, double each) {
  const Index3& n = scene.specimen.grid.nodes();
  return each * static_cast<double>(padded_row(n[0])) * n[1] * n[2] + 200.0 * (n[0] + n[1] + n[2]);
}

/// True if cells have their own coefficients: weights, or fibres that matter.
bool differs_by_cell(const Scene& scene) {
  return scene.specimen.has_weights() || (!scene.specimen.fibres.empty() &&
                                          !std::ranges::all_of(scene.materials, [](const Material& material) {
                                            return material.elasticity.is_isotropic();
                                          }));
}

/// True also for labels that slide, which are cut along their borders.
bool is_tied(const Scene& scene) {
  return !scene.tied.ties.empty() || !scene.sliding.empty();
}

/// Hierarchies per component, projected fields, and multipliers of limits.
double bytes_of_ties(const Scene& scene, bool binds, double levels, double each) {
  return !is_tied(scene)
             ? 0
             : bytes_of_fields(scene, levels) + bytes_of_components(scene, each + (binds ? 336 : 0));
}

double bytes_of_box(const Scene& scene) {
  const Index3& n = scene.specimen.grid.nodes();
  return static_cast<double>(box_coarsest_bytes(scene.object_stiffness(0), scene.specimen.grid)) +
         bytes_of_fields(scene, 96) + bytes_of_components(scene, scene.has_loads() ? 13 : 1) +
         bytes_of_components(scene, needs_float64(scene) ? 41 : 0) +
         static_cast<double>(bytes_for_factor(scene.specimen)) + 300.0 * n[1] * n[2] + 192.0 * n[0] * n[1];
}

double bytes_of_plane(const Scene& scene) {
  return bytes_of_components(scene, scene.has_loads() ? 48 : 40) + bytes_of_fields(scene, 128);
}

double bytes_of_masked(const Scene& scene) {
  constexpr double inverse = 1 << 20, of_own_coefficients = 400;
  const Specimen& body = scene.specimen;
  const auto nodes = static_cast<double>(body.n_matter_nodes()),
             cells = static_cast<double>(body.n_matter_cells());
  // Pieces share fewer matrices where the surface is large or materials mix.
  const double of_node = 110 + std::min(50.0, 100 * (nodes / std::max(1.0, cells) - 1)) +
                         (scene.materials.size() > 1 ? 40 : 0) +
                         (differs_by_cell(scene) ? of_own_coefficients : 0);
  return inverse + nodes * of_node + 2 * static_cast<double>(body.grid.n_cells()) +
         480.0 * body.grid.nodes()[0] * body.grid.nodes()[1] +
         bytes_of_components(scene, scene.has_loads() ? 8 : 0) + static_cast<double>(bytes_for_factor(body)) +
         (is_very_slender(body)
              ? static_cast<double>(body.grid.n_nodes() * FlexibleGradients::bytes_per_grid_node)
              : 0);
}

std::int64_t with_answer(const Scene& scene, bool binds, double bytes) {
  constexpr std::int64_t of_prescribed = sizeof(Prescribed) * 3; // asked, clipped, and as fixed components
  return bytes_of_answer(scene) + of_prescribed * std::ssize(scene.prescribed) + 65536 +
         static_cast<std::int64_t>(headroom * bytes) + (binds ? LinkLimits::bytes_at_most(scene) : 0);
}

} // namespace

std::int64_t bytes_for_relaxed(const Scene& scene) {
  const bool binds = scene.limits_bind_relaxed();
  const Specimen& body = scene.specimen;
  const bool is_uniform = body.material_id.empty() && body.fibres.empty() && !body.has_weights();
  const double bytes = bytes_of_fields(scene, binds ? 230 : 48) +
                       bytes_of_components(scene, is_uniform ? 0 : 16) +
                       bytes_of_components(scene, scene.has_loads() ? 8 : 0) +
                       (differs_by_cell(scene) ? 76 * static_cast<double>(body.grid.n_cells()) : 0) +
                       bytes_of_ties(scene, binds, 380, 120);
  // The search for the scale of taut limits ends before the answer is allocated.
  return std::max(with_answer(scene, binds, bytes), binds ? bytes_at_least(scene) : 0);
}

std::int64_t bytes_for_coupled(const Scene& scene) {
  const bool binds = scene.limits_bind_coupled(), is_box = is_uniform_box(scene) && !is_tied(scene),
             is_masked = !is_box && scene.dimension() == 3;
  const double body = is_box      ? bytes_of_box(scene)
                      : is_masked ? bytes_of_masked(scene)
                                  : bytes_of_plane(scene);
  const double of_limits =
                   (1 << 20) + bytes_of_components(scene, is_box ? 150 : 210), // after the hierarchy is freed
      of_nested = bytes_of_components(scene, 16),
               of_finite = // fields of states, bases and gradients; tangents, frames and energies of cells
               bytes_of_components(scene, 190) + 500 * static_cast<double>(scene.specimen.grid.n_cells());
  return with_answer(scene, binds,
                     (binds ? std::max(body, of_limits) : body) +
                         (scene.strain == Strain::finite ? of_finite : 0) +
                         (scene.relaxation.extrapolation == Extrapolation::none ? 0 : of_nested) +
                         bytes_of_ties(scene, binds, binds ? 190 : 0, 73));
}

std::int64_t bytes_for_coupled(const Scene& scene, int n_ranks) {
  // Measured on gyroids and legs: of 4 ranks the first held 0.4 of what one process does.
  return bytes_of_answer(scene) +
         static_cast<std::int64_t>(static_cast<double>(bytes_for_coupled(scene)) * (0.3 + 0.9 / n_ranks));
}

} // namespace maille::deform
