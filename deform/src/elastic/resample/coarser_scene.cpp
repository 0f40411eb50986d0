#include "elastic/resample/coarser_scene.hpp"

#include "lattice/tolerances.hpp"
#include "maille/scene/plausibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

namespace maille::deform {

namespace {

/// A body with fewer cells along an axis is not worth coarsening.
constexpr int fewest_cells = 4;

/// The majority material of a coarse cell, and the fibres of its first cell.
void coarsen_matter(const Specimen& fine, Specimen& coarse) {
  if (fine.material_id.empty() && fine.fibres.empty())
    return;
  const Grid& grid = coarse.grid;
  const int corners = grid.corners_per_cell();
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell) {
    const Index3 at = grid.cell_at(cell);
    std::array<std::int64_t, 8> children{};
    std::uint8_t most = no_material;
    int count = 0;
    for (int child = 0; child < corners; ++child) {
      Index3 place{};
      for (std::size_t a = 0; a < 3; ++a)
        place[a] = static_cast<int>(a) < grid.dimension() ? 2 * at[a] + (child >> a & 1) : 0;
      children[child] = fine.grid.cell(place);
    }
    const auto end = children.begin() + corners;
    for (auto child = children.begin(); child != end; ++child) {
      const std::uint8_t id = fine.material(*child);
      const auto same = static_cast<int>(std::count_if(
          children.begin(), end, [&](std::int64_t other) { return fine.material(other) == id; }));
      if (same > count || (same == count && most == no_material))
        most = id, count = same;
    }
    if (!fine.material_id.empty())
      coarse.material_id.push_back(most);
    const auto first =
        std::find_if(children.begin(), end, [&](std::int64_t child) { return fine.material(child) == most; });
    if (!fine.fibres.empty())
      coarse.fibres.push_back(fine.fibres[*first]);
  }
}

/// Tractions on the faces of coarse cells, each of 2^(dimension - 1) fine ones.
std::vector<FaceLoad> coarse_tractions(const Scene& fine, const Specimen& coarse) {
  std::vector<FaceLoad> loads;
  for (FaceLoad load : fine.tractions) {
    Index3 at = fine.specimen.grid.cell_at(load.cell);
    const bool is_outer = (at[load.axis] & 1) == (load.upper ? 1 : 0);
    for (int& i : at)
      i /= 2;
    load.cell = coarse.grid.cell(at);
    for (double& value : load.traction)
      value *= 2.0 / fine.specimen.grid.corners_per_cell();
    if (is_outer && coarse.is_matter(load.cell))
      loads.push_back(load);
  }
  return loads;
}

/// The mean of the fine cells of matter in a coarse one.
std::vector<double> coarse_active_stress(const Scene& fine, const Grid& coarse) {
  std::vector<double> stress(coarse.n_cells(), 0);
  std::vector<int> count(stress.size(), 0);
  for (std::int64_t cell = 0; cell < fine.specimen.grid.n_cells(); ++cell) {
    if (!fine.specimen.is_matter(cell))
      continue;
    Index3 at = fine.specimen.grid.cell_at(cell);
    for (int& i : at)
      i /= 2;
    const auto parent = static_cast<std::size_t>(coarse.cell(at));
    stress[parent] += fine.active_stress[cell];
    ++count[parent];
  }
  for (std::size_t cell = 0; cell < stress.size(); ++cell)
    stress[cell] /= std::max(count[cell], 1);
  return stress;
}

Index3 half_of(const Index3& at) {
  return {at[0] / 2, at[1] / 2, at[2] / 2};
}

bool is_same_contraction(const Scene& coarse, const Scene& fine) {
  const Grid& grid = fine.specimen.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells() && fine.contracts(); ++cell)
    if (fine.specimen.is_matter(cell) &&
        coarse.active_stress[coarse.specimen.grid.cell(half_of(grid.cell_at(cell)))] !=
            fine.active_stress[cell])
      return false;
  return true;
}

/// True if each fine cell holds the same matter as its coarse cell.
bool is_same_matter(const Scene& coarse, const Scene& fine) {
  const Specimen &of_coarse = coarse.specimen, &of_fine = fine.specimen;
  const bool turns =
      !of_fine.fibres.empty() && !std::ranges::all_of(fine.materials, [](const Material& material) {
        return material.elasticity.is_isotropic();
      });
  if (of_fine.material_id.empty() && !turns)
    return true;
  for (std::int64_t cell = 0; cell < of_fine.grid.n_cells(); ++cell) {
    const std::int64_t parent = of_coarse.grid.cell(half_of(of_fine.grid.cell_at(cell)));
    if (of_coarse.material(parent) != of_fine.material(cell) ||
        (turns && of_fine.is_matter(cell) && of_coarse.fibre_of(parent) != of_fine.fibre_of(cell)))
      return false;
  }
  return true;
}

/// Values of one component by node; NaN where it is free.
std::vector<double> values_by_node(const Scene& scene, int component) {
  std::vector<double> value(scene.specimen.grid.n_nodes(), std::numeric_limits<double>::quiet_NaN());
  for (const Prescribed& p : scene.prescribed)
    if (p.component == component)
      value[p.node] = p.value;
  return value;
}

/// Mean over the coarse nodes around a fine node; NaN if one of them is free. At even positions nodes count
/// several times, all equally.
double mean_around(const Grid& coarse, const std::vector<double>& value, const Index3& fine) {
  double sum = 0;
  for (int corner = 0; corner < 8; ++corner)
    sum += value[coarse.node({(fine[0] + (corner & 1)) / 2, (fine[1] + (corner >> 1 & 1)) / 2,
                              (fine[2] + (corner >> 2 & 1)) / 2})];
  return sum / 8;
}

/// Number of fine nodes of the body whose coarse neighbours are all prescribed.
std::int64_t n_between(const Scene& coarse, const std::vector<double>& value, int component,
                       const Specimen& fine) {
  std::int64_t n = 0;
  for (const Prescribed& p : coarse.prescribed) {
    if (p.component != component)
      continue;
    const Index3 first = coarse.specimen.grid.node_at(p.node);
    for (int corner = 0; corner < fine.grid.corners_per_cell(); ++corner) {
      const Index3 at{2 * first[0] + (corner & 1), 2 * first[1] + (corner >> 1 & 1),
                      2 * first[2] + (corner >> 2 & 1)};
      if (fine.grid.has_node(at) && !std::isnan(mean_around(coarse.specimen.grid, value, at)) &&
          fine.is_node(at))
        ++n;
    }
  }
  return n;
}

/// As in refined(): a fine node is prescribed, at the mean, if all its coarse neighbours are.
bool is_same_prescribed(const Scene& coarse, const Scene& fine, const std::vector<Prescribed>& prescribed) {
  double largest = 0;
  for (const Prescribed& p : prescribed)
    largest = std::max(largest, std::abs(p.value));
  for (int component = 0; component < fine.dimension(); ++component) {
    const std::vector<double> value = values_by_node(coarse, component);
    std::int64_t n = 0;
    for (const Prescribed& p : prescribed) {
      if (p.component != component)
        continue;
      const double mean = mean_around(coarse.specimen.grid, value, fine.specimen.grid.node_at(p.node));
      if (!(std::abs(mean - p.value) <= tolerance * largest))
        return false;
      ++n;
    }
    if (n != n_between(coarse, value, component, fine.specimen))
      return false;
  }
  return true;
}

using TractionByFace = std::map<std::tuple<std::int64_t, int, bool>, Vec3>;

/// Sums loads that share a face.
TractionByFace traction_by_face(const Scene& scene) {
  TractionByFace sums;
  for (const FaceLoad& load : scene.tractions) {
    Vec3& sum = sums.try_emplace({load.cell, load.axis, load.upper}).first->second;
    for (std::size_t a = 0; a < 3; ++a)
      sum[a] += load.traction[a];
  }
  return sums;
}

/// Distributes the tractions of coarse faces to their fine faces.
TractionByFace on_parts(const TractionByFace& coarse, const Grid& grid, const Grid& fine) {
  TractionByFace parts;
  for (const auto& [face, traction] : coarse) {
    const auto [cell, axis, is_upper] = face;
    const Index3 at = grid.cell_at(cell);
    for (int child = 0; child < grid.corners_per_cell(); ++child)
      if ((child >> axis & 1) == (is_upper ? 1 : 0))
        parts[{
            fine.cell({2 * at[0] + (child & 1), 2 * at[1] + (child >> 1 & 1), 2 * at[2] + (child >> 2 & 1)}),
            axis, is_upper}] = traction;
  }
  return parts;
}

bool is_same_traction(const Scene& coarse, const Scene& fine) {
  const auto asked = traction_by_face(fine),
             kept = on_parts(traction_by_face(coarse), coarse.specimen.grid, fine.specimen.grid);
  double largest = 0;
  for (const auto& [face, traction] : asked)
    for (const double value : traction)
      largest = std::max(largest, std::abs(value));
  return std::ranges::equal(asked, kept, [&](const auto& p, const auto& q) {
    double difference = 0;
    for (std::size_t i = 0; i < 3; ++i)
      difference = std::max(difference, std::abs(p.second[i] - q.second[i]));
    return p.first == q.first && difference <= tolerance * largest;
  });
}

} // namespace

std::optional<Scene> coarser_scene(const Scene& fine, const std::vector<Prescribed>& prescribed) {
  const Grid& grid = fine.specimen.grid;
  Index3 cells = grid.cells();
  Vec3 spacing = grid.spacing();
  for (int a = 0; a < grid.dimension(); ++a) {
    if (cells[a] % 2 != 0 || cells[a] < 2 * fewest_cells)
      return std::nullopt;
    cells[a] /= 2;
    spacing[a] *= 2;
  }
  Scene coarse;
  coarse.materials = fine.materials;
  coarse.plane = fine.plane;
  coarse.gravity = fine.gravity;
  coarse.limits = fine.limits;
  coarse.relaxation.tolerance = fine.relaxation.tolerance;
  coarse.specimen.grid = Grid(grid.dimension(), cells, spacing);
  coarse.specimen.placement = fine.specimen.placement;
  coarse.specimen.fibre = fine.specimen.fibre;
  coarsen_matter(fine.specimen, coarse.specimen);
  coarse.tractions = coarse_tractions(fine, coarse.specimen);
  if (fine.contracts())
    coarse.active_stress = coarse_active_stress(fine, coarse.specimen.grid);
  for (Prescribed p : prescribed) {
    Index3 at = grid.node_at(p.node);
    if (std::ranges::any_of(at, [](int i) { return i % 2 != 0; }))
      continue;
    for (int& i : at)
      i /= 2;
    p.node = coarse.specimen.grid.node(at);
    if (coarse.specimen.is_node(at))
      coarse.prescribed.push_back(p);
  }
  std::ranges::sort(coarse.prescribed, {},
                    [](const Prescribed& p) { return std::pair(p.component, p.node); });
  if (coarse.prescribed.empty() || !remaining_rigid_motion(coarse).empty())
    return std::nullopt;
  return coarse;
}

std::string what_coarsening_loses(const Scene& coarse, const Scene& fine,
                                  const std::vector<Prescribed>& prescribed) {
  if (!is_same_matter(coarse, fine))
    return "cells twice as large are not of one matter each";
  if (!is_same_prescribed(coarse, fine, prescribed))
    return "every second node does not have what is prescribed between them";
  if (!is_same_traction(coarse, fine))
    return "faces twice as large do not have one traction each";
  if (!is_same_contraction(coarse, fine))
    return "cells twice as large do not contract alike";
  return {};
}

namespace {

std::size_t of(std::int64_t i) {
  return static_cast<std::size_t>(i);
}

bool fills_its_grid(const Specimen& body) {
  return std::ranges::find(body.material_id, no_material) == body.material_id.end();
}

/// Row y, z of a body that fills its grid.
void interpolate_row(const Grid& coarse, const double* from, const Grid& fine, int y, int z, double* to) {
  thread_local std::vector<double> mean;
  const int n = coarse.nodes()[0];
  mean.resize(of(n));
  const double *const below = from + coarse.node({0, y / 2, z / 2}),
                      *const before = from + coarse.node({0, (y + 1) / 2, z / 2}),
                      *const above = from + coarse.node({0, y / 2, (z + 1) / 2}),
                      *const behind = from + coarse.node({0, (y + 1) / 2, (z + 1) / 2});
  for (int x = 0; x < n; ++x)
    mean[of(x)] = 0.25 * ((below[x] + before[x]) + (above[x] + behind[x]));
  double* const row = to + fine.node({0, y, z});
  for (int x = 0; x + 1 < n; ++x) {
    row[2 * x] = mean[of(x)];
    row[2 * x + 1] = 0.5 * (mean[of(x)] + mean[of(x + 1)]);
  }
  row[2 * n - 2] = mean[of(n - 1)];
}

/// Coarse neighbours of a fine node that are nodes of the body. Neighbours at odd positions count once, at
/// even ones twice, so all weights are even.
class NodesAround {
public:
  explicit NodesAround(const Specimen& coarse) : grid_(coarse.grid), is_node_(of(coarse.grid.n_nodes())) {
    for (std::size_t node = 0; node < is_node_.size(); ++node)
      is_node_[node] = coarse.is_node(grid_.node_at(static_cast<std::int64_t>(node)));
  }
  /// Mean of `from` around a fine node; `otherwise` if `from` has no value there.
  double mean(std::span<const double> from, const Index3& fine, double otherwise) const {
    double sum = 0;
    int n = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const std::size_t node = of(grid_.node({(fine[0] + (corner & 1)) / 2, (fine[1] + (corner >> 1 & 1)) / 2,
                                              (fine[2] + (corner >> 2 & 1)) / 2}));
      if (is_node_[node])
        sum += from[node], ++n;
    }
    return n > 0 ? sum / n : otherwise;
  }

private:
  const Grid& grid_;
  std::vector<bool> is_node_;
};

} // namespace

void interpolate(const Specimen& coarse, std::span<const double> from, const Specimen& fine,
                 std::span<double> to, ThreadTeam& team) {
  const Index3& n = fine.grid.nodes();
  const std::size_t of_coarse = of(coarse.grid.n_nodes()), of_fine = of(fine.grid.n_nodes()),
                    fields = to.size() / of_fine;
  if (fills_its_grid(fine)) {
    team.run(n[2] * n[1], [&](int row, int) {
      for (std::size_t b = 0; b < fields; ++b)
        interpolate_row(coarse.grid, from.data() + b * of_coarse, fine.grid, row % n[1], row / n[1],
                        to.data() + b * of_fine);
    });
    return;
  }
  const NodesAround around(coarse);
  for (std::int64_t node = 0; node < fine.grid.n_nodes(); ++node)
    if (const Index3 at = fine.grid.node_at(node); fine.is_node(at))
      for (std::size_t b = 0; b < fields; ++b) {
        double& value = to[b * of_fine + of(node)];
        value = around.mean(from.subspan(b * of_coarse, of_coarse), at, value);
      }
}

} // namespace maille::deform
