#include "feasible/bounds/admission.hpp"

#include "feasible/bounds/admitter.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>

namespace maille::deform {

double rounding_tolerance(const Grid& grid, double largest) {
  const Index3& n = grid.nodes();
  const double links = 8.0 + n[0] + n[1] + n[2];
  return links * std::numeric_limits<double>::epsilon() * largest;
}

void admit_component(const Scene& scene, const LinkLimits& limits, int component,
                     std::vector<Prescribed>& prescribed) {
  DijkstraBounds bounds(scene, limits);
  Admitter(bounds, scene.specimen.grid).admit(component, prescribed);
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

namespace {

std::string what_allows_a_cut(const Scene& scene) {
  if (scene.limits.cut_is_allowed)
    return "";
  return scene.limits.from == LimitSource::none
             ? "; limits that the scene does not ask for, but that the method cannot do without: give wider "
               "ones, or allow the cut by "
               "[limits] cut = \"allowed\""
             : "; [limits] cut = \"allowed\" would take that for an answer";
}

} // namespace

std::string describe(const Scene& scene, const Admission& admission) {
  if (admission.n_cut == 0)
    return {};
  const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(admission.worst_node));
  return fmt::format("the limits admit only part of {} of {} moved components: the largest cut is {:.6g} m, "
                     "along {} at the node at ({:.6g}, {:.6g}, {:.6g}) m{}",
                     admission.n_cut, admission.n_moves, admission.largest_cut,
                     "xyz"[admission.worst_component], x[0], x[1], x[2], what_allows_a_cut(scene));
}

} // namespace maille::deform
