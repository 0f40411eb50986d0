#include "maille/scene/refined.hpp"

#include "cell_values.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maille {

namespace {

Grid halved(const Grid& grid) {
  Index3 cells{1, 1, 1};
  Vec3 spacing = grid.spacing();
  for (int a = 0; a < grid.dimension(); ++a) {
    if (grid.cells()[a] > std::numeric_limits<int>::max() / 4)
      throw std::length_error("too many cells to halve them");
    cells[a] = 2 * grid.cells()[a];
    spacing[a] /= 2;
  }
  return {grid.dimension(), cells, spacing};
}

Index3 half_of(const Index3& at) {
  return {at[0] / 2, at[1] / 2, at[2] / 2};
}

/// Prescribed components of one axis, by node.
struct PrescribedByNode {
  std::vector<std::int32_t> entry; ///< in Scene::prescribed; -1: free
};

PrescribedByNode by_node(const Scene& scene, int component) {
  PrescribedByNode found{
      std::vector<std::int32_t>(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), -1)};
  for (std::size_t i = 0; i < scene.prescribed.size(); ++i)
    if (scene.prescribed[i].component == component)
      found.entry[scene.prescribed[i].node] = static_cast<std::int32_t>(i);
  return found;
}

/// Entries of the coarse nodes around a fine one; none if one of them is free.
std::vector<std::size_t> entries_around(const Scene& scene, const PrescribedByNode& known,
                                        const Index3& fine) {
  std::vector<std::size_t> entries;
  for (int corner = 0; corner < scene.specimen.grid.corners_per_cell(); ++corner) {
    Index3 at = half_of(fine);
    bool counts = true; // an even index coincides with one coarse node
    for (std::size_t a = 0; a < 3 && counts; ++a)
      if (corner >> a & 1) {
        counts = fine[a] % 2 != 0;
        ++at[a];
      }
    if (!counts)
      continue;
    const std::int32_t entry = known.entry[scene.specimen.grid.node(at)];
    if (entry < 0)
      return {};
    entries.push_back(static_cast<std::size_t>(entry));
  }
  return entries;
}

/// The mean of their values, if all are prescribed.
std::optional<Prescribed> mean_around(const Scene& scene, const PrescribedByNode& known, const Index3& fine,
                                      int component) {
  const std::vector<std::size_t> entries = entries_around(scene, known, fine);
  Prescribed mean{0, component, 0, true};
  for (const std::size_t entry : entries) {
    const Prescribed& p = scene.prescribed[entry];
    mean.value += p.value;
    mean.held = mean.held && p.held;
    mean.condition = p.condition;
  }
  mean.value /= static_cast<double>(entries.size());
  return entries.empty() ? std::nullopt : std::optional(mean);
}

std::vector<Prescribed> refine_prescribed(const Scene& scene, const Specimen& fine) {
  std::vector<Prescribed> prescribed;
  for (int component = 0; component < scene.dimension(); ++component) {
    const PrescribedByNode known = by_node(scene, component);
    for (std::int64_t node = 0; node < fine.grid.n_nodes(); ++node)
      if (auto p = mean_around(scene, known, fine.grid.node_at(node), component);
          p && fine.is_node(fine.grid.node_at(node))) {
        p->node = node;
        prescribed.push_back(*p);
      }
  }
  return prescribed;
}

/// @param faces FaceLoads or FaceSprings
template<class Face>
std::vector<Face> refine_faces(const std::vector<Face>& faces, const Grid& grid, const Grid& fine) {
  std::vector<Face> parts;
  for (const Face& face : faces) {
    const Index3 at = grid.cell_at(face.cell);
    for (int child = 0; child < grid.corners_per_cell(); ++child) {
      if ((child >> face.axis & 1) != (face.upper ? 1 : 0))
        continue;
      Face part = face;
      part.cell =
          fine.cell({2 * at[0] + (child & 1), 2 * at[1] + (child >> 1 & 1), 2 * at[2] + (child >> 2 & 1)});
      parts.push_back(part);
    }
  }
  return parts;
}

} // namespace

Scene refined(const Scene& scene) {
  Scene fine = scene;
  fine.specimen.grid = halved(scene.specimen.grid);
  const auto parent = [&](std::int64_t cell) {
    return scene.specimen.grid.cell(half_of(fine.specimen.grid.cell_at(cell)));
  };
  carry_cells(fine.specimen, parent);
  fine.prescribed = refine_prescribed(scene, fine.specimen);
  fine.tractions = refine_faces(scene.tractions, scene.specimen.grid, fine.specimen.grid);
  fine.springs = refine_faces(scene.springs, scene.specimen.grid, fine.specimen.grid);
  fine.active_stress = carried(scene.active_stress, fine.specimen.grid.n_cells(), 0.0, parent);
  fine.turns.clear(); // they refer to coarse nodes; their values are included above
  fine.drives.clear();
  fine.timed.clear();
  return fine;
}

Displacement at_coarse_nodes(const Scene& scene, const Scene& fine, const Displacement& displacement) {
  const Grid& grid = scene.specimen.grid;
  Displacement coarse(grid);
  const int twice_z = grid.dimension() > 2 ? 2 : 1, twice_y = grid.dimension() > 1 ? 2 : 1;
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    const Index3 at = grid.node_at(node);
    const std::int64_t twin = fine.specimen.grid.node({2 * at[0], twice_y * at[1], twice_z * at[2]});
    for (int c = 0; c < grid.dimension(); ++c)
      coarse(c, node) = displacement(c, twin);
  }
  return coarse;
}

void bring_to_coarse(const Scene& scene, const Scene& fine, Answer& answer) {
  const Grid &grid = scene.specimen.grid, &fine_grid = fine.specimen.grid;
  std::vector<std::array<double, 6>> strain(
      answer.cell_strain.empty() ? 0 : static_cast<std::size_t>(grid.n_cells()));
  for (std::size_t cell = 0; cell < answer.cell_strain.size(); ++cell) {
    const Index3 of = half_of(fine_grid.cell_at(static_cast<std::int64_t>(cell)));
    for (std::size_t k = 0; k < 6; ++k)
      strain[grid.cell(of)][k] += answer.cell_strain[cell][k] / grid.corners_per_cell();
  }
  answer.cell_strain = std::move(strain);
  answer.displacement = at_coarse_nodes(scene, fine, answer.displacement);
  std::vector<double> reaction(answer.reaction.empty() ? 0 : scene.prescribed.size());
  PrescribedByNode known;
  for (std::size_t i = 0; i < answer.reaction.size(); ++i) { // by component
    const Prescribed& p = fine.prescribed[i];
    if (i == 0 || p.component != fine.prescribed[i - 1].component)
      known = by_node(scene, p.component);
    const auto entries = entries_around(scene, known, fine_grid.node_at(p.node));
    for (const std::size_t entry : entries)
      reaction[entry] += answer.reaction[i] / static_cast<double>(entries.size());
  }
  answer.reaction = std::move(reaction);
  std::vector<double> energy(answer.cell_energy.empty() ? 0 : static_cast<std::size_t>(grid.n_cells()));
  for (std::size_t cell = 0; cell < answer.cell_energy.size(); ++cell)
    energy[grid.cell(half_of(fine_grid.cell_at(static_cast<std::int64_t>(cell))))] +=
        answer.cell_energy[cell];
  answer.cell_energy = std::move(energy);
  answer.nodal_strain.clear();
  answer.nodal_stress.clear();
}

} // namespace maille
