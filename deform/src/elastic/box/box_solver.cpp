#include "elastic/box/box_solver.hpp"

#include "elastic/box/box_multigrid.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "maille/scene/scene.hpp"
#include "parallel/thread_team.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

namespace maille::deform {

namespace {

/// Tolerances below this one ask for a state in float64.
constexpr double float32_is_enough = 5e-4;

std::array<std::vector<double>, 3> places(const Grid& grid) {
  std::array<std::vector<double>, 3> place;
  for (std::size_t a = 0; a < 3; ++a)
    for (int i = 0; i < grid.nodes()[a]; ++i)
      place[a].push_back(i * grid.spacing()[a]);
  return place;
}

} // namespace

BoxBody::BoxBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team)
    : fixed_(scene.specimen.grid, prescribed) {
  const Grid& grid = scene.specimen.grid;
  const Matrix6 C = scene.object_stiffness(0);
  const Vec3& h = grid.spacing();
  unit = C.diagonal().maxCoeff() * h[0] * h[1] * h[2] / std::pow(*std::ranges::min_element(h), 2);
  multigrid = std::make_unique<BoxMultigrid>(std::make_unique<BoxLevel>(C, places(grid), unit, fixed_),
                                             relaxation_steps(stiffness_contrast(C)), team);
  fields = std::make_unique<BoxGradients>(*multigrid);
}

BoxBody& BoxSolver::body_of(const CoupledTask& task, std::unique_ptr<BoxBody>& own) {
  if (task.kept == nullptr) {
    own = std::make_unique<BoxBody>(task.scene, task.prescribed, task.team);
    return *own;
  }
  auto* const known = dynamic_cast<BoxBody*>(task.kept->hierarchy.get());
  if (known != nullptr && known->is_made_for({task.scene.specimen.grid, task.prescribed}))
    return *known;
  task.kept->hierarchy.reset(); // before there are two
  auto made = std::make_unique<BoxBody>(task.kept->scene(), task.prescribed, task.kept->team());
  BoxBody& body = *made;
  task.kept->hierarchy = std::move(made);
  return body;
}

BoxSolver::BoxSolver(const CoupledTask& task)
    : MixedSolver(task), body_(body_of(task, own_)), system_(task.scene, *body_.multigrid, body_.unit) {
  begin(body_.unit, body_.smallest_eigenvalue);
}

double BoxSolver::work_of_loads() {
  const float* const direction = body_.fields->direction();
  const BoxLevel& level = body_.multigrid->finest();
  const Index3& n = task_.scene.specimen.grid.nodes();
  return body_.multigrid->sum_over_planes([&](int z) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < n[1] && !loads_[c].empty(); ++y) {
        const float* const row = direction + level.offset(c, 0, y, z);
        const double* const load = loads_[c].data() + task_.scene.specimen.grid.node({0, y, z});
        for (int x = 0; x < n[0]; ++x)
          sum += load[x] * double{row[x]};
      }
    return sum / body_.unit;
  });
}

/// Takes the pending steps and adds the round's state to u.
void BoxSolver::finish_round(Displacement& u, CoupledRound) {
  BoxLevel& level = body_.multigrid->finest();
  const auto of_plane = body_.multigrid->sums();
  body_.multigrid->sum_over_planes([&](int z) {
    return finish_box(level.A(), z, body_.fields->steps(), body_.fields->direction(), level.r.data(),
                      body_.fields->state(), level.f.data(), scale(), !is_whole(), u.values().data());
  });
  work_of_residual_.clear();
  if (is_whole()) {
    // Otherwise float32 rounding shows in the energy: 3e-6 of it at nu 0.49 on 65^3 nodes.
    if (relaxation_steps(stiffness_contrast(task_.scene.object_stiffness(0))) <= steps_of_low_contrast)
      work_of_residual_.assign(of_plane.begin(), of_plane.end());
    for (double& work : work_of_residual_)
      work *= scale() * scale();
    for (const Prescribed& p : task_.prescribed)
      u(p.component, p.node) = p.value; // to the bit
  }
}

/// Full multigrid. @param u prescribed values, and 0 elsewhere; changed if float64 goes on with it
void BoxSolver::begin_on_coarser_grids(Displacement& u) {
  body_.fields->restart(); // a cached body may hold steps of its last answer
  BoxLevel& level = body_.multigrid->finest();
  const Grid& grid = task_.scene.specimen.grid;
  PaddedArray forces;
  if (has_loads_) {
    const double factor = 1 / (body_.unit * scale());
    forces = PaddedArray(level.field_size());
    load_field(
        level, body_.multigrid->team_for(level),
        [&](std::size_t c) { return loads_[c].empty() ? nullptr : loads_[c].data(); },
        Vec3{factor, factor, factor}, forces.data());
  }
  const float* const pulls = forces.size() > 0 ? forces.data() : nullptr;
  float* const state = body_.fields->state();
  for (const Prescribed& p : task_.prescribed) {
    const Index3 at = grid.node_at(p.node);
    state[level.offset(p.component, at[0], at[1], at[2])] = static_cast<float>(p.value / scale());
  }
  BoxStart start(*body_.multigrid);
  const bool is_to_be_whole = task_.scene.relaxation.tolerance >= float32_is_enough;
  const auto sums = body_.multigrid->sums();
  start.solve(state, pulls, [&](int z) {
    if (is_to_be_whole)
      sums[z] = begin_box(level.A(), z, pulls, state, level.f.data(), level.scratch());
    else
      finish_box(level.A(), z, {}, state, state, state, level.f.data(), scale(), false, u.values().data());
  });
  if (is_to_be_whole)
    begin_whole(body_.multigrid->total() * scale() * scale());
  else
    for (const Prescribed& p : task_.prescribed)
      u(p.component, p.node) = p.value; // to the bit
}

CoupledRound BoxSolver::solve(Displacement& u, Answer& answer) {
  if (u.empty())
    u = task_.initial_state();
  if (task_.start == nullptr && body_.multigrid->n_levels() > 1)
    begin_on_coarser_grids(u);
  return MixedSolver::solve(u, answer);
}

/// The right-hand side of the multigrid on one plane, in units of `scale`. @return the plane's part of u . K
/// u
double BoxSolver::residual_of_plane(const Displacement& u, int z, double scale, double& largest) {
  BoxLevel& level = body_.multigrid->finest();
  const BoxOperator& A = level.A();
  const double* force = body_.multigrid->forces_of_plane(u, z);
  const std::size_t first = body_.multigrid->in_plane() * static_cast<std::size_t>(z);
  double energy = 0;
  for (int c = 0; c < 3; ++c) {
    const auto b = static_cast<std::size_t>(c);
    const double* of_u = u.component(b).data() + first;
    const double* load = loads_[b].empty() ? nullptr : loads_[b].data() + first;
    for (int y = 0; y < A.nodes[1]; ++y) {
      float* const target = level.f.data() + level.offset(c, 0, y, z);
      const float* const inverse = A.inverse[c][y + std::int64_t{1} * A.nodes[1] * z];
      for (int x = 0; x < A.nodes[0]; ++x) {
        const double value = (load == nullptr ? 0 : load[x] / body_.unit) - force[x];
        energy += of_u[x] * force[x];
        target[x] = inverse[x] > 0 ? static_cast<float>(value / scale) : 0;
        largest = std::max(largest, std::abs(static_cast<double>(target[x])));
      }
      of_u += A.nodes[0], force += A.nodes[0];
      load = load == nullptr ? nullptr : load + A.nodes[0];
    }
  }
  return energy;
}

MixedSolver::Residual BoxSolver::begin_round(const Displacement& u, double scale) {
  std::vector<double> largest(body_.multigrid->sums().size(), 0);
  const double energy =
      body_.multigrid->sum_over_planes([&](int z) { return residual_of_plane(u, z, scale, largest[z]); });
  body_.fields->restart();
  return {*std::ranges::max_element(largest), energy};
}

/// u . K u of one plane in units of body_.unit: work of the loads on free components minus that of the
/// residual. @pre nothing is prescribed there
double BoxSolver::work_from_residual(const Displacement& u, int z) const {
  const std::size_t n = body_.multigrid->in_plane(), first = n * static_cast<std::size_t>(z);
  double sum = 0;
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = first; i < first + n && !loads_[b].empty(); ++i)
      sum += u(b, i) * loads_[b][i];
  return sum / body_.unit - work_of_residual_[z];
}

void BoxSolver::find_energy_and_reactions(const Displacement& u, Answer& answer) {
  const auto& prescribed = task_.scene.prescribed;
  std::vector<std::size_t> order(prescribed.size()); // by node, so that planes find theirs
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto node_of = [&](std::size_t i) { return static_cast<std::size_t>(prescribed[i].node); };
  std::ranges::sort(order, {}, node_of);
  answer.reaction.resize(prescribed.size());
  const double twice = body_.multigrid->sum_over_planes([&](int z) {
    const std::size_t n = body_.multigrid->in_plane(), first = n * static_cast<std::size_t>(z);
    auto at = std::ranges::lower_bound(order, first, {}, node_of);
    const auto is_here = [&] { return at != order.end() && node_of(*at) < first + n; };
    if (!work_of_residual_.empty() && !is_here())
      return work_from_residual(u, z);
    const double* const force = body_.multigrid->forces_of_plane(u, z);
    double sum = 0;
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < n; ++i)
        sum += u(b, first + i) * force[b * n + i];
    for (; is_here(); ++at) {
      const auto b = static_cast<std::size_t>(prescribed[*at].component);
      answer.reaction[*at] = body_.unit * force[b * n + node_of(*at) - first] -
                             (loads_[b].empty() ? 0 : loads_[b][node_of(*at)]);
    }
    return sum;
  });
  answer.strain_energy = 0.5 * body_.unit * twice;
}

bool is_uniform_box(const Scene& scene) {
  const Specimen& body = scene.specimen;
  if (scene.dimension() != 3 || !body.is_matter(0) || body.has_weights() || !scene.springs.empty())
    return false;
  const auto is_first = [&](std::uint8_t id) { return id == body.material_id.front(); };
  if (!std::ranges::all_of(body.material_id, is_first))
    return false;
  return scene.materials[body.material(0)].elasticity.is_isotropic() ||
         std::ranges::all_of(body.fibres, [&](const auto& fibre) { return fibre == body.fibres.front(); });
}

} // namespace maille::deform
