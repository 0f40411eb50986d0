#include "maille/base/vectors.hpp"
#include "maille/mechanics/recovery.hpp"

#include <cmath>

namespace maille {

namespace {

/// Resultants below this part of the sum of magnitudes are in balance, as for a hold without load: the
/// remainder is solver tolerance and has no error of its own.
constexpr double negligible = 1e-3;

/// Relative error of all resultants together; both lists have the same order.
std::optional<double> force_error(const std::vector<Resultant>& found, const std::vector<Resultant>& wanted,
                                  double scale) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < wanted.size() && i < found.size(); ++i) {
    const Vec3 &f = found[i].force, &r = wanted[i].force;
    difference = std::hypot(difference, distance(f, r));
    size = std::hypot(size, norm(r));
  }
  return found.size() == wanted.size() && size > negligible * scale ? std::optional(difference / size)
                                                                    : std::nullopt;
}

/// Sums of squares of symmetric tensors; each shear counts twice, as among the nine entries.
struct Squares {
  double difference = 0, size = 0;
  void add(const std::array<double, 6>& found, const std::array<double, 6>& wanted) {
    for (std::size_t k = 0; k < 6; ++k) {
      const double weight = k < 3 ? 1 : 2, d = found[k] - wanted[k];
      difference += weight * d * d;
      size += weight * wanted[k] * wanted[k];
    }
  }
  std::optional<double> relative() const {
    return size > 0 ? std::optional(std::sqrt(difference / size)) : std::nullopt;
  }
};

/// Relative L2 error over cells.
std::optional<double> tensor_error(const std::vector<std::array<double, 6>>& found,
                                   const std::vector<std::array<double, 6>>& wanted,
                                   const std::vector<bool>& counts) {
  Squares squares;
  for (std::size_t cell = 0; cell < counts.size(); ++cell)
    if (counts[cell])
      squares.add(found[cell], wanted[cell]);
  return squares.relative();
}

/// Relative L2 error over the middles of halves, quarters or eighths of cells.
std::optional<double> recovered_error(const Scene& scene, const RecoveredFields& found,
                                      const RecoveredFields& wanted, const std::vector<bool>& counts) {
  const int dimension = scene.dimension();
  Squares squares;
  for (std::size_t cell = 0; cell < counts.size(); ++cell)
    for (int part = 0; part < (1 << dimension) && counts[cell]; ++part) {
      Vec3 in_cell{0.5, 0.5, 0.5};
      for (int a = 0; a < dimension; ++a)
        in_cell[a] = part >> a & 1 ? 0.75 : 0.25;
      const auto at = static_cast<std::int64_t>(cell);
      squares.add(found.at(at, in_cell).stress, wanted.at(at, in_cell).stress);
    }
  return squares.relative();
}

} // namespace

std::vector<bool> cells_at_edges(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  std::vector<bool> is_prescribed(grid.n_nodes(), false),
      is_left_out(static_cast<std::size_t>(grid.n_cells()), false);
  if (scene.dimension() == 1)
    return is_left_out;
  for (const Prescribed& p : scene.prescribed)
    is_prescribed[p.node] = true;
  const auto is_edge = [&](const Index3& node) {
    int axes = 0;
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      bool is_free = false;
      for (const int step : {-1, 0}) { // the links on either side
        Index3 tail = node;
        tail[axis] += step;
        Index3 other = tail;
        other[axis] += step == 0 ? 1 : 0;
        if (!grid.has_node(other) || is_prescribed[grid.node(other)])
          continue;
        int cells = 0;
        body.for_each_cell_at_link(tail, axis, [&](std::int64_t) { ++cells; });
        if (cells > 0 && cells < grid.corners_per_cell() / 2)
          return true;
        is_free = is_free || cells > 0;
      }
      axes += is_free ? 1 : 0;
    }
    return axes > 1;
  };
  for (const Prescribed& p : scene.prescribed)
    if (const Index3 node = grid.node_at(p.node); is_edge(node))
      body.for_each_cell_at(node, [&](std::int64_t cell) { is_left_out[cell] = true; });
  return is_left_out;
}

MechanicsReference::MechanicsReference(const Scene& scene, const Answer& reference, bool recovers)
    : scene_(scene), reference_(reference), resultants_(resultants_of(scene, reference)),
      counts_(cells_at_edges(scene)), fields_(std::make_unique<CellFields>(cell_fields(scene, reference))) {
  for (const double force : reference.reaction)
    pulled_ += std::abs(force);
  for (std::size_t cell = 0; cell < counts_.size(); ++cell)
    counts_[cell] = !counts_[cell] && scene.specimen.is_matter(static_cast<std::int64_t>(cell));
  if (recovers && has_stress(reference.method))
    recovered_ = std::make_unique<RecoveredFields>(scene, *fields_);
}

MechanicsReference::~MechanicsReference() = default;

MechanicsErrors MechanicsReference::errors_of(const Answer& answer) const {
  MechanicsErrors errors;
  const Mechanics found = resultants_of(scene_, answer);
  if (const bool is_moved = !resultants_.moves.empty(); is_moved || !resultants_.holds.empty())
    errors.force = force_error(is_moved ? found.moves : found.holds,
                               is_moved ? resultants_.moves : resultants_.holds, pulled_);
  if (answer.strain_energy && reference_.strain_energy && *reference_.strain_energy > 0)
    errors.strain_energy = std::abs(*answer.strain_energy / *reference_.strain_energy - 1);
  const CellFields fields = cell_fields(scene_, answer);
  errors.strain = tensor_error(fields.strain, fields_->strain, counts_);
  if (!has_stress(answer.method) || !has_stress(reference_.method))
    return errors;
  errors.stress = tensor_error(fields.stress, fields_->stress, counts_);
  if (recovered_)
    errors.recovered_stress = recovered_error(scene_, RecoveredFields(scene_, fields), *recovered_, counts_);
  return errors;
}

MechanicsErrors compare_mechanics(const Scene& scene, const Answer& answer, const Answer& reference) {
  return MechanicsReference(scene, reference, false).errors_of(answer);
}

} // namespace maille
