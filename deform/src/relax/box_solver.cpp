#include "relax/box_solver.hpp"

#include "maille/scene/nodal_forces.hpp"
#include "parallel/plane_pipeline.hpp"
#include "relax/box_start.hpp"
#include "relax/box_system.hpp"
#include "relax/coupled_limits.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace maille::deform {

namespace {

/// Float32 carries the correction for so much of a reduction of r . z; then the residual is found anew.
constexpr double reduction_per_round = 1e-10;
/// Residuals of other sizes are counted in other units, for the range of float32.
constexpr double smallest_residual = 1e-8, largest_residual = 1e8;

double* plane_buffer(std::size_t size) {
  thread_local AlignedArray<double> buffer;
  if (buffer.size() < size)
    buffer = AlignedArray<double>(size);
  return buffer.data();
}

std::array<std::vector<double>, 3> places(const Grid& grid) {
  std::array<std::vector<double>, 3> place;
  for (std::size_t a = 0; a < 3; ++a)
    for (int i = 0; i < grid.nodes()[a]; ++i)
      place[a].push_back(i * grid.spacing()[a]);
  return place;
}

/// Nearer to incompressibility, and with stiffer fibres, volume changes and shears differ more in stiffness, and relaxation has a
/// wider range to damp. Measured for the shortest time to 1e-3.
int relaxation_steps(const Matrix6& C) {
  const Eigen::SelfAdjointEigenSolver<Matrix6> modes(C, Eigen::EigenvaluesOnly);
  const double contrast = modes.eigenvalues()(5) / modes.eigenvalues()(0);
  return contrast < 8 ? 2 : contrast < 30 ? 4 : 6;
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
  scale_ = task.scene.largest_prescribed();
}

std::size_t BoxSolver::in_plane() const {
  const Index3& nodes = task_.scene.specimen.grid.nodes();
  return static_cast<std::size_t>(nodes[0]) * static_cast<std::size_t>(nodes[1]);
}

/// K u on plane z in units of unit_, [component][node], until the thread's next plane.
double* BoxSolver::forces_of_plane(const Displacement& u, int z) {
  double* const forces = plane_buffer(3 * in_plane());
  const double* const components[3] = {u.component[0].data(), u.component[1].data(), u.component[2].data()};
  apply_box(multigrid_->finest().A(), z, components, forces, multigrid_->scratch());
  return forces;
}

/// The right-hand side of the multigrid on one plane, in units of scale_. @return the plane's part of u . K u
double BoxSolver::residual_of_plane(const Displacement& u, int z, double& largest) {
  BoxLevel& level = multigrid_->finest();
  const BoxOperator& A = level.A();
  const double* force = forces_of_plane(u, z);
  const std::size_t first = in_plane() * static_cast<std::size_t>(z);
  double energy = 0;
  for (int c = 0; c < 3; ++c) {
    const auto b = static_cast<std::size_t>(c);
    const double* of_u = u.component[b].data() + first;
    const double* load = loads_[b].empty() ? nullptr : loads_[b].data() + first;
    for (int y = 0; y < A.nodes[1]; ++y) {
      float* const target = level.f.data() + level.offset(c, 0, y, z);
      const float* const inverse = A.inverse[c][y + std::int64_t{1} * A.nodes[1] * z];
      for (int x = 0; x < A.nodes[0]; ++x) {
        const double value = (load == nullptr ? 0 : load[x] / unit_) - force[x];
        energy += of_u[x] * force[x];
        target[x] = inverse[x] > 0 ? static_cast<float>(value / scale_) : 0;
        largest = std::max(largest, std::abs(static_cast<double>(target[x])));
      }
      of_u += A.nodes[0], force += A.nodes[0];
      load = load == nullptr ? nullptr : load + A.nodes[0];
    }
  }
  return energy;
}

/// Sets energy_ too. @return the largest residual in units of scale_
double BoxSolver::find_residual(const Displacement& u) {
  std::vector<double> largest(multigrid_->sums().size(), 0);
  energy_ = multigrid_->sum_over_planes(
      [&](int z) { return residual_of_plane(u, z, largest[static_cast<std::size_t>(z)]); });
  return *std::ranges::max_element(largest);
}

void BoxSolver::begin_round(const Displacement& u) {
  if (!(scale_ > 0)) // loads alone
    for (const auto& loads : loads_)
      for (const double load : loads)
        scale_ = std::max(scale_, std::abs(load) / unit_);
  if (!(scale_ > 0))
    scale_ = 1;
  const double largest = find_residual(u);
  if (largest > 0 && (largest < smallest_residual || largest > largest_residual)) {
    scale_ *= largest;
    find_residual(u);
  }
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

/// One round of conjugate gradients with a residual that is carried along.
BoxSolver::Round BoxSolver::correct(Displacement& u, Answer& answer) {
  begin_round(u);
  BoxLevel& level = multigrid_->finest();
  const BoxOperator& A = level.A();
  ThreadTeam& team = multigrid_->team_for(level);
  const bool has_loads = std::ranges::any_of(loads_, [](const auto& loads) { return !loads.empty(); });
  double* const components[3] = {u.component[0].data(), u.component[1].data(), u.component[2].data()};
  double first = 0, last = 0;
  while (first == 0 || last > reduction_per_round * first) {
    if (answer.iterations >= most_coupled_iterations || task_.must_stop())
      return Round::stopped;
    if (task_.control.progress)
      task_.control.progress(std::min(0.99, static_cast<double>(answer.iterations) / 15), "solving");
    const double now = multigrid_->precondition();
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
    const auto sums = multigrid_->sums();
    run_stages(team, A.nodes[2], 2, [&](int stage, int z) {
      if (stage == 0)
        update_box_direction(A, z, z_field, beta, p);
      else
        sums[static_cast<std::size_t>(z)] = apply_box_and_dot(A, z, p, q, multigrid_->scratch());
    });
    const double curvature = multigrid_->total();
    if (!(curvature > 0))
      return Round::used_up;
    const double step = now / curvature, gain = step * now * scale_ * scale_;
    // u . K u after a step, from p . K u = p . f - p . r
    energy_ += (has_loads ? 2 * step * scale_ * work_of_forces(p) : 0) - gain;
    team.run(A.nodes[2],
             [&](int z, int) { take_box_step(A, z, step, scale_, p, q, components, level.f.data()); });
    last = now;
    ++answer.iterations;
    error_.add(gain);
    answer.residual = error_.extrapolated_relative_to(energy_);
    if (answer.residual <= task_.scene.relaxation.tolerance)
      return Round::finished;
  }
  scale_ *= std::sqrt(last / first);
  return Round::used_up;
}

/// Full multigrid. @param u prescribed values, and 0 elsewhere
void BoxSolver::begin_on_coarser_grids(Displacement& u) {
  const BoxLevel& level = multigrid_->finest();
  const Grid& grid = task_.scene.specimen.grid;
  const double scale = scale_ > 0 ? scale_ : 1;
  const PaddedArray forces = forces_on(level, grid, loads_, unit_ * scale);
  float* const state = direction_.data(); // 0 so far
  for (const Prescribed& p : task_.prescribed) {
    const Index3 at = grid.node_at(p.node);
    state[level.offset(p.component, at[0], at[1], at[2])] = static_cast<float>(p.value / scale);
  }
  BoxStart start(*multigrid_);
  start.solve(state, forces.size() > 0 ? forces.data() : nullptr, [&](int z) {
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < grid.nodes()[1]; ++y) {
        double* const to = u.component[static_cast<std::size_t>(c)].data() + grid.node({0, y, z});
        const float* const from = state + level.offset(c, 0, y, z);
        for (int x = 0; x < grid.nodes()[0]; ++x)
          to[x] = scale * double{from[x]};
      }
  });
  for (const Prescribed& p : task_.prescribed)
    u(p.component, p.node) = p.value; // to the bit
  bytes_of_start_ = start.bytes() + static_cast<std::int64_t>(forces.bytes());
}

void BoxSolver::precondition(const Displacement& residual, Displacement& correction) {
  BoxLevel& level = multigrid_->finest();
  const Index3& n = task_.scene.specimen.grid.nodes();
  const double size = largest_entry(residual);
  const auto for_each_row = [&](auto&& visit) {
    multigrid_->team_for(level).run(n[2], [&](int z, int) {
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < n[1]; ++y)
          visit(static_cast<std::size_t>(c),
                static_cast<std::size_t>(task_.scene.specimen.grid.node({0, y, z})), level.offset(c, 0, y, z),
                level.A().inverse[c][y + std::int64_t{1} * n[1] * z]);
    });
  };
  for_each_row([&](std::size_t c, std::size_t node, std::int64_t at, const float* inverse) {
    for (int x = 0; x < n[0]; ++x) {
      const double value = residual.component[c][node + static_cast<std::size_t>(x)];
      level.f.data()[at + x] = inverse[x] > 0 && size > 0 ? static_cast<float>(value / size) : 0;
    }
  });
  multigrid_->precondition();
  for_each_row([&](std::size_t c, std::size_t node, std::int64_t at, const float* inverse) {
    for (int x = 0; x < n[0]; ++x)
      correction.component[c][node + static_cast<std::size_t>(x)] =
          inverse[x] > 0 ? size / unit_ * double{level.u.data()[at + x]} : 0;
  });
}

CoupledRound BoxSolver::solve(Displacement& u, Answer& answer) {
  if (task_.start == nullptr && multigrid_->n_levels() > 1)
    begin_on_coarser_grids(u);
  answer.residual = 1;
  Round round = Round::used_up;
  while (round == Round::used_up)
    round = correct(u, answer);
  if (round == Round::finished && error_.is_empty())
    answer.residual = 0;
  return round;
}

void BoxSolver::find_energy_and_reactions(const Displacement& u, Answer& answer) {
  const auto& prescribed = task_.scene.prescribed;
  std::vector<std::size_t> order(prescribed.size()); // by node, so that planes find theirs
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto node_of = [&](std::size_t i) { return static_cast<std::size_t>(prescribed[i].node); };
  std::ranges::sort(order, {}, node_of);
  answer.reaction.resize(prescribed.size());
  const double twice = multigrid_->sum_over_planes([&](int z) {
    const double* const force = forces_of_plane(u, z);
    const std::size_t n = in_plane(), first = n * static_cast<std::size_t>(z);
    double sum = 0;
    for (std::size_t b = 0; b < 3; ++b)
      for (std::size_t i = 0; i < n; ++i)
        sum += u.component[b][first + i] * force[b * n + i];
    for (auto at = std::ranges::lower_bound(order, first, {}, node_of);
         at != order.end() && node_of(*at) < first + n; ++at) {
      const auto b = static_cast<std::size_t>(prescribed[*at].component);
      answer.reaction[*at] =
          unit_ * force[b * n + node_of(*at) - first] - (loads_[b].empty() ? 0 : loads_[b][node_of(*at)]);
    }
    return sum;
  });
  answer.strain_energy = 0.5 * unit_ * twice;
}

std::int64_t BoxSolver::bytes() const {
  std::size_t sum =
      direction_.bytes() + static_cast<std::size_t>(task_.team.threads()) * 3 * in_plane() * sizeof(double);
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

bool solve_coupled_box(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around lattice multigrid";
  answer.displacement = task.start != nullptr ? *task.start : Displacement(task.scene.specimen.grid);
  for (const Prescribed& p : task.prescribed)
    answer.displacement(p.component, p.node) = p.value;
  BoxSolver solver(task);
  answer.seconds.setup = task.clock.seconds();
  const CoupledRound end = solver.solve(answer.displacement, answer);
  if (end == CoupledRound::stalled)
    return solve_coupled_body(task, answer);
  const bool came_to_the_end = end == CoupledRound::finished;
  solver.find_energy_and_reactions(answer.displacement, answer);
  if (!came_to_the_end)
    answer.reaction.clear();
  answer.bytes = solver.bytes() + bytes_of(answer.displacement);
  BoxSystem system(solver.multigrid(), solver.unit());
  return obey_limits(task, system, came_to_the_end, answer.displacement, answer);
}

} // namespace maille::deform
