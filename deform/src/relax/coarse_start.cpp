#include "relax/coarse_start.hpp"

#include "maille/scene/rigid_motions.hpp"
#include "relax/box_solver.hpp"
#include "relax/box_system.hpp"
#include "relax/lattice_elasticity.hpp"
#include "relax/legal_state.hpp"
#include "relax/newton_optimum.hpp"

#include <algorithm>

namespace maille::deform {

namespace {

/// A body with fewer cells along an axis is not worth coarsening.
constexpr int fewest_cells = 4;
/// Half a spacing is about a hundredth of an answer: more accuracy would be lost on the way to the finer body.
constexpr double tolerance = 1e-2;

class LatticeSystem : public CoupledSystem {
public:
  LatticeSystem(const Scene& scene, ThreadTeam& team) : elasticity_(scene), team_(team) {}
  void apply(const Displacement& u, Displacement& forces) override { elasticity_.apply(u, forces, team_); }

private:
  LatticeElasticity elasticity_;
  ThreadTeam& team_;
};

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
  coarse.relaxation.tolerance = std::max(tolerance, fine.relaxation.tolerance);
  coarse.specimen.grid = Grid(grid.dimension(), cells, spacing);
  coarse.specimen.fibre = fine.specimen.fibre;
  coarsen_matter(fine.specimen, coarse.specimen);
  coarse.tractions = coarse_tractions(fine, coarse.specimen);
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

void interpolate_from_coarser(const Specimen& coarse, const Displacement& from, const Specimen& fine,
                              Displacement& to) {
  std::vector<bool> is_node(static_cast<std::size_t>(coarse.grid.n_nodes()));
  for (std::size_t node = 0; node < is_node.size(); ++node)
    is_node[node] = coarse.is_node(coarse.grid.node_at(static_cast<std::int64_t>(node)));
  for (std::int64_t node = 0; node < fine.grid.n_nodes(); ++node) {
    const Index3 at = fine.grid.node_at(node);
    if (!fine.is_node(at))
      continue;
    std::array<std::int64_t, 8>
        around{}; // those of odd places are counted once, of even ones twice: even weights
    std::size_t n = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Index3 place{(at[0] + (corner & 1)) / 2, (at[1] + (corner >> 1 & 1)) / 2,
                         (at[2] + (corner >> 2 & 1)) / 2};
      const std::int64_t other = coarse.grid.node(place);
      if (is_node[static_cast<std::size_t>(other)])
        around[n++] = other;
    }
    for (int b = 0; b < fine.grid.dimension() && n > 0; ++b) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i)
        sum += from(b, around[i]);
      to(b, node) = sum / static_cast<double>(n);
    }
  }
}

namespace {

/// Calls visit(system), which has a multigrid of its own if it is to and can.
template<class Visit>
void with_system(const CoupledTask& task, bool has_multigrid, const Visit& visit) {
  if (has_multigrid && is_uniform_box(task.scene)) {
    BoxSolver solver(task);
    BoxSystem system(solver.multigrid(), solver.unit());
    visit(system);
  } else {
    LatticeSystem system(task.scene, task.team);
    visit(system);
  }
}

} // namespace

bool start_from_coarser(const CoupledTask& task, CoupledOptimum& optimum, Displacement& u) {
  const std::optional<Scene> scene = coarser_scene(task.scene, task.prescribed);
  if (!scene)
    return false;
  const LinkLimits limits(*scene);
  const Admission admission = admit_fast(*scene, limits, task.control.threads);
  const CoupledTask coarse{*scene,         task.control, admission.prescribed, task.team, task.clock,
                           task.must_stop, &limits};
  Displacement v(scene->specimen.grid);
  for (const Prescribed& p : admission.prescribed)
    v(p.component, p.node) = p.value;
  with_system(coarse, optimum.has_multigrid(), [&](CoupledSystem& system) {
    const auto coarse_optimum = make_optimum(coarse, system);
    start_from_coarser(coarse, *coarse_optimum, v);
    Answer unused;
    coarse_optimum->solve(v, unused);
    optimum.take_over(*coarse_optimum);
  });
  if (task.must_stop()) // half a coarse answer is worse than the finer elastic one
    return false;
  interpolate_from_coarser(scene->specimen, v, task.scene.specimen, u);
  for (const Prescribed& p : task.prescribed)
    u(p.component, p.node) = p.value;
  return true;
}

} // namespace maille::deform
