#include "maille/scene/scene.hpp"

#include "maille/scene/link_limits.hpp"

#include <algorithm>
#include <cmath>

namespace maille {

Vec3 to_world(const Placement& placement, const Vec3& vector) {
  if (placement.direction == Placement{}.direction)
    return vector; // the same bits, and an axis that is not finite spoils no other
  Vec3 turned{};
  for (std::size_t row = 0; row < 3; ++row)
    turned[row] = placement.direction[row][0] * vector[0] + placement.direction[row][1] * vector[1] +
                  placement.direction[row][2] * vector[2];
  return turned;
}

Vec3 Specimen::fibre_of(std::int64_t cell) const {
  if (fibres.empty())
    return fibre;
  const auto& f = fibres[static_cast<std::size_t>(cell)];
  return {f[0], f[1], f[2]};
}

bool Specimen::is_node(const Index3& node) const {
  bool borders = false;
  for_each_cell_at(node, [&](std::int64_t) { borders = true; });
  return borders;
}

std::int64_t Specimen::n_matter_cells() const {
  if (material_id.empty())
    return grid.n_cells();
  return std::count_if(material_id.begin(), material_id.end(),
                       [](std::uint8_t m) { return m != no_material; });
}

std::int64_t Specimen::n_matter_nodes() const {
  if (material_id.empty())
    return grid.n_nodes();
  std::int64_t count = 0;
  for (std::int64_t n = 0; n < grid.n_nodes(); ++n)
    count += is_node(grid.node_at(n));
  return count;
}

std::int64_t Specimen::n_matter_links() const {
  std::int64_t links = 0;
  for (int axis = 0; axis < grid.dimension(); ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (material_id.empty()) {
      links += grid.n_nodes() / grid.nodes()[a] * grid.cells()[a];
      continue;
    }
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      bool borders = false;
      for_each_cell_at_link(grid.node_at(node), axis, [&](std::int64_t) { borders = true; });
      links += borders ? 1 : 0;
    }
  }
  return links;
}

Vec3 Specimen::position(const Index3& node) const {
  Vec3 x = origin;
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a)
    x[a] += grid.spacing()[a] * node[a];
  return x;
}

double Scene::largest_prescribed() const {
  double largest = 0;
  for (const Prescribed& p : prescribed)
    largest = std::max(largest, std::abs(p.value));
  return largest;
}

bool Scene::has_fibres() const {
  return contracts() || !specimen.fibres.empty() ||
         std::ranges::any_of(materials, [](const Material& m) { return !m.elasticity.is_isotropic(); });
}

LimitSource Scene::limit_source() const {
  if (limits.from != LimitSource::none)
    return limits.from;
  const bool all_have_some = !materials.empty() && std::ranges::all_of(materials, [](const Material& m) {
    return m.limits.has_value();
  });
  return all_have_some ? LimitSource::material : LimitSource::taut;
}

Eigen::Matrix3d Scene::material_axes(std::int64_t cell) const {
  const Vec3 f = specimen.fibre_of(cell);
  return axes_from_fibre({f[0], f[1], f[2]});
}

Matrix6 Scene::object_stiffness(std::int64_t cell) const {
  const ElasticConstants& constants = materials[specimen.material(cell)].elasticity;
  const Matrix6 C = stiffness(constants);
  return constants.is_isotropic() ? C : turned(C, material_axes(cell));
}

Eigen::MatrixXd Scene::cell_stiffness(std::int64_t cell) const {
  return reduced_stiffness(object_stiffness(cell), dimension(), plane);
}

Scene with_taut_scale(const Scene& scene) {
  Scene known = scene;
  if (known.limits.from == LimitSource::taut && !known.limits.taut_scale)
    known.limits.taut_scale = LinkLimits(scene).taut_scale();
  return known;
}

Scene with_limits(const Scene& scene) {
  Scene limited = scene;
  limited.limits.from = scene.limit_source();
  return with_taut_scale(limited);
}

namespace {

/// Puts what a turn prescribes where it is after a fraction of it.
void turn_by(const Turn& turn, double fraction, Scene& step) {
  for (const std::int64_t node : turn.nodes) {
    const Vec3 u = turn.displacement(step.specimen.position(step.specimen.grid.node_at(node)), fraction);
    for (int b = 0; b < step.dimension(); ++b) {
      if (!turn.axes[static_cast<std::size_t>(b)])
        continue;
      const auto entry =
          std::ranges::lower_bound(step.prescribed, std::pair{b, node}, {}, [](const Prescribed& p) {
            return std::pair{p.component, p.node};
          });
      if (entry != step.prescribed.end() && entry->node == node && entry->component == b && !entry->held)
        entry->value = u[static_cast<std::size_t>(b)];
    }
  }
}

} // namespace

Scene scaled(const Scene& scene, double fraction) {
  Scene step = with_taut_scale(scene);
  for (Prescribed& p : step.prescribed)
    p.value *= fraction;
  for (const Turn& turn : scene.turns)
    turn_by(turn, fraction, step);
  for (FaceLoad& load : step.tractions)
    for (double& t : load.traction)
      t *= fraction;
  for (double& g : step.gravity)
    g *= fraction;
  for (double& stress : step.active_stress)
    stress *= fraction;
  return step;
}

} // namespace maille
