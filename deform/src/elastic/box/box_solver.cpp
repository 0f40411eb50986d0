#include "elastic/box/box_solver.hpp"

#include "elastic/box/box_start.hpp"
#include "elastic/box/box_system.hpp"
#include "elastic/krylov/flexible_gradients.hpp"
#include "elastic/links/link_ranges.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "maille/scene/nodal_forces.hpp"
#include "parallel/plane_pipeline.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <utility>

namespace maille::deform {

namespace {

/// Float32 carries the correction for so much of a reduction of r . z; then the residual is found anew.
constexpr double reduction_per_round = 1e-10;
/// Residuals of other sizes are counted in other units, for the range of float32.
constexpr double smallest_residual = 1e-8, largest_residual = 1e8;
/// Tolerances below this one ask for a state in float64.
constexpr double float32_is_enough = 5e-4;
/// Of the largest displacement: the start is within some hundredths of the answer, and links differ from node
/// to node.
constexpr double clearly = 0.02;

std::array<std::vector<double>, 3> places(const Grid& grid) {
  std::array<std::vector<double>, 3> place;
  for (std::size_t a = 0; a < 3; ++a)
    for (int i = 0; i < grid.nodes()[a]; ++i)
      place[a].push_back(i * grid.spacing()[a]);
  return place;
}

constexpr int steps_of_low_contrast = 2;

/// Nearer to incompressibility, and with stiffer fibres, volume changes and shears differ more in stiffness,
/// and relaxation has a wider range to damp. Measured for the shortest time to 1e-3.
int relaxation_steps(const Matrix6& C) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> modes(C, Eigen::EigenvaluesOnly);
  const double contrast = modes.eigenvalues()(5) / modes.eigenvalues()(0);
  return contrast < 8 ? steps_of_low_contrast : contrast < 30 ? 4 : 6;
}

} // namespace

BoxSolver::BoxSolver(const CoupledTask& task) : task_(task) {
  const Grid& grid = task.scene.specimen.grid;
  const Matrix6 C = task.scene.object_stiffness(0);
  const Vec3& h = grid.spacing();
  unit_ = C.diagonal().maxCoeff() * h[0] * h[1] * h[2] / std::pow(*std::ranges::min_element(h), 2);
  FixedComponents fixed(static_cast<std::size_t>(grid.n_nodes()), 0);
  for (const Prescribed& p : task.prescribed) {
    std::uint8_t& bits = fixed[static_cast<std::size_t>(p.node)];
    bits = static_cast<std::uint8_t>(bits | 1 << p.component);
  }
  for (std::size_t c = 0; c < 3; ++c)
    loads_[c] = nodal_forces(task.scene, static_cast<int>(c));
  multigrid_ = std::make_unique<BoxMultigrid>(
      std::make_unique<BoxLevel>(C, places(grid), unit_, std::move(fixed)), relaxation_steps(C), task.team);
  direction_ = PaddedArray(multigrid_->finest().field_size());
  state_ = PaddedArray(multigrid_->finest().field_size());
  choose_scale();
}

void BoxSolver::choose_scale() {
  scale_ = task_.scene.largest_prescribed();
  if (!(scale_ > 0)) // loads alone
    for (const auto& loads : loads_)
      for (const double load : loads)
        scale_ = std::max(scale_, std::abs(load) / unit_);
  if (!(scale_ > 0))
    scale_ = 1;
}

/// The residual of u in float64, and no change of u yet.
void BoxSolver::begin_round(const Displacement& u) {
  const double largest = find_residual(u);
  if (largest > 0 && (largest < smallest_residual || largest > largest_residual)) {
    scale_ *= largest;
    find_residual(u);
  }
  std::fill_n(state_.data(), multigrid_->finest().field_size(), 0.0F);
}

double BoxSolver::work_of_forces(const float* direction) {
  const BoxLevel& level = multigrid_->finest();
  const Index3& n = task_.scene.specimen.grid.nodes();
  return multigrid_->sum_over_planes([&](int z) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < n[1] && !loads_[static_cast<std::size_t>(c)].empty(); ++y) {
        const float* const row = direction + level.offset(c, 0, y, z);
        const double* const load =
            loads_[static_cast<std::size_t>(c)].data() + task_.scene.specimen.grid.node({0, y, z});
        for (int x = 0; x < n[0]; ++x)
          sum += load[x] * double{row[x]};
      }
    return sum / unit_;
  });
}

/// One round of conjugate gradients with a residual that is carried along. Steps are taken when their
/// direction and its image are read for the next one.
BoxSolver::Round BoxSolver::iterate(Answer& answer) {
  BoxLevel& level = multigrid_->finest();
  const BoxOperator& A = level.A();
  const bool has_loads = std::ranges::any_of(loads_, [](const auto& loads) { return !loads.empty(); });
  double first = 0, last = 0;
  steps_ = {};
  error_.restart();
  while (first == 0 || last > reduction_per_round * first) {
    if (answer.iterations >= most_coupled_iterations || task_.must_stop())
      return Round::stopped;
    if (task_.control.progress)
      task_.control.progress(std::min(0.99, static_cast<double>(answer.iterations) / 15), "solving");
    const double now = multigrid_->precondition(std::exchange(steps_.of_residual, 0.0F));
    float *const z_field = level.u.data(), *const q = level.r.data(), *const p = direction_.data();
    if (first == 0) {
      const double began = now * scale_ * scale_;
      first_began_ = std::max(first_began_, began);
      if (!(now > 0) || (round_began_ > 0 && began > 0.01 * round_began_))
        return is_left_by_rounding(began, std::max(energy_, first_began_)) ? Round::finished : Round::stalled;
      round_began_ = began;
      first = now;
    }
    if (!(now > 0))
      return Round::used_up;
    const auto beta = static_cast<float>(last > 0 ? now / last : 0);
    const float step_before = std::exchange(steps_.of_state, 0.0F);
    const auto sums = multigrid_->sums();
    run_stages(multigrid_->team_for(level), A.nodes[2], 2, [&](int stage, int z) {
      if (stage == 0)
        update_box_direction(A, z, z_field, beta, step_before, p, state_.data());
      else
        sums[static_cast<std::size_t>(z)] = apply_box_and_dot(A, z, p, q, multigrid_->scratch());
    });
    const double curvature = multigrid_->total();
    if (!(curvature > 0))
      return Round::used_up;
    const double step = now / curvature, gain = step * now * scale_ * scale_;
    // u . K u after a step, from p . K u = p . f - p . r
    energy_ += (has_loads ? 2 * step * scale_ * work_of_forces(p) : 0) - gain;
    steps_.of_state = steps_.of_residual = static_cast<float>(step);
    last = now;
    ++answer.iterations;
    error_.add(step, now, scale_);
    answer.residual = error_.relative_to(energy_);
    if (answer.residual <= task_.scene.relaxation.tolerance)
      return Round::finished;
  }
  next_scale_ = scale_ * std::sqrt(last / first);
  return Round::used_up;
}

/// Takes the steps that are left, and the round's state over into u.
void BoxSolver::finish_round(Displacement& u) {
  BoxLevel& level = multigrid_->finest();
  double* const components[3] = {u.component[0].data(), u.component[1].data(), u.component[2].data()};
  const auto of_plane = multigrid_->sums();
  multigrid_->sum_over_planes([&](int z) {
    return finish_box(level.A(), z, steps_, direction_.data(), level.r.data(), state_.data(), level.f.data(),
                      scale_, !is_whole_, components);
  });
  work_of_residual_.clear();
  if (is_whole_) {
    // Else float32 would show in the energy: measured at Poisson's ratio 0.49 on 65^3 nodes, 3e-6 of it.
    if (relaxation_steps(task_.scene.object_stiffness(0)) <= steps_of_low_contrast)
      work_of_residual_.assign(of_plane.begin(), of_plane.end());
    for (double& work : work_of_residual_)
      work *= scale_ * scale_;
    for (const Prescribed& p : task_.prescribed)
      u(p.component, p.node) = p.value; // to the bit
  }
}

BoxSolver::Round BoxSolver::correct(Displacement& u, Answer& answer) {
  if (!is_whole_)
    begin_round(u);
  next_scale_ = scale_;
  const Round end = iterate(answer);
  finish_round(u);
  if (is_whole_ && end == Round::used_up) {
    round_began_ = 0; // residuals of float64 are told from rounding where those of float32 are not
    is_whole_ = false;
  }
  scale_ = next_scale_;
  return end;
}

/// Full multigrid. @param u prescribed values, and 0 elsewhere; changed if float64 goes on with it
void BoxSolver::begin_on_coarser_grids(Displacement& u) {
  BoxLevel& level = multigrid_->finest();
  const Grid& grid = task_.scene.specimen.grid;
  const PaddedArray forces = forces_on(level, grid, loads_, unit_ * scale_);
  const float* const pulls = forces.size() > 0 ? forces.data() : nullptr;
  float* const state = state_.data();
  for (const Prescribed& p : task_.prescribed) {
    const Index3 at = grid.node_at(p.node);
    state[level.offset(p.component, at[0], at[1], at[2])] = static_cast<float>(p.value / scale_);
  }
  BoxStart start(*multigrid_);
  is_whole_ = task_.scene.relaxation.tolerance >= float32_is_enough;
  double* const components[3] = {u.component[0].data(), u.component[1].data(), u.component[2].data()};
  const auto sums = multigrid_->sums();
  start.solve(state, pulls, [&](int z) {
    if (is_whole_)
      sums[static_cast<std::size_t>(z)] =
          begin_box(level.A(), z, pulls, state, level.f.data(), multigrid_->scratch());
    else
      finish_box(level.A(), z, {}, state, state, state, level.f.data(), scale_, false, components);
  });
  if (is_whole_)
    energy_ = multigrid_->total() * scale_ * scale_;
  else
    for (const Prescribed& p : task_.prescribed)
      u(p.component, p.node) = p.value; // to the bit
  bytes_of_start_ = start.bytes() + static_cast<std::int64_t>(forces.bytes());
}

/// Where the start breaks limits so clearly that the elastic answer does, too: the search for the least
/// energy within them begins on coarser bodies and has no use for it. Only a time budget has, that may end
/// the search.
bool BoxSolver::is_start_enough(Displacement& u) {
  if (task_.limits == nullptr || task_.control.seconds_budget || task_.must_stop())
    return false;
  finish_round(u);
  return breaks_limits(task_.scene, *task_.limits, task_.team, u, clearly);
}

CoupledRound BoxSolver::solve(Displacement& u, Answer& answer) {
  if (task_.start == nullptr && multigrid_->n_levels() > 1)
    begin_on_coarser_grids(u);
  answer.residual = 1;
  is_start_only_ = is_whole_ && is_start_enough(u);
  if (is_start_only_)
    return Round::finished;
  Round round = Round::used_up;
  while (round == Round::used_up)
    round = correct(u, answer);
  if (round == Round::finished && error_.is_empty())
    answer.residual = 0;
  return round;
}

std::int64_t BoxSolver::bytes() const {
  std::size_t sum =
      direction_.bytes() + state_.bytes() + work_of_residual_.size() * sizeof(double) +
      static_cast<std::size_t>(task_.team.threads()) * 3 * multigrid_->in_plane() * sizeof(double);
  for (const auto& loads : loads_)
    sum += loads.size() * sizeof(double);
  sum += task_.scene.prescribed.size() * sizeof(std::size_t);
  return multigrid_->bytes() + bytes_of_start_ + static_cast<std::int64_t>(sum);
}

bool is_uniform_box(const Scene& scene) {
  const Specimen& body = scene.specimen;
  if (scene.dimension() != 3 || !body.is_matter(0))
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
  std::vector<std::vector<double>> forces;
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
  answer.bytes = solver.bytes() + bytes_of(answer.displacement);
  if (gradients.finish(box, system, answer))
    return true;
  if (answer.status != Status::failed)
    return false;
  // Of cells that are very oblong float32 may leave the multigrid not positive: the separable one is, at more
  // iterations.
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
  if (task.start != nullptr)
    answer.displacement = *task.start;
  else
    answer.displacement = Displacement(task.scene.specimen.grid);
  for (const Prescribed& p : task.prescribed)
    answer.displacement(p.component, p.node) = p.value;
  BoxSolver solver(task);
  answer.seconds.setup = task.clock.seconds();
  if (needs_float64(task.scene))
    return refine_in_float64(task, solver, answer);
  const CoupledRound end = solver.solve(answer.displacement, answer);
  if (end == CoupledRound::stalled)
    return refine_in_float64(task, solver, answer);
  const bool is_converged = end == CoupledRound::finished;
  if (!solver.is_start_only()) // else they are those of the least energy within the limits
    solver.find_energy_and_reactions(answer.displacement, answer);
  if (!is_converged)
    answer.reaction.clear();
  answer.bytes = solver.bytes() + bytes_of(answer.displacement);
  BoxSystem system(solver.multigrid(), solver.unit());
  return task.end(system, is_converged, answer.displacement, answer);
}

} // namespace maille::deform
