#include "elastic/masked/masked_solver.hpp"

#include "control/method.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "maille/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <numeric>
#include <utility>

namespace maille::deform {

void MaskedSystem::load_residual(const Displacement& residual) {
  MaskedLevel& level = multigrid_.finest();
  scale_ = largest_entry(residual) / level.matter().unit();
  if (!(scale_ > 0))
    scale_ = 1;
  load_field(
      level, team_, [&](std::size_t c) { return residual.component(c).data(); },
      level.matter().force_factors(scale_), level.f.data());
}

void MaskedSystem::store_correction(const float* found, Displacement& direction) {
  const MaskedLevel& level = multigrid_.finest();
  store_field(level, team_, found, level.matter().displacement_factors(scale_),
              [&](std::size_t c) { return direction.component(c).data(); });
}

void MaskedSystem::find_direction(const Displacement& residual, int most, double reduction,
                                  Displacement& direction) {
  load_residual(residual);
  if (!gradients_)
    gradients_.emplace(multigrid_, team_);
  gradients_->restart();
  ReductionWatch watch(most, reduction);
  conjugate_gradients(*gradients_, watch);
  store_correction(gradients_->state(), direction);
}

void MaskedSystem::precondition(const Displacement& residual, Displacement& correction) {
  load_residual(residual);
  multigrid_.precondition();
  store_correction(multigrid_.finest().u.data(), correction);
}

namespace {

/// Changed fixed components that a hierarchy tolerates; or a tenth of its fixed components, if more.
constexpr std::int64_t few_fixed = 300;
/// Change of stiffness that a hierarchy tolerates: a change by a factor k costs sqrt(k) in iterations, and
/// rebuilding is cheaper beyond this.
constexpr double largest_ratio = 2;

} // namespace

double largest_contrast(const Scene& scene) {
  double contrast = 1;
  for (const Material& material : scene.materials)
    contrast = std::max(contrast, stiffness_contrast(stiffness(material.elasticity)));
  return contrast;
}

MaskedBody::MaskedBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team,
                       Communicator* all)
    : MaskedBody(scene, prescribed, team, Slabs(scene.specimen, all)) {}

MaskedBody::MaskedBody(const Scene& scene, const std::vector<Prescribed>& prescribed, ThreadTeam& team,
                       const Slabs& slabs)
    : elasticity(scene, team, slabs.layers()),
      multigrid(std::make_unique<MaskedLevel>(scene, elasticity, prescribed, team, slabs),
                relaxation_steps(largest_contrast(scene)), team),
      fields(multigrid, team) {}

void MaskedBody::remember_fixed(const std::vector<Prescribed>& prescribed) {
  made_for_ = fixed_ = FixedMask(elasticity.grid(), prescribed);
}

void MaskedBody::set_fixed(const std::vector<Prescribed>& prescribed) {
  multigrid.set_fixed(prescribed);
  fixed_ = FixedMask(elasticity.grid(), prescribed);
  smallest_eigenvalue = 0;
}

void MaskedBody::release() {
  multigrid.release();
  fields.release_direction();
}

bool MaskedBody::is_made_for(const std::vector<Prescribed>& prescribed) {
  return FixedMask(elasticity.grid(), prescribed) == made_for_;
}

bool MaskedBody::adopt_fixed(const std::vector<Prescribed>& prescribed) {
  const FixedMask wanted(elasticity.grid(), prescribed);
  if (wanted == fixed_) {
    return true;
  }
  const std::int64_t n_other = wanted.n_differences(made_for_);
  if (n_other > few_fixed && 10 * n_other > made_for_.n_fixed())
    return false;
  set_fixed(prescribed);
  return true;
}

bool MaskedBody::adopt_materials(double ratio) {
  if (!(ratio <= largest_ratio))
    return false;
  elasticity.renew();
  multigrid.renew_matter();
  smallest_eigenvalue = 0;
  return true;
}

MaskedBody& MaskedSolver::body_of(const CoupledTask& task, std::unique_ptr<MaskedBody>& own) {
  if (task.kept == nullptr) {
    own = std::make_unique<MaskedBody>(task.scene, task.prescribed, task.team, task.control.communicator);
    return *own;
  }
  KeptBody& kept = *task.kept;
  std::vector<Prescribed> held;
  if (kept.is_for_holds)
    std::ranges::copy_if(task.prescribed, std::back_inserter(held), &Prescribed::held);
  const std::vector<Prescribed>& wanted = kept.is_for_holds ? held : task.prescribed;
  auto* body = dynamic_cast<MaskedBody*>(kept.hierarchy.get());
  if (body == nullptr || !(kept.begins_anew ? body->is_made_for(wanted) : body->adopt_fixed(wanted))) {
    kept.hierarchy.reset(); // before there are two
    auto made = std::make_unique<MaskedBody>(kept.scene(), wanted, kept.team());
    made->remember_fixed(wanted);
    body = made.get();
    kept.hierarchy = std::move(made);
  }
  if (kept.begins_anew)
    body->set_fixed(task.prescribed);
  return *body;
}

MaskedSolver::MaskedSolver(const CoupledTask& task)
    : MixedSolver(task), body_(body_of(task, own_)),
      system_(task.scene.specimen.grid, body_.elasticity, body_.multigrid, task.team) {
  begin(body_.multigrid.finest().matter().unit(), body_.smallest_eigenvalue);
  by_node_.resize(task.prescribed.size());
  std::iota(by_node_.begin(), by_node_.end(), 0);
  std::ranges::stable_sort(by_node_, {}, [&](std::int32_t i) { return task.prescribed[i].node; });
}

/// Evaluates K u and calls visit(component, first place in the fields, first node, how many, forces) for all
/// rows of its own nodes.
template<class Visit>
void MaskedSolver::find_forces(const Displacement& u, const Visit& visit) {
  const MaskedLevel& level = body_.multigrid.finest();
  const Grid& grid = task_.scene.specimen.grid;
  const PlaneRange own = level.slabs().own();
  const auto& prescribed = task_.scene.prescribed;
  struct Part {
    int plane;
    std::span<const NodeRow> rows;
    double energy;
  };
  std::vector<Part> parts; // of a window
  energies_.assign(own.end - own.first, 0);
  held_.assign(prescribed.size(), 0);
  const auto visit_window = [&](const LatticeElasticity::Window& window) {
    parts.clear();
    const int first_plane = std::max(window.first_plane, own.first);
    for (int plane = first_plane; plane < window.end_plane; ++plane)
      for (auto rows = level.rows().rows_of_planes({plane, plane + 1}); !rows.empty();
           rows = rows.subspan(parts.back().rows.size()))
        parts.push_back({plane, rows.first(std::min<std::size_t>(rows.size(), rows_per_item)), 0});
    task_.team.run(static_cast<int>(parts.size()), [&](int item, int) {
      Part& part = parts[item];
      for (const NodeRow& row : part.rows)
        for (std::size_t c = 0; c < 3; ++c) {
          const std::int64_t node = grid.node(row.first);
          const int n = row.nodes;
          const double* const forces = window.forces[c] + (node - window.first_node);
          const double* const u_of_row = window.u[c] + (node - window.first_node);
          for (int i = 0; i < n && window.u[c] != nullptr; ++i)
            part.energy += u_of_row[i] * forces[i];
          visit(c, static_cast<std::int64_t>(c) * level.component_stride() + row.slot,
                static_cast<std::size_t>(node), n, forces);
        }
    });
    for (const Part& part : parts)
      energies_[part.plane - own.first] += part.energy;
    const std::int64_t first_node = grid.node({0, 0, first_plane});
    for (std::size_t i = 0; i < prescribed.size(); ++i)
      if (const std::int64_t node = prescribed[i].node;
          node >= first_node && node < window.first_node + window.n_nodes)
        held_[i] = window.forces[prescribed[i].component][node - window.first_node];
  };
  if (u.empty())
    body_.elasticity.for_each_window(
        [&](int first, int end, const std::array<double*, 3>& to) { return put_planes(first, end, to); },
        task_.team, own, visit_window);
  else
    body_.elasticity.for_each_window(u, task_.team, own, visit_window);
  energy_ = level.slabs().total(energies_);
}

/// Puts prescribed values and the results of earlier rounds. See LatticeElasticity::PutPlanes.
bool MaskedSolver::put_planes(int first_plane, int end_plane, const std::array<double*, 3>& to) const {
  const Grid& grid = task_.scene.specimen.grid;
  const std::int64_t first_node = grid.node({0, 0, first_plane}),
                     n_nodes = grid.node({0, 0, end_plane - 1}) + grid.stride(2) - first_node;
  const auto node_of = [&](std::int32_t i) { return task_.prescribed[i].node; };
  bool is_moved = false;
  for (auto i = std::ranges::lower_bound(by_node_, first_node, {}, node_of);
       i != by_node_.end() && node_of(*i) < first_node + n_nodes; ++i) {
    const Prescribed& p = task_.prescribed[*i];
    to[p.component][p.node - first_node] = p.value;
    is_moved = is_moved || p.value != 0;
  }
  const MaskedLevel& level = body_.multigrid.finest();
  for (const NodeRow& row : level.rows().rows_of_planes({first_plane, end_plane}))
    for (std::size_t c = 0; c < 3 && !earlier_.empty(); ++c)
      add_earlier_rounds(static_cast<std::int64_t>(c) * level.component_stride() + row.slot, c, row.nodes,
                         to[c] + (grid.node(row.first) - first_node));
  return is_moved || !earlier_.empty();
}

MixedSolver::Residual MaskedSolver::begin_round(const Displacement& u, double scale) {
  MaskedLevel& level = body_.multigrid.finest();
  Residual residual;
  const Vec3 factor = level.matter().force_factors(scale);
  find_forces(u, [&](std::size_t c, std::int64_t at, std::size_t node, int n, const double* forces) {
    for (int i = 0; i < n; ++i) {
      const std::size_t k = node + static_cast<std::size_t>(i);
      const double value = (loads_[c].empty() ? 0 : loads_[c][k]) - forces[i];
      level.f.data()[at + i] = level.inverse()[at + i] > 0 ? static_cast<float>(factor[c] * value) : 0;
    }
  });
  body_.fields.restart();
  residual.energy = energy_ / level.matter().unit();
  for (const NodeRow& row : level.rows().rows_of_planes(level.slabs().own()))
    for (std::int64_t c = 0; c < 3; ++c)
      for (std::int64_t at = c * level.component_stride() + row.slot, end = at + row.nodes; at < end; ++at)
        residual.largest = std::max(residual.largest, std::abs(double{level.f.data()[at]}));
  residual.largest = level.slabs().largest(residual.largest);
  return residual;
}

double MaskedSolver::work_of_loads() {
  const MaskedLevel& level = body_.multigrid.finest();
  const float* const direction = body_.fields.direction();
  const Grid& grid = task_.scene.specimen.grid;
  const PlaneRange own = level.slabs().own();
  const Vec3 factor = level.matter().force_factors(1);
  std::vector<double> works(own.end - own.first, 0); // of planes
  for (const NodeRow& row : level.rows().rows_of_planes(own)) {
    const std::int64_t node = grid.node(row.first);
    const int n = row.nodes;
    for (std::size_t c = 0; c < 3; ++c)
      for (int i = 0; i < n && !loads_[c].empty(); ++i)
        works[row.first[2] - own.first] +=
            factor[c] * loads_[c][node + i] *
            double{direction[static_cast<std::int64_t>(c) * level.component_stride() + row.slot + i]};
  }
  return level.slabs().total(works);
}

/// Adds n slots of a float32 state. @param state of the first
void MaskedSolver::add(double scale, const float* state, std::size_t component, int n, double* to) const {
  const double factor = body_.multigrid.finest().matter().displacement_factors(scale)[component];
  for (int i = 0; i < n; ++i)
    to[i] += factor * double{state[i]};
}

void MaskedSolver::add_earlier_rounds(std::int64_t at, std::size_t component, int n, double* to) const {
  for (const Round& round : earlier_)
    add(round.scale, round.state.data() + at, component, n, to);
}

void MaskedSolver::finish_round(Displacement& u, CoupledRound end) {
  if (u.empty() && end == CoupledRound::used_up) {
    earlier_.push_back({scale(), body_.fields.take_state()});
    return;
  }
  if (u.empty()) {
    if (own_ && end != CoupledRound::stalled)
      own_->release();
    u = slabs().are_shared() ? initial_part() : task_.initial_state();
  }
  body_.multigrid.finest().for_each_row(task_.team, [&](const FieldRow& row) {
    double* const to = u.component(row.component).data() + (row.node - first_node());
    add_earlier_rounds(row.place, row.component, row.n, to);
    add(scale(), body_.fields.state() + row.place, row.component, row.n, to);
  });
  earlier_.clear();
}

Displacement MaskedSolver::initial_part() const {
  const Grid& grid = task_.scene.specimen.grid;
  const auto [first, end] = slabs().layers();
  const std::int64_t n = grid.node({0, 0, end + 1}) - first_node();
  Displacement u(3, static_cast<std::size_t>(n));
  for (const Prescribed& p : task_.prescribed)
    if (const std::int64_t at = p.node - first_node(); at >= 0 && at < n)
      u(p.component, at) = p.value;
  return u;
}

CoupledRound MaskedSolver::solve(Displacement& u, Answer& answer) {
  const std::int64_t before = answer.iterations;
  const CoupledRound end = MixedSolver::solve(u, answer);
  are_forces_of_state_ = answer.iterations == before;
  return end;
}

void MaskedSolver::find_energy_and_reactions(const Displacement& u, Answer& answer) {
  if (!are_forces_of_state_)
    find_forces(u, [](std::size_t, std::int64_t, std::size_t, int, const double*) {});
  if (slabs().are_shared()) {
    const auto of_ranks = slabs().gather(held_); // a node is in the planes of one rank
    for (std::size_t rank = 1; rank < of_ranks.size(); ++rank)
      for (std::size_t i = 0; i < held_.size(); ++i)
        held_[i] += of_ranks[rank][i];
  }
  answer.strain_energy = 0.5 * energy_ - energy_of_springs(body_.elasticity.springs(), u);
  for (std::size_t i = 0; i < held_.size(); ++i) {
    const Prescribed& p = task_.scene.prescribed[i];
    const auto& loads = loads_[p.component];
    answer.reaction.push_back(held_[i] - (loads.empty() ? 0 : loads[p.node]));
  }
}

} // namespace maille::deform
