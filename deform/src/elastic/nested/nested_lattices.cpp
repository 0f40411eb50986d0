#include "elastic/nested/nested_lattices.hpp"

#include "elastic/nested/extrapolation.hpp"
#include "elastic/resample/coarser_scene.hpp"
#include "elastic/resample/interpolation.hpp"
#include "feasible/legal_state.hpp"

#include <fmt/format.h>

#include <memory>

namespace maille::deform {

namespace {

/// Of coarser lattices, so that the algebra adds less to their differences than the finest adds.
constexpr double share_of_tolerance = 0.25;

/// The question on every second node with its answer, and likewise with coarser ones.
struct Coarser {
  Scene scene;
  Displacement u;
  std::unique_ptr<Coarser> coarser;
  double set_up = 0; ///< seconds on the clock that went into preparation so far
};

class NestedSolve {
public:
  NestedSolve(const CoupledTask& task, CoupledWay& way) : task_(task), way_(way) {}
  bool run(Answer& answer);

private:
  std::string find_coarser();
  std::unique_ptr<Coarser> coarsened(const Scene& scene, const std::vector<Prescribed>& prescribed) const;
  void solve(Coarser& level);
  bool solve_from(Coarser* coarser, CoupledTask task, Answer& answer);
  void extrapolate_answer(Answer& answer);

  const CoupledTask& task_;
  CoupledWay& way_;
  std::unique_ptr<Coarser> coarser_;
};

std::unique_ptr<Coarser> NestedSolve::coarsened(const Scene& scene,
                                                const std::vector<Prescribed>& prescribed) const {
  std::optional<Scene> coarse = coarser_scene(scene, prescribed);
  if (!coarse)
    return nullptr;
  auto level = std::make_unique<Coarser>();
  level->scene = std::move(*coarse);
  return level;
}

/// What extrapolation needs. @return why there is none; empty if there is
std::string NestedSolve::find_coarser() {
  const Scene* fine = &task_.scene;
  const std::vector<Prescribed>* prescribed = &task_.prescribed;
  std::unique_ptr<Coarser>* next = &coarser_;
  for (int halvings = 0; halvings < 2; ++halvings) {
    *next = coarsened(*fine, *prescribed);
    if (!*next)
      return "not extrapolated: three lattices need cells that can be halved twice along every axis, to 4 or "
             "more, "
             "and are held at every fourth node";
    Scene& coarse = (*next)->scene;
    if (const std::string lost = what_coarsening_loses(coarse, *fine, *prescribed); !lost.empty())
      return "not extrapolated: " + lost;
    coarse.relaxation.tolerance = share_of_tolerance * task_.scene.relaxation.tolerance;
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
    if (!coarser->u.component.empty()) {
      start = Displacement(task.scene.specimen.grid);
      interpolate(coarser->scene.specimen, coarser->u, task.scene.specimen, start, task.team);
      task.start = &start;
    }
  }
  const bool is_converged = way_(task, answer);
  answer.seconds.setup -= coarse_solves;
  answer.bytes += bytes_of(start);
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
  answer.bytes += found.bytes + bytes_of(coarser_->u) + bytes_of(coarser_->coarser->u);
  answer.extrapolated = found.share;
  if (!found.reason.empty()) {
    answer.message = "not extrapolated: " + found.reason;
    return;
  }
  answer.algorithm +=
      fmt::format(", extrapolated from three lattices at {:.0f} % of the nodes", 100 * found.share);
  if (task_.limits != nullptr)
    make_legal(task_.scene, *task_.limits, task_.prescribed, answer.displacement, task_.control.threads);
}

bool NestedSolve::run(Answer& answer) {
  std::string reason;
  const bool is_asked = task_.scene.relaxation.extrapolation == Extrapolation::nested;
  if (is_asked) {
    answer.extrapolated = 0;
    reason = find_coarser();
    if (!reason.empty())
      coarser_.reset();
  }
  const bool is_converged = solve_from(coarser_.get(), task_, answer);
  const bool limits_are_active = !answer.message.empty(); // nothing else has anything to say
  if (is_asked && is_converged && !task_.must_stop()) {
    if (reason.empty() && (coarser_->u.component.empty() || coarser_->coarser->u.component.empty()))
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

bool solve_on_nested_lattices(const CoupledTask& task, CoupledWay& way, Answer& answer) {
  return NestedSolve(task, way).run(answer);
}

} // namespace maille::deform
