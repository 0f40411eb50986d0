#include "relax/coarser_scene.hpp"

#include "maille/scene/refined.hpp"
#include "maille/scene/rigid_motions.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace maille::deform {

namespace {

/// A body with fewer cells along an axis is not worth coarsening.
constexpr int fewest_cells = 4;
constexpr double rounding = 1e-9; // of the largest value

/// What most of the cells of a coarse cell hold, and the fibres of the first of them.
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
      children[static_cast<std::size_t>(child)] = fine.grid.cell(place);
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
      coarse.fibres.push_back(fine.fibres[static_cast<std::size_t>(*first)]);
  }
}

/// Tractions on the faces of coarse cells, each of 2^(dimension - 1) fine ones.
std::vector<FaceLoad> coarse_tractions(const Scene& fine, const Specimen& coarse) {
  std::vector<FaceLoad> loads;
  for (FaceLoad load : fine.tractions) {
    Index3 at = fine.specimen.grid.cell_at(load.cell);
    const bool is_outer = (at[static_cast<std::size_t>(load.axis)] & 1) == (load.upper ? 1 : 0);
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
  std::vector<double> stress(static_cast<std::size_t>(coarse.n_cells()), 0);
  std::vector<int> count(stress.size(), 0);
  for (std::int64_t cell = 0; cell < fine.specimen.grid.n_cells(); ++cell) {
    if (!fine.specimen.is_matter(cell))
      continue;
    Index3 at = fine.specimen.grid.cell_at(cell);
    for (int& i : at)
      i /= 2;
    const auto parent = static_cast<std::size_t>(coarse.cell(at));
    stress[parent] += fine.active_stress[static_cast<std::size_t>(cell)];
    ++count[parent];
  }
  for (std::size_t cell = 0; cell < stress.size(); ++cell)
    stress[cell] /= std::max(count[cell], 1);
  return stress;
}

bool is_same_matter(const Scene& a, const Scene& b) {
  const bool turns = !std::ranges::all_of(
      a.materials, [](const Material& material) { return material.elasticity.is_isotropic(); });
  for (std::int64_t cell = 0; cell < a.specimen.grid.n_cells(); ++cell)
    if (a.specimen.material(cell) != b.specimen.material(cell) ||
        (turns && a.specimen.is_matter(cell) && a.specimen.fibre_of(cell) != b.specimen.fibre_of(cell)))
      return false;
  return true;
}

bool is_same_prescribed(const std::vector<Prescribed>& a, const std::vector<Prescribed>& b) {
  double largest = 0;
  for (const Prescribed& p : a)
    largest = std::max(largest, std::abs(p.value));
  return std::ranges::equal(a, b, [&](const Prescribed& p, const Prescribed& q) {
    return p.node == q.node && p.component == q.component &&
           std::abs(p.value - q.value) <= rounding * largest;
  });
}

/// Per face, however many loads share it.
std::map<std::tuple<std::int64_t, int, bool>, Vec3> traction_by_face(const Scene& scene) {
  std::map<std::tuple<std::int64_t, int, bool>, Vec3> sums;
  for (const FaceLoad& load : scene.tractions) {
    Vec3& sum = sums.try_emplace({load.cell, load.axis, load.upper}).first->second;
    for (std::size_t a = 0; a < 3; ++a)
      sum[a] += load.traction[a];
  }
  return sums;
}

bool is_same_traction(const Scene& a, const Scene& b) {
  const auto of_a = traction_by_face(a), of_b = traction_by_face(b);
  double largest = 0;
  for (const auto& [face, traction] : of_a)
    for (const double value : traction)
      largest = std::max(largest, std::abs(value));
  return std::ranges::equal(of_a, of_b, [&](const auto& p, const auto& q) {
    double difference = 0;
    for (std::size_t i = 0; i < 3; ++i)
      difference = std::max(difference, std::abs(p.second[i] - q.second[i]));
    return p.first == q.first && difference <= rounding * largest;
  });
}

} // namespace

std::optional<Scene> coarser_scene(const Scene& fine, const std::vector<Prescribed>& prescribed) {
  const Grid& grid = fine.specimen.grid;
  Index3 cells = grid.cells();
  Vec3 spacing = grid.spacing();
  for (std::size_t a = 0; a < static_cast<std::size_t>(grid.dimension()); ++a) {
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
  const Scene again = refined(coarse);
  if (!is_same_matter(again, fine))
    return "cells twice as large are not of one matter each";
  if (!is_same_prescribed(again.prescribed, prescribed))
    return "every second node does not have what is prescribed between them";
  if (!is_same_traction(again, fine))
    return "faces twice as large do not have one traction each";
  if (again.active_stress != fine.active_stress)
    return "cells twice as large do not contract alike";
  return {};
}

} // namespace maille::deform
