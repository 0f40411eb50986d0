#include "maille/deform/relax/coupled.hpp"

#include "maille/scene/nodal_forces.hpp"
#include "maille/scene/rigid_motions.hpp"
#include "method.hpp"
#include "relax/lattice_elasticity.hpp"
#include "relax/legal_state.hpp"
#include "relax/separable_solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

constexpr int most_iterations = 5000;
/// Steps after which the energy that they brought says how far the state was from the answer.
constexpr std::size_t delay = 3;
constexpr std::int64_t nodes_worth_threads = 30000;

class CoupledSolve {
public:
  CoupledSolve(const Scene& scene, const Control& control);
  Answer run();

private:
  void prescribe();
  void iterate();
  void find_residual();
  void precondition();
  double dot(const Displacement& a, const Displacement& b);
  void finish();
  void obey_limits();
  bool must_stop();
  std::size_t d() const { return static_cast<std::size_t>(scene_.dimension()); }
  template<class Visit>
  void for_each_plane(const Visit& visit);

  const Scene& scene_;
  const Control& control_;
  Clock clock_;
  ThreadTeam team_;
  LatticeElasticity elasticity_;
  std::optional<LinkLimits> limits_; ///< where they bind
  Admission admission_;
  std::vector<std::unique_ptr<SeparableSolver>> separable_;
  Displacement u_, residual_, correction_, direction_, image_, diagonal_;
  std::vector<std::vector<double>> forces_; ///< empty: none along that component
  std::vector<std::vector<bool>> is_fixed_; ///< [component][node], nodes without matter too
  std::vector<double> sums_;
  Answer answer_;
  std::optional<Status> stopped_;
};

CoupledSolve::CoupledSolve(const Scene& scene, const Control& control)
    : scene_(scene), control_(control),
      team_(scene.specimen.grid.n_nodes() < nodes_worth_threads ? 1 : std::max(1, control.threads)),
      elasticity_(scene), u_(scene.specimen.grid), residual_(u_), correction_(u_), direction_(u_),
      image_(u_) {
  answer_.method = "coupled";
  admission_.prescribed = scene.prescribed;
  if (scene.limits.from != LimitSource::taut) {
    limits_.emplace(scene);
    admission_ = admit_fast(scene, *limits_, control.threads);
  }
  sums_.resize(static_cast<std::size_t>(scene.specimen.grid.nodes()[d() - 1]));
}

bool CoupledSolve::must_stop() {
  if (!stopped_)
    stopped_ = reason_to_stop(control_, clock_);
  return stopped_.has_value();
}

/// Calls visit(plane, first node, end) for the planes of nodes across the last axis.
template<class Visit>
void CoupledSolve::for_each_plane(const Visit& visit) {
  const Grid& grid = scene_.specimen.grid;
  const int planes = grid.nodes()[d() - 1];
  const auto in_plane = static_cast<std::size_t>(grid.n_nodes() / planes);
  team_.run(planes, [&](int plane, int) {
    const auto i = static_cast<std::size_t>(plane);
    visit(i, i * in_plane, (i + 1) * in_plane);
  });
}

double CoupledSolve::dot(const Displacement& a, const Displacement& b) {
  for_each_plane([&](std::size_t plane, std::size_t first, std::size_t end) {
    double sum = 0;
    for (std::size_t c = 0; c < d(); ++c)
      for (std::size_t i = first; i < end; ++i)
        sum += a.component[c][i] * b.component[c][i];
    sums_[plane] = sum;
  });
  double sum = 0;
  for (const double part : sums_)
    sum += part;
  return sum;
}

/// Prescribed values, and a start from the separable model, which knows no more than each component by itself.
void CoupledSolve::prescribe() {
  const Grid& grid = scene_.specimen.grid;
  const auto n = static_cast<std::size_t>(grid.n_nodes());
  is_fixed_.assign(d(), std::vector<bool>(n, false));
  for (std::size_t node = 0; node < n; ++node)
    if (!scene_.specimen.is_node(grid.node_at(static_cast<std::int64_t>(node))))
      for (std::size_t b = 0; b < d(); ++b)
        is_fixed_[b][node] = true;
  const CellModuli moduli(scene_);
  diagonal_ = elasticity_.diagonal();
  for (std::size_t b = 0; b < d(); ++b) {
    const int component = static_cast<int>(b);
    std::vector<FixedNode> fixed;
    for (const Prescribed& p : admission_.prescribed)
      if (p.component == component) {
        fixed.push_back({p.node, p.value});
        is_fixed_[b][static_cast<std::size_t>(p.node)] = true;
      }
    std::ranges::sort(fixed, {}, &FixedNode::node);
    forces_.push_back(nodal_forces(scene_, component));
    const bool is_at_rest = std::ranges::all_of(fixed, [](const FixedNode& f) { return f.value == 0; });
    separable_.push_back(std::make_unique<SeparableSolver>(scene_, moduli, component, fixed, team_));
    if (!is_at_rest)
      separable_[b]->solve(u_.component[b], {}, std::numeric_limits<double>::infinity(), false,
                           [this] { return must_stop(); });
    for (std::size_t node = 0; node < n; ++node)
      if (separable_[b]->has_loose_nodes() && separable_[b]->is_loose(static_cast<std::int64_t>(node)))
        u_.component[b][node] = 0;
  }
}

/// residual = f - K u where nodes are free, 0 elsewhere.
void CoupledSolve::find_residual() {
  elasticity_.apply(u_, residual_, team_);
  for (std::size_t b = 0; b < d(); ++b)
    for (std::size_t i = 0; i < residual_.component[b].size(); ++i)
      residual_.component[b][i] =
          is_fixed_[b][i] ? 0 : (forces_[b].empty() ? 0 : forces_[b][i]) - residual_.component[b][i];
}

void CoupledSolve::precondition() {
  for (std::size_t b = 0; b < d(); ++b) {
    SeparableSolver& solver = *separable_[b];
    solver.precondition(residual_.component[b], correction_.component[b]);
    for (std::size_t i = 0; i < correction_.component[b].size(); ++i) {
      if (is_fixed_[b][i])
        correction_.component[b][i] = 0;
      else if (solver.has_loose_nodes() && solver.is_loose(static_cast<std::int64_t>(i)))
        correction_.component[b][i] = residual_.component[b][i] / diagonal_.component[b][i];
    }
  }
}

void CoupledSolve::iterate() {
  find_residual();
  std::vector<double> gains; // energy that each step brought
  double last = 0, last_mixed = 0;
  answer_.residual = 1;
  const double reference = std::sqrt(std::numeric_limits<double>::min());
  while (answer_.iterations < most_iterations && !must_stop()) {
    if (control_.progress)
      control_.progress(std::min(0.99, static_cast<double>(answer_.iterations) / 30), "solving");
    precondition();
    const double now = dot(residual_, correction_);
    if (!(now > 0)) { // nothing is left, or nothing that can be told from rounding
      answer_.residual = gains.empty() ? 0 : answer_.residual;
      return;
    }
    // Float32 inside makes the preconditioner a little different every time: Polak and Ribiere's beta.
    const double beta = last > 0 ? std::max(0.0, (now - last_mixed) / last) : 0;
    for_each_plane([&](std::size_t, std::size_t first, std::size_t end) {
      for (std::size_t b = 0; b < d(); ++b)
        for (std::size_t i = first; i < end; ++i)
          direction_.component[b][i] = correction_.component[b][i] + beta * direction_.component[b][i];
    });
    elasticity_.apply(direction_, image_, team_);
    const double curvature = dot(direction_, image_);
    if (!(curvature > 0))
      return;
    const double step = dot(residual_, direction_) / curvature;
    for_each_plane([&](std::size_t plane, std::size_t first, std::size_t end) {
      double mixed = 0;
      for (std::size_t b = 0; b < d(); ++b)
        for (std::size_t i = first; i < end; ++i) {
          u_.component[b][i] += step * direction_.component[b][i];
          if (!is_fixed_[b][i])
            residual_.component[b][i] -= step * image_.component[b][i];
          mixed += residual_.component[b][i] * correction_.component[b][i];
        }
      sums_[plane] = mixed;
    });
    last_mixed = 0;
    for (const double part : sums_)
      last_mixed += part;
    last = now;
    ++answer_.iterations;
    gains.push_back(step * step * curvature);
    if (gains.size() < delay)
      continue;
    double recent = 0;
    for (std::size_t i = gains.size() - delay; i < gains.size(); ++i)
      recent += gains[i];
    elasticity_.apply(u_, image_, team_);
    const double energy = std::max(dot(u_, image_), reference);
    answer_.residual = std::sqrt(recent / energy);
    if (answer_.residual <= scene_.relaxation.tolerance)
      return;
  }
  if (!stopped_)
    stopped_ = Status::budget_reached;
}

/// Energy, and what holds every prescribed component there.
void CoupledSolve::finish() {
  elasticity_.apply(u_, image_, team_);
  answer_.strain_energy = 0.5 * dot(u_, image_);
  if (!stopped_)
    for (const Prescribed& p : scene_.prescribed) {
      const auto b = static_cast<std::size_t>(p.component), i = static_cast<std::size_t>(p.node);
      answer_.reaction.push_back(image_.component[b][i] - (forces_[b].empty() ? 0 : forces_[b][i]));
    }
  answer_.displacement = std::move(u_);
}

void CoupledSolve::obey_limits() {
  if (!limits_)
    return;
  double largest = 0;
  for (const auto& component : answer_.displacement.component)
    for (const double value : component)
      largest = std::max(largest, std::abs(value));
  const Vec3& h = scene_.specimen.grid.spacing();
  const double rest = *std::min_element(h.begin(), h.begin() + scene_.dimension());
  if (largest_violation(scene_, *limits_, answer_.displacement) * rest <=
      rounding_tolerance(scene_.specimen.grid, largest))
    return;
  make_legal(scene_, *limits_, admission_.prescribed, answer_.displacement, control_.threads);
  answer_.reaction.clear();
  answer_.message = "limits are active: the elastic answer was brought to the nearest legal state, which is "
                    "not the least energy "
                    "within them";
}

Answer CoupledSolve::run() {
  prescribe();
  answer_.seconds.setup = clock_.seconds();
  iterate();
  finish();
  obey_limits();
  if (const std::string cut = describe(scene_, admission_); !cut.empty())
    answer_.message = answer_.message.empty() ? cut : cut + "; " + answer_.message;
  answer_.algorithm = "lattice elasticity, conjugate gradients around separable multigrid";
  answer_.status = stopped_ ? *stopped_ : admission_.n_cut > 0 ? Status::clamped : Status::done;
  answer_.seconds.solve = clock_.seconds() - answer_.seconds.setup;
  answer_.bytes = 6 * bytes_of(answer_.displacement) + elasticity_.bytes() + (limits_ ? limits_->bytes() : 0);
  for (std::size_t b = 0; b < d(); ++b)
    answer_.bytes += separable_[b]->bytes() +
                     static_cast<std::int64_t>(forces_[b].size() * sizeof(double) + is_fixed_[b].size() / 8);
  return std::move(answer_);
}

} // namespace

Answer solve_coupled(const Scene& scene, const Control& control) {
  Scene without_loads; // what reason_to_refuse says beside loads
  without_loads.prescribed = scene.prescribed;
  if (std::string reason = reason_to_refuse(without_loads, "coupled"); !reason.empty())
    return refusal("coupled", std::move(reason));
  if (scene.prescribed.empty())
    return refusal("coupled", "nothing is held or moved, so the body can move anywhere");
  if (std::string motion = remaining_rigid_motion(scene); !motion.empty())
    return refusal("coupled", motion + ": hold or move more of it");
  return CoupledSolve(scene, control).run();
}

} // namespace maille::deform
