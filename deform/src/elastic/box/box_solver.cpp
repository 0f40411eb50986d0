#include "elastic/box/box_solver.hpp"

#include "elastic/box/box_multigrid.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/links/interval_field.hpp"
#include "elastic/model/lattice_elasticity.hpp"
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
/// A link that exceeds its limit by this share of the largest displacement breaks it clearly. The start is
/// within a few per cent of the answer, and links differ from node to node.
constexpr double clearly = 0.02;

std::array<std::vector<double>, 3> places(const Grid& grid) {
  std::array<std::vector<double>, 3> place;
  for (std::size_t a = 0; a < 3; ++a)
    for (int i = 0; i < grid.nodes()[a]; ++i)
      place[a].push_back(i * grid.spacing()[a]);
  return place;
}

} // namespace

BoxBody::BoxBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team)
    : fixed_(fixed_components(prescribed)) {
  const Grid& grid = scene.specimen.grid;
  const Matrix6 C = scene.object_stiffness(0);
  const Vec3& h = grid.spacing();
  unit = C.diagonal().maxCoeff() * h[0] * h[1] * h[2] / std::pow(*std::ranges::min_element(h), 2);
  FixedComponents fixed(static_cast<std::size_t>(grid.n_nodes()), 0);
  for (const Prescribed& p : prescribed) {
    std::uint8_t& bits = fixed[static_cast<std::size_t>(p.node)];
    bits = static_cast<std::uint8_t>(bits | 1 << p.component);
  }
  multigrid =
      std::make_unique<BoxMultigrid>(std::make_unique<BoxLevel>(C, places(grid), unit, std::move(fixed)),
                                     relaxation_steps(stiffness_contrast(C)), team);
  fields = std::make_unique<BoxGradients>(*multigrid);
}

bool BoxBody::take_fixed(const std::vector<Prescribed>& prescribed) {
  if (fixed_components(prescribed) != fixed_)
    return false;
  multigrid->set_penalties({});
  return true;
}

BoxBody& BoxSolver::body_of(const CoupledTask& task, std::unique_ptr<BoxBody>& own) {
  if (task.kept == nullptr) {
    own = std::make_unique<BoxBody>(task.scene, task.prescribed, task.team);
    return *own;
  }
  auto* const known = dynamic_cast<BoxBody*>(task.kept->hierarchy.get());
  if (known != nullptr && known->take_fixed(task.prescribed))
    return *known;
  task.kept->hierarchy.reset(); // before there are two
  auto made = std::make_unique<BoxBody>(task.kept->scene(), task.prescribed, task.kept->team());
  BoxBody& body = *made;
  task.kept->hierarchy = std::move(made);
  return body;
}

BoxSolver::BoxSolver(const CoupledTask& task) : task_(task), body_(body_of(task, own_)) {
  for (std::size_t c = 0; c < 3; ++c)
    loads_[c] = nodal_forces(task.scene, static_cast<int>(c));
  constexpr int expected_iterations = 15;
  gradients_ = std::make_unique<MixedGradients>(task, loads_, body_.unit, expected_iterations);
  if (body_.smallest_eigenvalue > 0 && task.start != nullptr && !task.kept->begins_anew)
    gradients_->begin_with(body_.smallest_eigenvalue);
}

double BoxSolver::work_of_loads() {
  const float* const direction = body_.fields->direction();
  const BoxLevel& level = body_.multigrid->finest();
  const Index3& n = task_.scene.specimen.grid.nodes();
  return body_.multigrid->sum_over_planes([&](int z) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < n[1] && !loads_[static_cast<std::size_t>(c)].empty(); ++y) {
        const float* const row = direction + level.offset(c, 0, y, z);
        const double* const load =
            loads_[static_cast<std::size_t>(c)].data() + task_.scene.specimen.grid.node({0, y, z});
        for (int x = 0; x < n[0]; ++x)
          sum += load[x] * double{row[x]};
      }
    return sum / body_.unit;
  });
}

/// Takes the steps that are left, and the round's state over into u.
void BoxSolver::finish_round(Displacement& u, bool) {
  BoxLevel& level = body_.multigrid->finest();
  const bool is_whole = gradients_->is_whole();
  const double scale = gradients_->scale();
  const auto of_plane = body_.multigrid->sums();
  body_.multigrid->sum_over_planes([&](int z) {
    return finish_box(level.A(), z, body_.fields->steps(), body_.fields->direction(), level.r.data(),
                      body_.fields->state(), level.f.data(), scale, !is_whole, u.values().data());
  });
  work_of_residual_.clear();
  if (is_whole) {
    // Else float32 would show in the energy: measured at Poisson's ratio 0.49 on 65^3 nodes, 3e-6 of it.
    if (relaxation_steps(stiffness_contrast(task_.scene.object_stiffness(0))) <= steps_of_low_contrast)
      work_of_residual_.assign(of_plane.begin(), of_plane.end());
    for (double& work : work_of_residual_)
      work *= scale * scale;
    for (const Prescribed& p : task_.prescribed)
      u(p.component, p.node) = p.value; // to the bit
  }
}

/// Full multigrid. @param u prescribed values, and 0 elsewhere; changed if float64 goes on with it
void BoxSolver::begin_on_coarser_grids(Displacement& u) {
  BoxLevel& level = body_.multigrid->finest();
  const Grid& grid = task_.scene.specimen.grid;
  const double scale = gradients_->scale();
  const PaddedArray forces = forces_on(level, grid, loads_, body_.unit * scale);
  const float* const pulls = forces.size() > 0 ? forces.data() : nullptr;
  float* const state = body_.fields->state();
  for (const Prescribed& p : task_.prescribed) {
    const Index3 at = grid.node_at(p.node);
    state[level.offset(p.component, at[0], at[1], at[2])] = static_cast<float>(p.value / scale);
  }
  BoxStart start(*body_.multigrid);
  const bool is_whole = task_.scene.relaxation.tolerance >= float32_is_enough;
  const auto sums = body_.multigrid->sums();
  start.solve(state, pulls, [&](int z) {
    if (is_whole)
      sums[static_cast<std::size_t>(z)] =
          begin_box(level.A(), z, pulls, state, level.f.data(), level.scratch());
    else
      finish_box(level.A(), z, {}, state, state, state, level.f.data(), scale, false, u.values().data());
  });
  if (is_whole)
    gradients_->begin_whole(body_.multigrid->total() * scale * scale);
  else
    for (const Prescribed& p : task_.prescribed)
      u(p.component, p.node) = p.value; // to the bit
}

/// Where the start breaks limits so clearly that the elastic answer does, too: the search for the least
/// energy within them begins on coarser bodies and has no use for it. Only a time budget has, that may end
/// the search.
bool BoxSolver::is_start_enough(Displacement& u) {
  if (task_.limits == nullptr || task_.control.seconds_budget || task_.must_stop())
    return false;
  finish_round(u, true);
  return breaks_limits(task_.scene, *task_.limits, task_.team, u, clearly);
}

CoupledRound BoxSolver::solve(Displacement& u, Answer& answer) {
  if (task_.start == nullptr && body_.multigrid->n_levels() > 1)
    begin_on_coarser_grids(u);
  answer.residual = 1;
  is_start_only_ = gradients_->is_whole() && is_start_enough(u);
  if (is_start_only_)
    return CoupledRound::finished;
  const std::int64_t before = answer.iterations;
  const CoupledRound end = gradients_->solve(*body_.fields, *this, u, answer);
  constexpr std::int64_t enough_to_know = 3;
  if (end == CoupledRound::finished &&
      (body_.smallest_eigenvalue > 0 || answer.iterations >= before + enough_to_know))
    body_.smallest_eigenvalue = gradients_->smallest_eigenvalue();
  return end;
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

MixedState::Residual BoxSolver::begin_round(const Displacement& u, double scale) {
  std::vector<double> largest(body_.multigrid->sums().size(), 0);
  const double energy = body_.multigrid->sum_over_planes(
      [&](int z) { return residual_of_plane(u, z, scale, largest[static_cast<std::size_t>(z)]); });
  body_.fields->restart();
  return {*std::ranges::max_element(largest), energy};
}

void BoxSolver::precondition(const Displacement& residual, Displacement& correction) {
  BoxLevel& level = body_.multigrid->finest();
  const Index3& n = task_.scene.specimen.grid.nodes();
  const double size = largest_entry(residual);
  const auto for_each_row = [&](auto&& visit) {
    body_.multigrid->team_for(level).run(n[2], [&](int z, int) {
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < n[1]; ++y)
          visit(static_cast<std::size_t>(c),
                static_cast<std::size_t>(task_.scene.specimen.grid.node({0, y, z})), level.offset(c, 0, y, z),
                level.A().inverse[c][y + std::int64_t{1} * n[1] * z]);
    });
  };
  for_each_row([&](std::size_t c, std::size_t node, std::int64_t at, const float* inverse) {
    for (int x = 0; x < n[0]; ++x) {
      const double value = residual(c, node + static_cast<std::size_t>(x));
      level.f.data()[at + x] = inverse[x] > 0 && size > 0 ? static_cast<float>(value / size) : 0;
    }
  });
  body_.multigrid->precondition();
  for_each_row([&](std::size_t c, std::size_t node, std::int64_t at, const float* inverse) {
    for (int x = 0; x < n[0]; ++x)
      correction(c, node + static_cast<std::size_t>(x)) =
          inverse[x] > 0 ? size / body_.unit * double{level.u.data()[at + x]} : 0;
  });
}

/// u . K u of one plane in units of body_.unit: of free components, what pulls less the residual. @pre
/// nothing is prescribed there
double BoxSolver::work_from_residual(const Displacement& u, int z) const {
  const std::size_t n = body_.multigrid->in_plane(), first = n * static_cast<std::size_t>(z);
  double sum = 0;
  for (std::size_t b = 0; b < 3; ++b)
    for (std::size_t i = first; i < first + n && !loads_[b].empty(); ++i)
      sum += u(b, i) * loads_[b][i];
  return sum / body_.unit - work_of_residual_[static_cast<std::size_t>(z)];
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

namespace {

/// The operator in float64 around the multigrid in float32. It is applied cell by cell, from differences:
/// where a body is a thousand times as long as it is thick, the rounding of sums over nodes would be as much
/// as bending.
class BoxInFloat64 : public FlexibleOperator {
public:
  BoxInFloat64(const CoupledTask& task, BoxSolver& solver)
      : elasticity_(task.scene), solver_(solver), team_(task.team) {}
  void apply(const Displacement& u, Displacement& forces) override { elasticity_.apply(u, forces, team_); }
  void precondition(const Displacement& residual, Displacement& correction) override {
    solver_.precondition(residual, correction);
  }
  Displacement diagonal() const override { return elasticity_.diagonal(); }

private:
  LatticeElasticity elasticity_;
  BoxSolver& solver_;
  ThreadTeam& team_;
};

bool refine_in_float64(const CoupledTask& task, BoxSolver& solver, Answer& answer) {
  const Scene& scene = task.scene;
  std::vector<List<double>> forces;
  for (int c = 0; c < 3; ++c)
    forces.push_back(nodal_forces(scene, c));
  std::vector<std::vector<bool>> is_fixed(
      3, std::vector<bool>(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), false));
  for (const Prescribed& p : task.prescribed)
    is_fixed[static_cast<std::size_t>(p.component)][static_cast<std::size_t>(p.node)] = true;
  BoxSystem system(solver.multigrid(), solver.unit());
  BoxInFloat64 box(task, solver);
  FlexibleGradients gradients(task, std::move(forces), std::move(is_fixed));
  answer.algorithm += ", in float64";
  if (gradients.finish(box, system, answer))
    return true;
  if (answer.status != Status::failed)
    return false;
  // On very oblong cells float32 can make the multigrid indefinite; the componentwise one stays positive, at
  // the price of more iterations.
  answer.status = Status::done;
  answer.message.clear();
  return solve_coupled_body(task, answer);
}

} // namespace

bool needs_float64(const Scene& scene) {
  constexpr double slender = 3, rounding = 4e-8;
  const Grid& grid = scene.specimen.grid;
  double longest = 0, thinnest = INFINITY, cell = INFINITY;
  for (std::size_t a = 0; a < 3; ++a) {
    const double h = grid.spacing()[a], length = h * grid.cells()[a];
    longest = std::max(longest, length);
    thinnest = std::min(thinnest, length);
    cell = std::min(cell, h);
  }
  const Matrix6 C = scene.object_stiffness(0);
  const double softest = 1 / C.inverse().diagonal().head<3>().maxCoeff();
  const double smallest =
      softest / C.diagonal().maxCoeff() * std::pow(cell * thinnest / (longest * longest), 2);
  return longest > slender * thinnest && smallest * scene.relaxation.tolerance < rounding;
}

bool solve_coupled_box(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around lattice multigrid";
  answer.displacement = task.initial_state();
  BoxSolver solver(task);
  answer.seconds.setup = task.clock.seconds();
  if (needs_float64(task.scene))
    return refine_in_float64(task, solver, answer);
  bool is_converged = true;
  if (!begins_within_limits(task)) {
    const CoupledRound end = solver.solve(answer.displacement, answer);
    if (end == CoupledRound::stalled)
      return refine_in_float64(task, solver, answer);
    is_converged = end == CoupledRound::finished;
    if (!solver.is_start_only()) // else they are those of the least energy within the limits
      solver.find_energy_and_reactions(answer.displacement, answer);
    if (!is_converged)
      answer.reaction.clear();
  }
  BoxSystem system(solver.multigrid(), solver.unit());
  return task.end(system, is_converged, answer.displacement, answer);
}

} // namespace maille::deform
