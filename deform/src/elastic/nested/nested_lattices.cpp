#include "elastic/nested/nested_lattices.hpp"

#include "elastic/resample/coarser_scene.hpp"
#include "feasible/feasible_set.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

namespace {

/// Largest ratio of successive differences that is used: a larger one corrects beyond order 1. Above
/// `no_ratio` differences are no geometric series: a node takes the ratio of the body, a body is left
/// alone.
constexpr double largest_ratio = 0.5, no_ratio = 0.75;
/// Lattices that differ by more of their answer are too coarse to extrapolate from.
constexpr double largest_difference = 0.25;

std::size_t of(std::int64_t i) {
  return static_cast<std::size_t>(i);
}

/// fine - coarse at the nodes of `coarse` that are nodes of the body, 0 elsewhere.
Displacement difference(const Grid& fine, const Displacement& u, const LatticeAnswer& coarse) {
  const Grid& grid = coarse.body.grid;
  Displacement out(grid);
  for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
    Index3 at = grid.node_at(node);
    if (!coarse.body.is_node(at))
      continue;
    for (int a = 0; a < grid.dimension(); ++a)
      at[of(a)] *= 2;
    const std::int64_t twin = fine.node(at);
    for (int b = 0; b < grid.dimension(); ++b)
      out(b, node) = u(b, twin) - coarse.u(b, node);
  }
  return out;
}

/// Euclidean products over components at a node, or over all of them.
struct Products {
  double change = 0, mixed = 0, coarse = 0; ///< (u_h - u_2h)^2, its product with u_2h - u_4h, (u_2h - u_4h)^2

  void add(const Displacement& finer, std::int64_t twin, const Displacement& coarser, std::int64_t node) {
    for (std::size_t b = 0; b < coarser.n_components(); ++b) {
      const double first = finer(b, twin), second = coarser(b, node);
      change += first * first, mixed += first * second, coarse += second * second;
    }
  }
  double ratio() const { return coarse > 0 ? mixed / coarse : 0; }
};

/// Missing part over the last change.
double factor_of(double ratio) {
  const double q = std::clamp(ratio, 0.0, largest_ratio);
  return q / (1 - q);
}

/// Ratios at the nodes of the coarsest lattice.
class ObservedRatios {
public:
  ObservedRatios(const Grid& finer, const Displacement& change, const Grid& grid, const Displacement& coarse)
      : factor(of(grid.n_nodes()), 0) {
    std::vector<Products> products(factor.size());
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      Index3 at = grid.node_at(node);
      for (int a = 0; a < grid.dimension(); ++a)
        at[of(a)] *= 2;
      products[of(node)].add(change, finer.node(at), coarse, node);
      Products& p = products[of(node)];
      all_.change += p.change, all_.mixed += p.mixed, all_.coarse += p.coarse;
    }
    for (std::size_t node = 0; node < factor.size(); ++node) {
      const double ratio = products[node].ratio();
      factor[node] = factor_of(ratio > no_ratio ? all_.ratio() : ratio);
      n_free_ += products[node].coarse > 0 ? 1 : 0;
      n_used_ += factor[node] > 0 ? 1 : 0;
    }
  }
  double of_the_body() const { return all_.ratio(); }
  double share() const {
    return n_free_ > 0 ? static_cast<double>(n_used_) / static_cast<double>(n_free_) : 0;
  }

  std::vector<double> factor;

private:
  Products all_;
  std::int64_t n_free_ = 0, n_used_ = 0;
};

void add_where_free(const std::vector<double>& correction, const std::vector<Prescribed>& prescribed, int b,
                    std::span<double> u) {
  std::vector<double> kept;
  for (const Prescribed& p : prescribed)
    if (p.component == b)
      kept.push_back(u[of(p.node)]);
  for (std::size_t i = 0; i < u.size(); ++i)
    u[i] += correction[i];
  auto value = kept.begin();
  for (const Prescribed& p : prescribed)
    if (p.component == b)
      u[of(p.node)] = *value++;
}

} // namespace

Extrapolated extrapolate(const LatticeAnswer& twice, const LatticeAnswer& four_times, const CoupledTask& task,
                         Displacement& u) {
  const Specimen& body = task.scene.specimen;
  Displacement change = difference(body.grid, u, twice);
  const Displacement coarse = difference(twice.body.grid, twice.u, four_times);
  ObservedRatios ratios(twice.body.grid, change, four_times.body.grid, coarse);
  Extrapolated result;
  const double size = std::sqrt(product(twice.u, twice.u)), changed = std::sqrt(product(change, change));
  if (changed > largest_difference * size) {
    result.reason = fmt::format("the last two lattices differ by {:.2g} %", 100 * changed / size);
    return result;
  }
  if (!(ratios.of_the_body() > 0 && ratios.of_the_body() <= no_ratio)) {
    result.reason = fmt::format("differences of three lattices show a ratio of {:.2g}", ratios.of_the_body());
    return result;
  }
  result.share = ratios.share();
  std::vector<double> factor(of(twice.body.grid.n_nodes()), 0), correction(of(body.grid.n_nodes()), 0);
  interpolate(four_times.body, ratios.factor, twice.body, factor, task.team);
  for (int b = 0; b < body.grid.dimension(); ++b) {
    const std::span<double> missing = change.component(b);
    for (std::size_t i = 0; i < missing.size(); ++i)
      missing[i] *= factor[i];
    interpolate(twice.body, missing, body, correction, task.team);
    add_where_free(correction, task.prescribed, b, u.component(b));
  }
  return result;
}

namespace {

/// The question on every second node with its answer, and recursively on coarser lattices.
struct Coarser {
  Scene scene;
  Displacement u;
  std::unique_ptr<Coarser> coarser;
  double set_up = 0; ///< seconds on the clock that went into preparation so far
};

class NestedSolve {
public:
  NestedSolve(const CoupledTask& task, CoupledAlgorithm& way) : task_(task), way_(way) {}
  bool run(Answer& answer);

private:
  std::string find_coarser();
  void solve(Coarser& level);
  bool solve_from(Coarser* coarser, CoupledTask task, Answer& answer);
  void extrapolate_answer(Answer& answer);

  const CoupledTask& task_;
  CoupledAlgorithm& way_;
  std::unique_ptr<Coarser> coarser_;
};

/// Builds the coarser scenes for extrapolation. @return why they cannot be built; empty if they can
std::string NestedSolve::find_coarser() {
  const Scene* fine = &task_.scene;
  const std::vector<Prescribed>* prescribed = &task_.prescribed;
  std::unique_ptr<Coarser>* next = &coarser_;
  for (int halvings = 0; halvings < 2; ++halvings) {
    std::optional<Scene> made = coarser_scene(*fine, *prescribed);
    if (!made)
      return "not extrapolated: three lattices need cells that can be halved twice along every axis, to 4 or "
             "more, "
             "and are held at every fourth node";
    *next = std::make_unique<Coarser>();
    Scene& coarse = (*next)->scene = *std::move(made);
    if (const std::string lost = what_coarsening_loses(coarse, *fine, *prescribed); !lost.empty())
      return "not extrapolated: " + lost;
    fine = &coarse;
    prescribed = &coarse.prescribed;
    next = &(*next)->coarser;
  }
  return {};
}

bool NestedSolve::solve_from(Coarser* coarser, CoupledTask task, Answer& answer) {
  Displacement start;
  double coarse_solves = 0; // seconds
  if (coarser != nullptr) {
    solve(*coarser);
    coarse_solves = task.clock.seconds() - coarser->set_up;
    if (!coarser->u.empty()) {
      start = Displacement(task.scene.specimen.grid);
      interpolate(coarser->scene.specimen, coarser->u.values(), task.scene.specimen, start.values(),
                  task.team);
      task.start = &start;
    }
  }
  const bool is_converged = way_(task, answer);
  answer.seconds.setup -= coarse_solves;
  return is_converged;
}

void NestedSolve::solve(Coarser& level) {
  Control quiet;
  quiet.threads = task_.control.threads;
  const CoupledTask task{level.scene, quiet,       level.scene.prescribed,
                         task_.team,  task_.clock, task_.must_stop};
  Answer answer;
  solve_from(level.coarser.get(), task, answer);
  level.u = std::move(answer.displacement);
  level.set_up = answer.seconds.setup;
}

void NestedSolve::extrapolate_answer(Answer& answer) {
  const Extrapolated found =
      extrapolate({coarser_->scene.specimen, coarser_->u},
                  {coarser_->coarser->scene.specimen, coarser_->coarser->u}, task_, answer.displacement);
  answer.extrapolated = found.share;
  if (!found.reason.empty()) {
    answer.message = "not extrapolated: " + found.reason;
    return;
  }
  answer.algorithm +=
      fmt::format(", extrapolated from three lattices at {:.0f} % of the nodes", 100 * found.share);
  if (task_.limits != nullptr)
    FeasibleSet(task_.scene, *task_.limits, task_.control.threads)
        .bring_in(task_.prescribed, answer.displacement);
}

bool NestedSolve::run(Answer& answer) {
  std::string reason;
  const bool is_asked = task_.scene.relaxation.extrapolation == Extrapolation::nested;
  if (is_asked) {
    answer.extrapolated = 0;
    reason =
        task_.scene.specimen.has_weights() || !task_.scene.springs.empty() || !task_.scene.tied.ties.empty()
            ? "not extrapolated: cells have weights, borders slide, or there are springs to the ground"
            : find_coarser();
    if (!reason.empty())
      coarser_.reset();
  }
  const bool is_converged = solve_from(coarser_.get(), task_, answer);
  const bool limits_are_active = !answer.message.empty(); // nothing else sets a message
  if (is_asked && is_converged && !task_.must_stop()) {
    if (reason.empty() && (coarser_->u.empty() || coarser_->coarser->u.empty()))
      reason = "not extrapolated: a coarser lattice has no answer";
    if (reason.empty() && limits_are_active)
      reason = "not extrapolated, because limits are active";
    if (reason.empty())
      extrapolate_answer(answer);
    else
      answer.message += (limits_are_active ? "; " : "") + reason;
  }
  return is_converged;
}

} // namespace

bool solve_on_nested_lattices(const CoupledTask& task, CoupledAlgorithm& way, Answer& answer) {
  return NestedSolve(task, way).run(answer);
}

} // namespace maille::deform
