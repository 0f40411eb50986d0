#include "maille/base/vectors.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/sliding.hpp"
#include "measure/section.hpp"
#include "mechanics/volume_ratio.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <unordered_set>

namespace maille {

namespace {

/// Coordinate in cells from node 0; rounded to a border within the tolerance for regions.
double in_cells(const Specimen& body, const Vec3& place, std::size_t axis) {
  constexpr double tolerance = 1e-4;
  const double at = (place[axis] - body.origin[axis]) / body.grid.spacing()[axis];
  return std::abs(at - std::round(at)) < tolerance ? std::round(at) : at;
}

/// Multilinear displacement in the cell that contains the point, object's frame [m]. @pre it exists
Vec3 displacement_at(const Specimen& body, const Displacement& u, const MaterialPoint& point) {
  const Grid& grid = body.grid;
  const Index3 cell = grid.cell_at(point.cells.front());
  Vec3 value{};
  for (int corner = 0; corner < grid.corners_per_cell(); ++corner) {
    double weight = 1;
    for (int a = 0; a < grid.dimension(); ++a) {
      const std::size_t axis = a;
      const double upper = in_cells(body, point.place, axis) - cell[axis];
      weight *= corner >> a & 1 ? upper : 1 - upper;
    }
    for (int b = 0; b < grid.dimension() && weight != 0; ++b)
      value[b] += weight * u(b, grid.corner(cell, corner));
  }
  return value;
}

using Tensor = std::array<double, 6>;

/// One component of R T R^T, with R the rotation from the body at rest to the world: strain and stress rotate
/// with the body or, at finite strain, with cells.
double component_in_world(const Placement& placement, const Tensor& t, std::size_t row, std::size_t column) {
  const std::array<Vec3, 3> rows{{{t[0], t[3], t[5]}, {t[3], t[1], t[4]}, {t[5], t[4], t[2]}}};
  const Vec3 &left = placement.direction[row], &right = placement.direction[column];
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    sum += left[i] * dot(rows[i], right);
  return sum;
}

/// Angle between the first two points and the last two; three points share the middle one.
double angle_of(const std::vector<Vec3>& at) {
  const Vec3 a = at.size() == 3 ? minus(at[0], at[1]) : minus(at[1], at[0]),
             b = minus(at.back(), at[at.size() - 2]);
  return std::atan2(norm(cross(a, b)), dot(a, b));
}

double length_of(const std::vector<Vec3>& at) {
  double sum = 0;
  for (std::size_t i = 1; i < at.size(); ++i)
    sum += distance(at[i], at[i - 1]);
  return sum;
}

/// Evaluates measures on one answer.
class Evaluation {
public:
  Evaluation(const Scene& scene, const Answer& answer, const std::vector<double>& cell_energy)
      : scene_(scene), body_(scene.specimen), answer_(answer), u_(answer.displacement),
        of_cells_(scene.specimen, answer), energy_(cell_energy.empty() ? answer.cell_energy : cell_energy) {}

  MeasuredValue operator()(const Measure& measure) {
    MeasuredValue result;
    result.name = measure.name;
    result.unit = unit_of(measure, scene_.dimension());
    result.is_vector = measure.is_vector() && !measure.is_line;
    result.is_line = measure.is_line;
    switch (measure.kind) {
    case MeasureKind::force:
      take_force(measure, result);
      break;
    case MeasureKind::displacement:
      take_displacement(measure, result);
      break;
    case MeasureKind::strain:
    case MeasureKind::stress:
      take_tensor(measure, result);
      break;
    case MeasureKind::length:
    case MeasureKind::angle:
      take_geometry(measure, result);
      break;
    case MeasureKind::volume:
      take_volume(measure, result);
      break;
    case MeasureKind::energy:
      take_energy(measure, result);
      break;
    }
    return result;
  }

private:
  void take_force(const Measure& measure, MeasuredValue& result) {
    if (answer_.reaction.empty() || answer_.reaction.size() != scene_.prescribed.size()) {
      result.why_not = fmt::format("{} knows no forces", answer_.method);
      return;
    }
    Vec3 force{};
    for (std::size_t i = 0; i < answer_.reaction.size(); ++i) {
      const Prescribed& p = scene_.prescribed[i];
      result.scale += std::abs(answer_.reaction[i]);
      if (measure.condition ? p.condition == *measure.condition
                            : std::ranges::binary_search(measure.nodes, p.node))
        force[p.component] += answer_.reaction[i] * (measure.cells.empty() ? 1 : share_of(measure.cells, p));
    }
    if (measure.section)
      force = force_across(scene_, *measure.section, answer_);
    give(measure, to_world(body_.placement, force), result);
  }

  /// Share of a node's force that its cells in `cells` carry: each in proportion to its stiffness along the
  /// component, as for cells in parallel. Only cells with the most held corners (in powers of two) count:
  /// cells beside a hold carry none of it. The shares of all cells sum to 1.
  double share_of(const std::vector<std::int64_t>& cells, const Prescribed& p) {
    if (held_.empty())
      for (const Prescribed& one : scene_.prescribed)
        held_.insert(one.node * 3 + one.component);
    double own = 0, all = 0;
    int most = 0;
    const Grid& grid = body_.grid;
    body_.for_each_cell_at(grid.node_at(p.node), [&](std::int64_t cell) {
      unsigned corners = 0;
      for (int corner = 0; corner < grid.corners_per_cell(); ++corner)
        corners += held_.contains(grid.corner(grid.cell_at(cell), corner) * 3 + p.component) ? 1 : 0;
      const int rank = std::bit_width(corners);
      if (rank < most)
        return;
      if (rank > most)
        own = all = 0;
      most = rank;
      const double weight = body_.weight_of(cell) * scene_.object_stiffness(cell)(p.component, p.component);
      all += weight;
      own += std::ranges::binary_search(cells, cell) ? weight : 0;
    });
    return own / all;
  }

  void take_displacement(const Measure& measure, MeasuredValue& result) const {
    result.scale = largest_displacement();
    const auto at = [&](const MaterialPoint& point) {
      return to_world(body_.placement, displacement_at(body_, u_, point));
    };
    if (measure.is_line) {
      for (const MaterialPoint& point : measure.points) {
        LinePoint& entry = add_to_line(measure, point, result);
        if (point.cells.empty())
          continue;
        const Vec3 u = at(point);
        entry.value = part_of(measure, u);
        if (measure.is_vector())
          entry.vector = u;
      }
      return;
    }
    if (!measure.points.empty()) {
      give(measure, at(measure.points.front()), result);
      return;
    }
    Vec3 sum{};
    double n = 0;
    const auto count = [&](const Vec3& u) {
      for (std::size_t a = 0; a < 3; ++a)
        sum[a] += u[a];
      ++n;
    };
    for (const std::int64_t node : measure.nodes)
      count(u_.at(node));
    for (const std::int64_t cell : measure.cells)
      for (int corner = 0; corner < body_.grid.corners_per_cell(); ++corner)
        count(of_cells_(body_.grid.corner(body_.grid.cell_at(cell), corner), cell));
    give(measure, to_world(body_.placement, {sum[0] / n, sum[1] / n, sum[2] / n}), result);
  }

  void take_tensor(const Measure& measure, MeasuredValue& result) {
    const bool is_stress = measure.kind == MeasureKind::stress;
    if (is_stress && !has_stress(answer_.method)) {
      result.why_not = fmt::format("{} knows no stress", answer_.method);
      return;
    }
    if (!fields_) {
      fields_ = cell_fields(scene_, answer_);
      for (std::size_t cell = 0; cell < fields_->strain.size(); ++cell)
        for (std::size_t k = 0; k < 6; ++k) {
          largest_strain_ = std::max(largest_strain_, std::abs(fields_->strain[cell][k]));
          largest_stress_ = std::max(largest_stress_, std::abs(fields_->stress[cell][k]));
        }
    }
    result.scale = is_stress ? largest_stress_ : largest_strain_;
    if (measure.is_line)
      for (const MaterialPoint& point : measure.points) {
        LinePoint& entry = add_to_line(measure, point, result);
        if (!point.cells.empty())
          entry.value = mean_of(measure, point.cells);
      }
    else
      result.value = mean_of(measure, measure.points.empty() ? measure.cells : measure.points.front().cells);
  }

  double mean_of(const Measure& measure, const std::vector<std::int64_t>& cells) const {
    double sum = 0;
    for (const std::int64_t cell : cells)
      sum += figure_of(measure, cell);
    return sum / static_cast<double>(cells.size());
  }

  double figure_of(const Measure& measure, std::int64_t cell) const {
    const std::size_t c = cell;
    const Tensor& t = measure.kind == MeasureKind::stress ? fields_->stress[c] : fields_->strain[c];
    const auto in_world = [&](std::size_t row, std::size_t column) {
      return component_in_world(body_.placement, t, row, column);
    };
    const auto main = [&](const Tensor& of) {
      return scene_.has_fibres() ? along(of, body_.fibre_of(cell)) : principal_values(of)[0];
    };
    switch (measure.figure) {
    case MeasureFigure::stretch:
      return std::sqrt(1 + 2 * main(green_lagrange(t)));
    case MeasureFigure::green_lagrange:
      return main(green_lagrange(t));
    case MeasureFigure::logarithmic:
      return main(logarithmic(t));
    case MeasureFigure::nominal:
      return main(nominal(fields_->strain[c], t));
    case MeasureFigure::fibre:
      return along(t, body_.fibre_of(cell));
    case MeasureFigure::largest:
      return principal_values(t)[0];
    case MeasureFigure::smallest:
      return principal_values(t)[2];
    case MeasureFigure::xx:
      return in_world(0, 0);
    case MeasureFigure::yy:
      return in_world(1, 1);
    case MeasureFigure::zz:
      return in_world(2, 2);
    case MeasureFigure::xy:
      return in_world(0, 1);
    case MeasureFigure::yz:
      return in_world(1, 2);
    case MeasureFigure::xz:
      return in_world(0, 2);
    case MeasureFigure::pressure:
      return -(t[0] + t[1] + t[2]) / 3;
    default:
      return fields_->von_mises[c];
    }
  }

  void take_geometry(const Measure& measure, MeasuredValue& result) const {
    std::vector<Vec3> rest, deformed;
    for (const MaterialPoint& point : measure.points) {
      rest.push_back(point.place);
      const Vec3 u = displacement_at(body_, u_, point);
      deformed.push_back({point.place[0] + u[0], point.place[1] + u[1], point.place[2] + u[2]});
    }
    const bool is_angle = measure.kind == MeasureKind::angle;
    result.scale = is_angle ? 1 : length_of(rest);
    give_change(measure, is_angle ? angle_of(rest) : length_of(rest),
                is_angle ? angle_of(deformed) : length_of(deformed), result);
  }

  void take_volume(const Measure& measure, MeasuredValue& result) const {
    const double of_cell = cell_volume(body_.grid);
    double tissue = 0, ratios = 0;
    const VolumeRatio ratio(body_.grid);
    for (const std::int64_t cell : measure.cells) {
      tissue += body_.tissue_of(cell);
      ratios += body_.tissue_of(cell) * ratio(of_cells_, cell);
    }
    const double rest = of_cell * tissue;
    result.scale = rest;
    give_change(measure, rest, of_cell * ratios, result);
  }

  void take_energy(const Measure& measure, MeasuredValue& result) const {
    if (energy_.empty()) {
      result.why_not = has_stress(answer_.method)
                           ? fmt::format("{} keeps no energies of cells", answer_.method)
                           : fmt::format("{} knows no energy", answer_.method);
      return;
    }
    result.value = 0;
    for (const std::int64_t cell : measure.cells)
      *result.value += energy_[cell];
    result.scale = std::accumulate(energy_.begin(), energy_.end(), 0.0);
  }

  static double part_of(const Measure& measure, const Vec3& vector) {
    return measure.figure == MeasureFigure::along ? dot(vector, measure.direction) : norm(vector);
  }

  static void give(const Measure& measure, const Vec3& vector, MeasuredValue& result) {
    result.value = part_of(measure, vector);
    if (measure.is_vector())
      result.vector = vector;
  }

  static void give_change(const Measure& measure, double rest, double deformed, MeasuredValue& result) {
    const double change = deformed - rest;
    result.value = measure.figure == MeasureFigure::change     ? change
                   : measure.figure == MeasureFigure::relative ? change / rest
                                                               : deformed;
    if (measure.figure == MeasureFigure::relative)
      result.scale = 1;
    if (measure.figure != MeasureFigure::value)
      result.scale *= 1e-6; // a difference of doubles of that size
  }

  static LinePoint& add_to_line(const Measure& measure, const MaterialPoint& point, MeasuredValue& result) {
    LinePoint& entry = result.line.emplace_back();
    entry.place = point.place;
    entry.along = distance(point.place, measure.points.front().place);
    return entry;
  }

  double largest_displacement() const {
    double largest = 0;
    for (const double value : u_.values())
      largest = std::max(largest, std::abs(value));
    return largest;
  }

  const Scene& scene_;
  const Specimen& body_;
  const Answer& answer_;
  const Displacement& u_;
  const DisplacementOfCells of_cells_; ///< on both sides of sliding borders
  const std::vector<double>& energy_;
  std::optional<CellFields> fields_;
  std::unordered_set<std::int64_t> held_; ///< components of nodes: 3 node + component
  double largest_strain_ = 0, largest_stress_ = 0;
};

} // namespace

std::vector<MeasuredValue> measured(const Scene& scene, const std::vector<Measure>& measures,
                                    const Answer& answer, const std::vector<double>& cell_energy) {
  Evaluation evaluation(scene, answer, cell_energy);
  std::vector<MeasuredValue> values;
  values.reserve(measures.size());
  for (const Measure& measure : measures)
    values.push_back(evaluation(measure));
  return values;
}

MaterialPoint located(const Specimen& body, const Vec3& place) {
  const std::size_t d = body.grid.dimension();
  Index3 low{}, high{};
  for (std::size_t a = 0; a < d; ++a) {
    const double at = in_cells(body, place, a), n = body.grid.cells()[a];
    if (!(at >= 0 && at <= n))
      return {place, {}};
    high[a] = static_cast<int>(std::min(std::floor(at), n - 1));
    low[a] = static_cast<int>(std::max(std::ceil(at) - 1, 0.0));
  }
  MaterialPoint point{place, {}};
  for (std::size_t a = 0; a < d; ++a) // includes borders of finer lattices
    if (const double at = in_cells(body, place, a); at == std::round(at))
      point.place[a] = body.origin[a] + at * body.grid.spacing()[a];
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i)
        if (const std::int64_t cell = body.grid.cell({i, j, k}); body.is_matter(cell))
          point.cells.push_back(cell);
  return point;
}

} // namespace maille
