#include "elastic/masked/matter_solver.hpp"

#include "elastic/masked/matter_system.hpp"
#include "maille/scene/nodal_forces.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Float32 carries the correction for so much of a reduction of r . z; then the residual is found anew.
constexpr double reduction_per_round = 1e-10;
/// Residuals of other sizes are counted in other units, for the range of float32.
constexpr double smallest_residual = 1e-8, largest_residual = 1e8;

/// As on boxes: nearer to incompressibility, and with stiffer fibres, relaxation has a wider range to damp.
int relaxation_steps(const Scene& scene) {
  double contrast = 1;
  for (const Material& material : scene.materials) {
    const Eigen::SelfAdjointEigenSolver<Matrix6> modes(stiffness(material.elasticity),
                                                       Eigen::EigenvaluesOnly);
    contrast = std::max(contrast, modes.eigenvalues()(5) / modes.eigenvalues()(0));
  }
  return contrast < 8 ? 2 : contrast < 30 ? 4 : 6;
}

} // namespace

MatterSolver::MatterSolver(const CoupledTask& task)
    : task_(task), elasticity_(task.scene), forces_(task.scene.specimen.grid) {
  for (std::size_t c = 0; c < 3; ++c)
    loads_[c] = nodal_forces(task.scene, static_cast<int>(c));
  multigrid_ = std::make_unique<MatterMultigrid>(
      std::make_unique<MatterLevel>(task.scene, elasticity_, task.prescribed), relaxation_steps(task.scene),
      task.team);
  direction_ = multigrid_->finest().field();
  scale_ = task.scene.largest_prescribed();
}

/// Calls visit(row of nodes, its first node, how many in the grid).
template<class Visit>
void MatterSolver::for_each_row(const Visit& visit) {
  const Grid& grid = task_.scene.specimen.grid;
  constexpr std::size_t rows_per_item = 64;
  const auto rows = multigrid_->finest().rows().node_rows();
  task_.team.run(static_cast<int>((rows.size() + rows_per_item - 1) / rows_per_item), [&](int item, int) {
    const std::size_t first = static_cast<std::size_t>(item) * rows_per_item;
    for (const NodeRow& row : rows.subspan(first, std::min(rows_per_item, rows.size() - first)))
      visit(row, grid.node(row.first),
            std::min(row.blocks * MatterRows::block, grid.nodes()[0] - row.first[0]));
  });
}

/// Sets energy_ too. @return the largest residual in units of scale_
double MatterSolver::find_residual(const Displacement& u) {
  MatterLevel& level = multigrid_->finest();
  elasticity_.apply(u, forces_, task_.team);
  for_each_row([&](const NodeRow& row, std::int64_t node, int n) {
    for (std::size_t c = 0; c < 3; ++c) {
      const std::int64_t at = static_cast<std::int64_t>(c) * level.component_stride() + row.slot;
      const double unit = level.unit() * level.scale()[c] * scale_;
      for (int i = 0; i < n; ++i) {
        const auto k = static_cast<std::size_t>(node + i);
        const double value = (loads_[c].empty() ? 0 : loads_[c][k]) - forces_.component[c][k];
        multigrid_->f.data()[at + i] = level.inverse()[at + i] > 0 ? static_cast<float>(value / unit) : 0;
      }
    }
  });
  energy_ = 0;
  double largest = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < u.component[c].size(); ++i)
      energy_ += u.component[c][i] * forces_.component[c][i] / level.unit();
  for (const float value : multigrid_->f.all())
    largest = std::max(largest, std::abs(double{value}));
  return largest;
}

void MatterSolver::begin_round(const Displacement& u) {
  if (!(scale_ > 0)) // loads alone
    for (const auto& loads : loads_)
      for (const double load : loads)
        scale_ = std::max(scale_, std::abs(load) / multigrid_->finest().unit());
  if (!(scale_ > 0))
    scale_ = 1;
  const double largest = find_residual(u);
  if (largest > 0 && (largest < smallest_residual || largest > largest_residual)) {
    scale_ *= largest;
    find_residual(u);
  }
}

double MatterSolver::work_of_forces(const float* direction) {
  const MatterLevel& level = multigrid_->finest();
  const Grid& grid = task_.scene.specimen.grid;
  double sum = 0;
  for (const NodeRow& row : level.rows().node_rows()) {
    const std::int64_t node = grid.node(row.first);
    const int n = std::min(row.blocks * MatterRows::block, grid.nodes()[0] - row.first[0]);
    for (std::size_t c = 0; c < 3; ++c)
      for (int i = 0; i < n && !loads_[c].empty(); ++i)
        sum += loads_[c][static_cast<std::size_t>(node + i)] / (level.unit() * level.scale()[c]) *
               double{direction[static_cast<std::int64_t>(c) * level.component_stride() + row.slot + i]};
  }
  return sum;
}

void MatterSolver::take_step(double step, Displacement& u) {
  const MatterLevel& level = multigrid_->finest();
  level.for_each_part(task_.team, [&](std::int64_t first, std::int64_t n, int) {
    step_entries(n, static_cast<float>(step), multigrid_->r.data() + first, multigrid_->f.data() + first);
  });
  for_each_row([&](const NodeRow& row, std::int64_t node, int n) {
    for (std::size_t c = 0; c < 3; ++c) {
      const double factor = step * scale_ / level.scale()[c];
      const float* const p =
          direction_.data() + static_cast<std::int64_t>(c) * level.component_stride() + row.slot;
      double* const of_u = u.component[c].data() + node;
      for (int i = 0; i < n; ++i)
        of_u[i] += factor * double{p[i]};
    }
  });
}

/// One round of conjugate gradients with a residual that is carried along.
MatterSolver::Round MatterSolver::correct(Displacement& u, Answer& answer) {
  begin_round(u);
  MatterMultigrid& multigrid = *multigrid_;
  const MatterLevel& level = multigrid.finest();
  const bool has_loads = std::ranges::any_of(loads_, [](const auto& loads) { return !loads.empty(); });
  float *const p = direction_.data(), *const q = multigrid.r.data();
  double first = 0, last = 0;
  error_.restart();
  while (first == 0 || last > reduction_per_round * first) {
    if (answer.iterations >= most_coupled_iterations || task_.must_stop())
      return Round::stopped;
    if (task_.control.progress)
      task_.control.progress(std::min(0.99, static_cast<double>(answer.iterations) / 30), "solving");
    const double now = multigrid.precondition();
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
    level.for_each_part(task_.team, [&](std::int64_t at, std::int64_t n, int) {
      direct_entries(n, multigrid.u.data() + at, beta, p + at);
    });
    level.apply(p, q, task_.team);
    const double curvature = multigrid.sum_over_parts([&](std::int64_t at, std::int64_t n) {
      return mask_and_dot_entries(n, level.inverse() + at, p + at, q + at);
    });
    if (!(curvature > 0))
      return Round::used_up;
    const double step = now / curvature, gain = step * now * scale_ * scale_;
    // u . K u after a step, from p . K u = p . f - p . r
    energy_ += (has_loads ? 2 * step * scale_ * work_of_forces(p) : 0) - gain;
    take_step(step, u);
    last = now;
    ++answer.iterations;
    error_.add(step, now, scale_);
    answer.residual = error_.relative_to(energy_);
    if (answer.residual <= task_.scene.relaxation.tolerance)
      return Round::finished;
  }
  scale_ *= std::sqrt(last / first);
  return Round::used_up;
}

void MatterSolver::precondition(const Displacement& residual, Displacement& correction) {
  const MatterLevel& level = multigrid_->finest();
  const double size = largest_entry(residual);
  for_each_row([&](const NodeRow& row, std::int64_t node, int n) {
    for (std::size_t c = 0; c < 3; ++c)
      for (int i = 0; i < n; ++i) {
        const std::int64_t at = static_cast<std::int64_t>(c) * level.component_stride() + row.slot + i;
        const double value = residual.component[c][static_cast<std::size_t>(node + i)];
        multigrid_->f.data()[at] =
            level.inverse()[at] > 0 && size > 0 ? static_cast<float>(value / size / level.scale()[c]) : 0;
      }
  });
  multigrid_->precondition();
  for (auto& component : correction.component)
    std::ranges::fill(component, 0.0);
  for_each_row([&](const NodeRow& row, std::int64_t node, int n) {
    for (std::size_t c = 0; c < 3; ++c)
      for (int i = 0; i < n; ++i) {
        const std::int64_t at = static_cast<std::int64_t>(c) * level.component_stride() + row.slot + i;
        if (level.inverse()[at] > 0)
          correction.component[c][static_cast<std::size_t>(node + i)] =
              size / level.unit() / level.scale()[c] * double{multigrid_->u.data()[at]};
      }
  });
}

CoupledRound MatterSolver::solve(Displacement& u, Answer& answer) {
  answer.residual = 1;
  Round round = Round::used_up;
  while (round == Round::used_up)
    round = correct(u, answer);
  if (round == Round::finished && error_.is_empty())
    answer.residual = 0;
  return round;
}

void MatterSolver::find_energy_and_reactions(const Displacement& u, Answer& answer) {
  elasticity_.apply(u, forces_, task_.team);
  double twice = 0;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < u.component[c].size(); ++i)
      twice += u.component[c][i] * forces_.component[c][i];
  answer.strain_energy = 0.5 * twice;
  for (const Prescribed& p : task_.scene.prescribed) {
    const auto c = static_cast<std::size_t>(p.component), i = static_cast<std::size_t>(p.node);
    answer.reaction.push_back(forces_.component[c][i] - (loads_[c].empty() ? 0 : loads_[c][i]));
  }
}

std::int64_t MatterSolver::bytes() const {
  std::size_t sum = direction_.bytes();
  for (const auto& loads : loads_)
    sum += loads.size() * sizeof(double);
  return multigrid_->bytes() + elasticity_.bytes() + bytes_of(forces_) + static_cast<std::int64_t>(sum);
}

bool solve_coupled_matter(const CoupledTask& task, Answer& answer) {
  answer.algorithm = "lattice elasticity, conjugate gradients around multigrid of the body's pieces";
  if (task.start != nullptr)
    answer.displacement = *task.start;
  else
    answer.displacement = Displacement(task.scene.specimen.grid);
  for (const Prescribed& p : task.prescribed)
    answer.displacement(p.component, p.node) = p.value;
  MatterSolver solver(task);
  answer.seconds.setup = task.clock.seconds();
  const CoupledRound end = solver.solve(answer.displacement, answer);
  if (end == CoupledRound::stalled)
    return solve_coupled_body(task, answer);
  const bool is_converged = end == CoupledRound::finished;
  solver.find_energy_and_reactions(answer.displacement, answer);
  if (!is_converged)
    answer.reaction.clear();
  answer.bytes = solver.bytes() + bytes_of(answer.displacement);
  if (task.limits == nullptr)
    return is_converged;
  MatterSystem system(task.scene.specimen.grid, solver.elasticity(), solver.multigrid(), task.team);
  return task.end(system, is_converged, answer.displacement, answer);
}

} // namespace maille::deform
