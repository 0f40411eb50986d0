#include "maille/scene/scene.hpp"

#include "arc.hpp"
#include "time_course.hpp"

#include "maille/materials/elasticity.hpp"
#include "maille/scene/link_limits.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>

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

Vec3 point_in_world(const Placement& placement, const Vec3& point) {
  Vec3 world = to_world(placement, point);
  for (std::size_t row = 0; row < 3; ++row)
    world[row] += placement.origin[row];
  return world;
}

Vec3 point_in_object(const Placement& placement, const Vec3& point) {
  Vec3 object{};
  for (std::size_t a = 0; a < 3; ++a)
    for (std::size_t row = 0; row < 3; ++row)
      object[a] += placement.direction[row][a] * (point[row] - placement.origin[row]);
  return object;
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
  List<std::uint8_t> is_of_matter(static_cast<std::size_t>(grid.n_nodes()), 0);
  const std::int64_t in_row = grid.cells()[0];
  for (std::int64_t row = 0; row < grid.n_cells(); row += in_row) {
    const Index3 at = grid.cell_at(row);
    for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
      std::uint8_t* const marks = is_of_matter.data() + grid.corner(at, corner);
      for (std::int64_t x = 0; x < in_row; ++x)
        if (is_matter(row + x))
          marks[x] = 1;
    }
  }
  return std::ranges::count(is_of_matter, std::uint8_t{1});
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
  Matrix6 C = stiffness(constants);
  if (!specimen.stiffness_ratio.empty())
    C *= specimen.stiffness_ratio_of(cell);
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

/// Puts what moves nodes where it has them at a fraction of it. @param of a Turn or a Drive
template<class Motion>
void move_by(const Motion& of, const std::array<bool, 3>& axes, double fraction, Scene& step) {
  for (const std::int64_t node : of.nodes) {
    const Vec3 u = of.displacement(step.specimen.position(step.specimen.grid.node_at(node)), fraction);
    for (int b = 0; b < step.dimension(); ++b) {
      if (!axes[static_cast<std::size_t>(b)])
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

namespace {

/// What a step that is taken in steps again goes by: turns, drives and courses up to its own end.
void begin(const Scene& scene, double fraction, Scene& step) {
  for (std::size_t i = 0; i < scene.turns.size(); ++i) {
    Turn& turn = step.turns[i];
    turn.angle *= fraction;
    for (std::size_t a = 0; a < 3; ++a)
      turn.by[a] = scene.test && scene.test->kind == TestKind::bend ? end_of_arc(*scene.test, fraction)[a]
                                                                    : fraction * turn.by[a];
  }
  for (Drive& drive : step.drives)
    drive = until(drive, fraction);
  for (TimedContraction& timed : step.timed)
    timed.course = until(timed.course, fraction);
}

} // namespace

Scene scaled(const Scene& scene, double fraction) {
  Scene step = with_taut_scale(scene);
  for (Prescribed& p : step.prescribed)
    p.value *= fraction;
  for (Turn turn : scene.turns) {
    if (scene.test && scene.test->kind == TestKind::bend && fraction != 0)
      for (std::size_t a = 0; a < 3; ++a) // along the arc
        turn.by[a] = end_of_arc(*scene.test, fraction)[a] / fraction;
    move_by(turn, turn.axes, fraction, step);
  }
  for (const Drive& drive : scene.drives)
    move_by(drive, {true, true, true}, fraction, step);
  begin(scene, fraction, step);
  for (FaceLoad& load : step.tractions)
    for (double& t : load.traction)
      t *= fraction;
  for (double& g : step.gravity)
    g *= fraction;
  for (double& stress : step.active_stress)
    stress *= fraction;
  for (const TimedContraction& timed : scene.timed)
    for (const std::int64_t cell : timed.cells)
      step.active_stress[static_cast<std::size_t>(cell)] +=
          timed.stress * (timed.course.at(fraction) - fraction * timed.course.at(1));
  if (step.test)
    step.test->strain *= fraction;
  return step;
}

Vec3 Turn::displacement(const Vec3& x, double fraction) const {
  const Eigen::Vector3d along(axis[0], axis[1], axis[2]);
  const Eigen::Vector3d arm(x[0] - about[0], x[1] - about[1], x[2] - about[2]);
  const Eigen::Vector3d turned = Eigen::AngleAxisd(fraction * angle, along) * arm;
  Vec3 u{};
  for (std::size_t b = 0; b < 3; ++b)
    u[b] = fraction * by[b] + (turned[static_cast<Eigen::Index>(b)] - arm[static_cast<Eigen::Index>(b)]);
  return u;
}

std::string in_words(const FibreReport& report) {
  if (report.source != "tensor_image")
    return report.source;
  std::string text = fmt::format("from a tensor image: {} cells", report.cells);
  if (report.without_direction() == 0)
    text += ", each with a direction";
  else
    text += fmt::format(", {} without a direction ({} no tensor, {} not positive, {} isotropic), filled from "
                        "neighbours {}, from "
                        "their label {}, from the body {}",
                        report.without_direction(), report.no_tensor, report.not_positive, report.isotropic,
                        report.from_neighbours, report.from_label, report.from_body);
  if (report.smoothing_radius > 0)
    text += fmt::format("; smoothed over {:.4g} mm, by {:.1f} deg on average", report.smoothing_radius * 1e3,
                        report.smoothing_turn * 180 / std::numbers::pi);
  return text;
}

namespace {

/// Of a fibre that pulls with 1 Pa.
Vector6 along_fibre(const Vec3& a) {
  Vector6 stress;
  stress << a[0] * a[0], a[1] * a[1], a[2] * a[2], a[1] * a[2], a[0] * a[2], a[0] * a[1];
  return stress;
}

} // namespace

Eigen::Matrix<double, 6, 1> Scene::object_active_stress(std::int64_t cell) const {
  if (!contracts())
    return Vector6::Zero();
  return active_stress[static_cast<std::size_t>(cell)] * along_fibre(specimen.fibre_of(cell));
}

Eigen::VectorXd Scene::cell_active_stress(std::int64_t cell) const {
  return reduced_active_stress(cell, contracts() ? active_stress[static_cast<std::size_t>(cell)] : 0);
}

Eigen::VectorXd Scene::reduced_active_stress(std::int64_t cell, double of_fibre) const {
  Vector6 stress = of_fibre * along_fibre(specimen.fibre_of(cell));
  if (dimension() == 3)
    return stress;
  if (stress.isZero(0))
    return Eigen::VectorXd::Zero(dimension() == 2 ? 3 : 1);
  // What is free gives way to it, and by that pulls at the directions that the scene knows.
  Vector6 strain = Vector6::Zero();
  const Matrix6 C = object_stiffness(cell);
  release_free_directions(C, stress, dimension(), plane, strain);
  stress += C * strain;
  if (dimension() == 1)
    return stress.head<1>();
  return Eigen::Vector3d(stress(0), stress(1), stress(5));
}

} // namespace maille
