#include "maille/scene/cell_fields.hpp"
#include "maille/scene/mechanics/mechanics.hpp"

#include <algorithm>
#include <cmath>

namespace maille {

namespace {

/// Forces that cancel to less than this part of their sizes are rounding.
constexpr double negligible = 1e-6;

double length(const Vec3& v) {
  return std::hypot(v[0], v[1], v[2]);
}

/// Of all resultants together, those of one scene in the same order.
std::optional<double> force_error(const std::vector<Resultant>& found, const std::vector<Resultant>& wanted,
                                  double scale) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < wanted.size() && i < found.size(); ++i) {
    const Vec3 &f = found[i].force, &r = wanted[i].force;
    difference = std::hypot(difference, length({f[0] - r[0], f[1] - r[1], f[2] - r[2]}));
    size = std::hypot(size, length(r));
  }
  return found.size() == wanted.size() && size > negligible * scale ? std::optional(difference / size)
                                                                    : std::nullopt;
}

/// L2 over cells of symmetric tensors, with the weight of the tensor's nine entries.
std::optional<double> tensor_error(const std::vector<std::array<double, 6>>& found,
                                   const std::vector<std::array<double, 6>>& wanted,
                                   const std::vector<bool>& counts) {
  double difference = 0, size = 0;
  for (std::size_t cell = 0; cell < counts.size(); ++cell)
    for (std::size_t k = 0; k < 6 && counts[cell]; ++k) {
      const double weight = k < 3 ? 1 : 2, d = found[cell][k] - wanted[cell][k];
      difference += weight * d * d;
      size += weight * wanted[cell][k] * wanted[cell][k];
    }
  return size > 0 ? std::optional(std::sqrt(difference / size)) : std::nullopt;
}

} // namespace

std::vector<bool> cells_at_edges(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const Grid& grid = body.grid;
  std::vector<bool> is_prescribed(static_cast<std::size_t>(grid.n_nodes()), false),
      is_left_out(static_cast<std::size_t>(grid.n_cells()), false);
  if (scene.dimension() == 1)
    return is_left_out;
  for (const Prescribed& p : scene.prescribed)
    is_prescribed[static_cast<std::size_t>(p.node)] = true;
  const auto is_edge = [&](const Index3& node) {
    int axes = 0;
    for (int axis = 0; axis < grid.dimension(); ++axis) {
      bool is_free = false;
      for (const int step : {-1, 0}) { // the links on either side
        Index3 tail = node;
        tail[static_cast<std::size_t>(axis)] += step;
        Index3 other = tail;
        other[static_cast<std::size_t>(axis)] += step == 0 ? 1 : 0;
        if (!grid.has_node(other) || is_prescribed[static_cast<std::size_t>(grid.node(other))])
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
      body.for_each_cell_at(node,
                            [&](std::int64_t cell) { is_left_out[static_cast<std::size_t>(cell)] = true; });
  return is_left_out;
}

MechanicsErrors compare_mechanics(const Scene& scene, const Answer& answer, const Answer& reference) {
  MechanicsErrors errors;
  const Mechanics found = resultants_of(scene, answer), wanted = resultants_of(scene, reference);
  double pulled = 0;
  for (const double force : reference.reaction)
    pulled += std::abs(force);
  if (const bool is_moved = !wanted.moves.empty(); is_moved || !wanted.holds.empty())
    errors.force =
        force_error(is_moved ? found.moves : found.holds, is_moved ? wanted.moves : wanted.holds, pulled);
  if (answer.strain_energy && reference.strain_energy && *reference.strain_energy > 0)
    errors.strain_energy = std::abs(*answer.strain_energy / *reference.strain_energy - 1);
  std::vector<bool> counts = cells_at_edges(scene);
  for (std::size_t cell = 0; cell < counts.size(); ++cell)
    counts[cell] = !counts[cell] && scene.specimen.is_matter(static_cast<std::int64_t>(cell));
  const CellFields fields = cell_fields(scene, answer.displacement),
                   truth = cell_fields(scene, reference.displacement);
  errors.strain = tensor_error(fields.strain, truth.strain, counts);
  if (has_stress(answer.method) && has_stress(reference.method))
    errors.stress = tensor_error(fields.stress, truth.stress, counts);
  return errors;
}

} // namespace maille
