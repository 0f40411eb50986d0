#include "maille/scene/scene.hpp"

#include "time_course.hpp"

#include "maille/materials/elasticity.hpp"
#include "maille/scene/link_limits.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

namespace maille {

Vec3 to_world(const Placement& placement, const Vec3& vector) {
  if (placement.direction == Placement{}.direction)
    return vector; // keeps the bits, and keeps non-finite axes separate
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
  const auto& f = fibres[cell];
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

namespace {

/// Counts nodes and edges along rows of nodes, from the matter in the adjacent rows of cells.
class RowCount {
public:
  explicit RowCount(const Specimen& body)
      : body_(body), n_(body.grid.cells()[0]), flags_(static_cast<std::size_t>(n_) + 2) {}

  /// Reads the rows of cells around the row of nodes at y, z.
  /// @param both  per axis y and z: true: rows on both sides; false: the upper side only
  void look_at(int y, int z, std::array<bool, 2> both) {
    std::ranges::fill(flags_, std::uint8_t{0});
    const Index3& n = body_.grid.cells();
    for (int up = both[1] ? z - 1 : z; up <= z; ++up)
      for (int across = both[0] ? y - 1 : y; across <= y; ++across) {
        if (up < 0 || up >= n[2] || across < 0 || across >= n[1])
          continue;
        const std::uint8_t* const material = body_.material_id.data() + body_.grid.cell({0, across, up});
        for (std::size_t x = 0; x < static_cast<std::size_t>(n_); ++x)
          flags_[x + 1] = static_cast<std::uint8_t>(flags_[x + 1] | (material[x] != no_material ? 1 : 0));
      }
  }
  std::int64_t nodes() const { // with matter on either side
    std::int64_t count = 0;
    for (std::size_t x = 0; x + 1 < flags_.size(); ++x)
      count += flags_[x] | flags_[x + 1];
    return count;
  }
  std::int64_t edges() const { return std::accumulate(flags_.begin(), flags_.end(), std::int64_t{0}); }

private:
  const Specimen& body_;
  int n_;
  std::vector<std::uint8_t> flags_; ///< of cells, and one before and after them
};

/// The sum of count(rows, y, z) over all rows of nodes.
template<class Count>
std::int64_t sum_over_rows(const Specimen& body, const Count& count) {
  RowCount rows(body);
  std::int64_t sum = 0;
  for (int z = 0; z < body.grid.nodes()[2]; ++z)
    for (int y = 0; y < body.grid.nodes()[1]; ++y)
      sum += count(rows, y, z);
  return sum;
}

} // namespace

std::int64_t Specimen::n_matter_nodes() const {
  if (material_id.empty())
    return grid.n_nodes();
  return sum_over_rows(*this, [](RowCount& rows, int y, int z) {
    rows.look_at(y, z, {true, true});
    return rows.nodes();
  });
}

std::int64_t Specimen::n_matter_links() const {
  const int dimension = grid.dimension();
  std::int64_t links = 0;
  for (std::size_t a = 0; a < static_cast<std::size_t>(dimension) && material_id.empty(); ++a)
    links += grid.n_nodes() / grid.nodes()[a] * grid.cells()[a];
  if (material_id.empty())
    return links;
  return sum_over_rows(*this, [&](RowCount& rows, int y, int z) {
    rows.look_at(y, z, {true, true});
    std::int64_t here = rows.edges();
    if (dimension > 1) {
      rows.look_at(y, z, {false, true});
      here += rows.nodes();
    }
    if (dimension > 2) {
      rows.look_at(y, z, {true, false});
      here += rows.nodes();
    }
    return here;
  });
}

Vec3 Specimen::position(const Index3& node) const {
  Vec3 x = origin;
  for (int a = 0; a < grid.dimension(); ++a)
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
         std::ranges::any_of(materials, [](const Material& m) { return !is_isotropic(m); });
}

LimitSource Scene::limit_source() const {
  if (limits.from != LimitSource::none)
    return limits.from;
  const bool all_have_some = !materials.empty() && std::ranges::all_of(materials, [](const Material& m) {
    return m.limits.has_value();
  });
  return all_have_some ? LimitSource::material : LimitSource::taut;
}

// Axis 3 is the component across the fibre of the first reference that is not parallel to it: the normal of a
// plane scene, the world's z (up, in a patient), the world's x. So the axes do not depend on the storage
// order of an image, and reversing the fibre reverses only axis 2, which no stiffness depends on.
Eigen::Matrix3d Scene::material_axes(std::int64_t cell) const {
  constexpr double least_sine = 1e-3; // below, rounding of the fibre would rotate the axes
  const auto vector = [](const Vec3& v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
  const auto& to_world = specimen.placement.direction;
  const Eigen::Vector3d fibre = vector(specimen.fibre_of(cell)).stableNormalized();
  const std::array references{dimension() < 3 ? Eigen::Vector3d(0, 0, 1) : vector(to_world[2]),
                              vector(to_world[0]), vector(to_world[2])};
  Eigen::Vector3d across = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < references.size() && across.norm() < least_sine; ++i)
    across = references[i] - fibre * fibre.dot(references[i]);
  across.normalize();
  Eigen::Matrix3d axes;
  axes << fibre, across.cross(fibre), across;
  return axes;
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

/// Sets the prescribed values of a Turn or a Drive at a fraction of it.
template<class Motion>
void move_by(const Motion& of, const std::array<bool, 3>& axes, double fraction, Scene& step) {
  for (const std::int64_t node : of.nodes) {
    const Vec3 u = of.displacement(step.specimen.position(step.specimen.grid.node_at(node)), fraction);
    for (int b = 0; b < step.dimension(); ++b) {
      if (!axes[b])
        continue;
      const auto entry =
          std::ranges::lower_bound(step.prescribed, std::pair{b, node}, {}, [](const Prescribed& p) {
            return std::pair{p.component, p.node};
          });
      if (entry != step.prescribed.end() && entry->node == node && entry->component == b && !entry->held)
        entry->value = u[b];
    }
  }
}

} // namespace

namespace {

/// Restricts turns, drives and courses to the end of the step, for steps of a step.
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
      step.active_stress[cell] += timed.stress * (timed.course.at(fraction) - fraction * timed.course.at(1));
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

/// Stress of a fibre with a tension of 1 Pa.
Vector6 along_fibre(const Vec3& a) {
  Vector6 stress;
  stress << a[0] * a[0], a[1] * a[1], a[2] * a[2], a[1] * a[2], a[0] * a[2], a[0] * a[1];
  return stress;
}

} // namespace

Eigen::Matrix<double, 6, 1> Scene::object_active_stress(std::int64_t cell) const {
  if (!contracts())
    return Vector6::Zero();
  return active_stress[cell] * along_fibre(specimen.fibre_of(cell));
}

Eigen::VectorXd Scene::cell_active_stress(std::int64_t cell) const {
  return reduced_active_stress(cell, contracts() ? active_stress[cell] : 0);
}

Eigen::VectorXd Scene::reduced_active_stress(std::int64_t cell, double of_fibre) const {
  Vector6 stress = of_fibre * along_fibre(specimen.fibre_of(cell));
  if (dimension() == 3)
    return stress;
  if (stress.isZero(0))
    return Eigen::VectorXd::Zero(dimension() == 2 ? 3 : 1);
  // Free directions relax, which changes the stress in the directions of the scene.
  Vector6 lateral = Vector6::Zero();
  const Matrix6 C = object_stiffness(cell);
  release_free_directions(C, stress, dimension(), plane, lateral);
  stress += C * lateral;
  if (dimension() == 1)
    return stress.head<1>();
  return Eigen::Vector3d(stress(0), stress(1), stress(5));
}

std::string_view to_string(TestKind kind) {
  constexpr std::array<std::string_view, 5> names{"axial", "shear", "bend", "indent", "confined"};
  return names[static_cast<std::size_t>(kind)];
}

double StandardTest::angle() const {
  const double thickness = std::sqrt(12 * second_moment / area);
  return 2 * strain * length / thickness;
}

} // namespace maille
