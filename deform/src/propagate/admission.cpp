#include "maille/deform/propagate/admission.hpp"

#include "propagate/envelope.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace maille::deform {

namespace {

double at(const std::vector<double>& field, const Prescribed& p) {
  return field[static_cast<std::size_t>(p.node)];
}

double largest_value(const std::vector<Prescribed>& prescribed, int component) {
  double largest = 0;
  for (const Prescribed& p : prescribed)
    if (p.component == component)
      largest = std::max(largest, std::abs(p.value));
  return largest;
}

bool is_anything(const Prescribed&) {
  return true;
}
bool is_hold(const Prescribed& p) {
  return p.held;
}
bool is_move(const Prescribed& p) {
  return !p.held;
}

/// True if all values of the component can be met together.
bool can_all_be_met(const Scene& scene, const LinkLimits& limits, int component,
                    const std::vector<Prescribed>& prescribed, double tolerance) {
  const auto ends = path_ends(prescribed, component, is_anything);
  const std::vector<double> highest = upper_envelope(scene, limits, component, ends);
  return std::ranges::all_of(prescribed, [&](const Prescribed& p) {
    return p.component != component || p.value <= at(highest, p) + tolerance;
  });
}

/// Clamps every move into the interval that the holds alone leave it.
void cut_at_holds(const Scene& scene, const LinkLimits& limits, int component,
                  std::vector<Prescribed>& prescribed, double tolerance) {
  const auto holds = path_ends(prescribed, component, is_hold);
  const std::vector<double> highest = upper_envelope(scene, limits, component, holds);
  const std::vector<double> lowest = lower_envelope(scene, limits, component, holds);
  for (Prescribed& p : prescribed) {
    if (p.component != component || p.held)
      continue;
    if (p.value > at(highest, p) + tolerance)
      p.value = at(highest, p);
    else if (p.value < at(lowest, p) - tolerance)
      p.value = at(lowest, p);
  }
}

/// Replaces moves that contradict each other by the nearest ones that do not.
void reconcile_moves(const Scene& scene, const LinkLimits& limits, int component,
                     std::vector<Prescribed>& prescribed, double tolerance) {
  const auto moves = path_ends(prescribed, component, is_move);
  const std::vector<double> minorant = upper_envelope(scene, limits, component, moves);
  const std::vector<double> majorant = lower_envelope(scene, limits, component, moves);
  for (Prescribed& p : prescribed) {
    if (p.component != component || p.held)
      continue;
    const bool is_met = p.value <= at(minorant, p) + tolerance && p.value >= at(majorant, p) - tolerance;
    if (!is_met)
      p.value = 0.5 * at(minorant, p) + 0.5 * at(majorant, p); // no overflow for values near the largest
  }
}

} // namespace

double rounding_tolerance(const Grid& grid, double largest) {
  const Index3& n = grid.nodes();
  const double links = 8.0 + n[0] + n[1] + n[2];
  return links * std::numeric_limits<double>::epsilon() * largest;
}

void admit_component(const Scene& scene, const LinkLimits& limits, int component,
                     std::vector<Prescribed>& prescribed) {
  const double largest = largest_value(prescribed, component);
  if (largest == 0) // rest obeys every limit
    return;
  const Grid& grid = scene.specimen.grid;
  const double tolerance = rounding_tolerance(grid, largest);
  if (can_all_be_met(scene, limits, component, prescribed, tolerance))
    return;
  cut_at_holds(scene, limits, component, prescribed, tolerance);
  reconcile_moves(scene, limits, component, prescribed,
                  rounding_tolerance(grid, largest_value(prescribed, component)));
}

Admission compare_with_request(const Scene& scene, std::vector<Prescribed> admitted) {
  Admission admission;
  for (std::size_t i = 0; i < admitted.size(); ++i) {
    const Prescribed& p = admitted[i];
    admission.n_moves += p.held ? 0 : 1;
    const double cut = std::abs(p.value - scene.prescribed[i].value);
    admission.n_cut += cut > 0 ? 1 : 0;
    if (cut > admission.largest_cut) {
      admission.largest_cut = cut;
      admission.worst_node = p.node;
      admission.worst_component = p.component;
    }
  }
  admission.prescribed = std::move(admitted);
  return admission;
}

Admission admit(const Scene& scene, const LinkLimits& limits) {
  std::vector<Prescribed> prescribed = scene.prescribed;
  for (int component = 0; component < scene.dimension(); ++component)
    admit_component(scene, limits, component, prescribed);
  return compare_with_request(scene, std::move(prescribed));
}

std::string describe(const Scene& scene, const Admission& admission) {
  if (admission.n_cut == 0)
    return {};
  const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(admission.worst_node));
  return fmt::format("the limits admit only part of {} of {} moved components: the largest cut is {:.6g} m, "
                     "along {} at the node at ({:.6g}, {:.6g}, {:.6g}) m",
                     admission.n_cut, admission.n_moves, admission.largest_cut,
                     "xyz"[admission.worst_component], x[0], x[1], x[2]);
}

} // namespace maille::deform
