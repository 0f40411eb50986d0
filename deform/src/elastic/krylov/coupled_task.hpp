#pragma once
/// What every solver of `coupled` is asked, and the elastic state it works on.
///
/// A task is one question: the scene, values to prescribe, limits that bind or none, a start, and a cache of
/// earlier questions. Each solver fills a CoupledSystem for its kind of body, finds the elastic state, and
/// calls limit_step, which enforces limits on that state.

#include "control/method.hpp"
#include "elastic/krylov/coupled_error.hpp"
#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <cmath>
#include <functional>
#include <vector>

namespace maille::deform {

class CoupledSystem;
class KeptBody;
struct CoupledTask;

/// The last step of every way of `coupled` where limits bind: see obey_limits() of elastic/limits.
using LimitStep = bool(const CoupledTask& task, CoupledSystem& system, bool is_converged, Displacement& u,
                       Answer& answer);

struct CoupledTask {
  const Scene& scene;
  const Control& control;
  const std::vector<Prescribed>& prescribed; ///< the scene's, cut back where limits ask for it
  ThreadTeam& team;
  const Clock& clock;
  std::function<bool()> must_stop;
  const LinkLimits* limits = nullptr; ///< null: none bind
  /// Start, on the scene's grid; prescribed components are set in it. Null: the solver's own start.
  const Displacement* start = nullptr;
  /// Last step, after the elastic answer. Null: none.
  LimitStep* limit_step = nullptr;
  /// Cache of earlier questions about this body, updated for later ones. Null: no cache.
  KeptBody* kept = nullptr;

  /// The start, or rest, with what is prescribed.
  Displacement initial_state() const {
    Displacement u = start != nullptr ? *start : Displacement(scene.specimen.grid);
    for (const Prescribed& p : prescribed)
      u(p.component, p.node) = p.value;
    return u;
  }
  /// Ends a way. @return whether the answer is what was asked for
  bool end(CoupledSystem& system, bool is_converged, Displacement& u, Answer& answer) const {
    return limit_step != nullptr ? limit_step(*this, system, is_converged, u, answer) : is_converged;
  }
};

/// How a round of conjugate gradients ended. finished: within tolerance, or at rounding level; used_up: the
/// residual has to be recomputed; stopped: by the caller or the limit of iterations; stalled: the error
/// stagnates above rounding level.
enum class CoupledRound { finished, used_up, stopped, stalled };

/// Each fills in displacement, iterations, residual, strain energy, setup time and algorithm, and the
/// reactions if it came to the end. @return false if it was stopped, or gave up: with status failed and a
/// message where it has no answer
using CoupledAlgorithm = bool(const CoupledTask& task, Answer& answer);

/// Any body in 1D, 2D and 3D: conjugate gradients around the componentwise model's multigrid. In 3D the
/// tests' oracle.
CoupledAlgorithm solve_coupled_body;
/// A box of one material in 3D: conjugate gradients around the operator's own multigrid.
/// @pre is_uniform_box(scene)
CoupledAlgorithm solve_coupled_box;

/// Any body in 3D: conjugate gradients around the operator's own multigrid, on which loosely joined pieces
/// stay apart.
CoupledAlgorithm solve_coupled_masked;

/// The quickest of them that can take the scene.
CoupledAlgorithm& coupled_algorithm(const Scene& scene);
/// Number of threads worth using for a scene, of those that the caller allows.
int coupled_threads(const Scene& scene, const Control& control);
/// Why full elasticity has no answer to the scene; empty if it has.
std::string reason_to_refuse_coupled(const Scene& scene);

/// True if every cell of a 3D grid holds the same matter, turned the same way, and it is not thin.
bool is_uniform_box(const Scene& scene);
/// True if the body is so slender, or so thin, beside its cells that rounding in float32 would move it by
/// more than its tolerance: measured on rods and plates, 1e-8 of its displacement over the operator's
/// smallest eigenvalue, as a cantilever's first mode has it, over its largest. @pre is_uniform_box(scene)
bool needs_float64(const Scene& scene);

constexpr int most_coupled_iterations = 5000;

} // namespace maille::deform
